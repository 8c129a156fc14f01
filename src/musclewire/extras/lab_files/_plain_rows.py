"""Rows of nothing but numbers, read from the bytes of a large text file by compiled code.

Whatever else is in the file ends this, and the rules for lines take over from there.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner

_PIECE = 1 << 22  # bytes read together: enough to be fast, and few enough to take little memory
# Both are exact as floats, so that one multiplication or division gives what ``float()`` gives (53 bits: 15 digits, and
# the powers of ten of up to 22).
_MAX_MANTISSA = 10**15
_MAX_POWER = 22
_POWERS = 10.0 ** np.arange(_MAX_POWER + 1)


@compiled_inner
def digits_at(text: np.ndarray[tuple[int], np.dtype[np.uint8]], place: int, decimal: int) -> tuple[int, int, int]:
    """Return the digits from a place on as an integer, the power of ten they have, and where they end; -1 for none."""
    mantissa, seen, power, point = 0, 0, 0, False
    while place < text.size:
        sign = text[place]
        if 48 <= sign <= 57:
            mantissa = 10 * mantissa + (sign - 48)
            seen += 1
            power -= 1 if point else 0
        elif sign == decimal and not point:
            point = True
        else:
            break
        place += 1
        if mantissa >= _MAX_MANTISSA:
            return 0, 0, -1
    return mantissa, power, place if seen else -1


@compiled_inner
def number_at(text: np.ndarray[tuple[int], np.dtype[np.uint8]], place: int, decimal: int) -> tuple[float, int]:
    """Return the number from a place on and where it ends, -1 if it is none or has to be looked at."""
    negative = place < text.size and text[place] == 45  # minus
    if negative or (place < text.size and text[place] == 43):  # plus
        place += 1
    mantissa, power, place = digits_at(text, place, decimal)
    if 0 <= place < text.size and (text[place] == 69 or text[place] == 101):  # E, e
        place += 1
        down = place < text.size and text[place] == 45
        if down or (place < text.size and text[place] == 43):
            place += 1
        exponent, _, place = digits_at(text, place, -1)
        power += -exponent if down else exponent
    if place < 0 or power < -_MAX_POWER or power > _MAX_POWER:
        return 0.0, -1
    value = float(mantissa)
    value = value / _POWERS[-power] if power < 0 else value * _POWERS[power]
    return -value if negative else value, place


@compiled
def numbers_in(
    text: np.ndarray[tuple[int], np.dtype[np.uint8]], separator: int, decimal: int, table: FloatArray
) -> tuple[int, int]:
    """Fill ``table``, (n_rows, width), up to a line that is not numbers; return how many rows, and where it begins."""
    rows, width = table.shape
    place = 0
    for row in range(rows):
        start = place
        for column in range(width):
            table[row, column], place = number_at(text, place, decimal)
            if place < 0:
                return row, start
            if column < width - 1:
                if place >= text.size or text[place] != separator:
                    return row, start
                place += 1
        if place < text.size and text[place] == 13:  # carriage return
            place += 1
        if place >= text.size or text[place] != 10:  # new line
            return row, start
        place += 1
    return rows, place


class PlainRows:
    """The rows from a line of a file on, as long as they are plain; ``finished`` says whether that was to its end."""

    def __init__(self, path: Path, first_line: int, separator: str, width: int, decimal: str) -> None:
        """Take the file, the number of its first row from 1, and how its numbers are written."""
        self._path, self._first_line, self._width = path, first_line, width
        self._separator, self._decimal = ord(separator), ord(decimal)
        self.finished = False

    def __iter__(self) -> Iterator[FloatArray]:
        """Yield pieces of the table, (n_rows, width)."""
        with self._path.open("rb") as file:
            for _ in range(self._first_line - 1):
                if b"\r" in file.readline().removesuffix(b"\r\n"):
                    return
            rest = b""
            while piece := file.read(_PIECE):
                whole, newline, rest = (rest + piece).rpartition(b"\n")
                table, is_plain = self._numbers(whole + newline)
                if len(table):
                    yield table
                if not is_plain:
                    return
            # A last line without its end may be cut off: it is looked at.
            self.finished = not rest

    def _numbers(self, piece: bytes) -> tuple[FloatArray, bool]:
        """Return the plain rows at the beginning of whole lines, and whether these are all."""
        text = np.frombuffer(piece, dtype=np.uint8)
        table = np.empty((piece.count(b"\n"), self._width))
        rows, end = numbers_in(text, self._separator, self._decimal, table)
        return table[:rows], end == text.size
