"""Rows of nothing but numbers, read from the bytes of a large text file by compiled code.

Whatever else is in the file ends this, and the rules for lines take over from there.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner

_Bytes = np.ndarray[tuple[int], np.dtype[np.uint8]]

_PIECE = 1 << 22  # bytes read together: enough to be fast, and few enough to take little memory
# Both are exact as floats, so that one multiplication or division gives what ``float()`` gives (53 bits: 15 digits, and
# the powers of ten of up to 22).
_MAX_MANTISSA = 10**15
_MAX_POWER = 22
_POWERS = 10.0 ** np.arange(_MAX_POWER + 1)
_PLUS, _MINUS, _ZERO, _NINE, _CAPITAL_E, _SMALL_E, _RETURN, _NEW_LINE = b"+-09Ee\r\n"


@compiled_inner
def digits_at(text: _Bytes, place: int, value: int) -> tuple[int, int]:
    """Return an integer with the digits from a place on behind its own, and where they end or become too many."""
    while _ZERO <= text[place] <= _NINE and value < _MAX_MANTISSA:
        value = 10 * value + (text[place] - _ZERO)
        place += 1
    return value, place


@compiled_inner
def number_at(text: _Bytes, place: int, decimal: int) -> tuple[float, int]:
    """Return the number from a place on and where it ends, -1 if it is none or has to be looked at."""
    negative = text[place] == _MINUS
    first = place + 1 if negative or text[place] == _PLUS else place
    mantissa, place = digits_at(text, first, 0)
    count, power = place - first, 0
    if text[place] == decimal:
        mantissa, end = digits_at(text, place + 1, mantissa)
        power = place + 1 - end
        count, place = count - power, end
    if text[place] == _CAPITAL_E or text[place] == _SMALL_E:
        place += 1
        down = text[place] == _MINUS
        first = place + 1 if down or text[place] == _PLUS else place
        exponent, place = digits_at(text, first, 0)
        power += -exponent if down else exponent
        count = min(count, place - first)
    if count < 1 or mantissa >= _MAX_MANTISSA or abs(power) > _MAX_POWER:
        return 0.0, -1
    value = mantissa / _POWERS[-power] if power < 0 else mantissa * _POWERS[power]
    return -value if negative else value, place


@compiled
def numbers_in(text: _Bytes, separator: int, decimal: int, table: FloatArray) -> tuple[int, int]:
    """Fill ``table``, a row for each line, up to one that is not numbers; return how many, and where that begins."""
    rows, width = table.shape
    place = 0
    # Every line has its end, at which a number stops at the latest: no place is beyond the text.
    for row in range(rows):
        start = place
        for column in range(width):
            table[row, column], place = number_at(text, place, decimal)
            is_last = column == width - 1
            if is_last and place >= 0 and text[place] == _RETURN:
                place += 1
            if place < 0 or text[place] != (_NEW_LINE if is_last else separator):
                return row, start
            place += 1
    return rows, place


def plain_rows(
    path: Path, first_line: int, separator: str, width: int, decimal: str
) -> Iterator[tuple[FloatArray, bool]]:
    """Yield pieces of the table, (n_rows, width), from a line of a file on, and whether the file ends with that one."""
    with path.open("rb") as file:
        # A carriage return alone ends a line too.
        if any(b"\r" in file.readline().removesuffix(b"\r\n") for _ in range(first_line - 1)):
            return
        rest = b""
        while piece := file.read(_PIECE):
            whole, newline, rest = (rest + piece).rpartition(b"\n")
            text = np.frombuffer(whole + newline, dtype=np.uint8)
            table = np.empty((np.count_nonzero(text == _NEW_LINE), width))
            count, end = numbers_in(text, ord(separator), ord(decimal), table)
            if count:
                # A last line without its end may be cut off: it is looked at.
                yield table[:count], end == text.size and not rest and not file.peek(1)
            if end < text.size:
                return
