"""The rows above the numbers of a table in text: names, units below them, groups of columns above them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

from musclewire.errors import RecordingError
from musclewire.signals._number_style import looks_numeric

_SPACED_HEADER = re.compile(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")
_BRACKETED = re.compile(r"\s*[\[(<{](.*)[\])>}]\s*")
_LABEL = re.compile(r"(?:data)?\s*(?:units?|einheit(?:en)?)\s*:?", re.IGNORECASE)
# Words of two groups of columns next to each other.
_BRANCHES = re.compile(r"heat|cool|aufheiz|abkühl|erwärm|load|forward|reverse|up\b|down\b", re.IGNORECASE)


def header_rows(
    above: Sequence[Sequence[str]], width: int, is_unit: Callable[[str], bool]
) -> tuple[tuple[str, ...], tuple[str | None, ...], int]:
    """Return names, units from a row of their own, and how many rows above the numbers are used; 0 if none fits."""
    rows = [[_one_line(cell) for cell in row] for row in above]
    while rows and not any(rows[-1]):
        rows = rows[:-1]
    blank = len(above) - len(rows)
    if not rows or not _fits(rows[-1], width):
        return (), (), 0
    units: tuple[str | None, ...] = ()
    used = 1
    if len(rows) > 1 and _is_units(rows[-1], is_unit) and _fits(rows[-2], width) and not _is_units(rows[-2], is_unit):
        units = tuple(_bare_unit(cell) or None for cell in rows[-1])
        rows, used = rows[:-1], 2
    names = [rows[-1]]
    if len(rows) > 1 and _are_groups(rows[-2], rows[-1]):
        names, used = [_spread(rows[-2], len(rows[-1])), rows[-1]], used + 1
    return joined_headers(names), units, used + blank


def joined_headers(rows: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Return one header a column from the rows of headers, without blank ones at the end."""
    count = max(map(len, rows), default=0)
    cells = ([row[index] for row in rows if index < len(row)] for index in range(count))
    headers = [" ".join(_one_line(cell) for cell in column if cell.strip()) for column in cells]
    while headers and not headers[-1]:
        headers.pop()
    return tuple(headers)


def spaced_headers(line: str, width: int, path: str) -> list[str]:
    """Return headers that may contain spaces themselves ("Time [s]  Wire voltage [V]") as ``width`` cells."""
    ways: tuple[Callable[[str], list[str]], ...] = (
        _SPACED_HEADER.findall,
        lambda text: re.split(r"\s{2,}", text.strip()),
        str.split,
    )
    for way in ways:
        headers = way(line)
        if len(headers) == width:
            return headers
    raise RecordingError(
        f"{path}: the headers do not fit the {width} numbers below them; separate columns with commas or tabs"
    )


def _one_line(cell: str) -> str:
    return " ".join("".join(letter if letter.isprintable() else " " for letter in cell).split())


def _fits(row: Sequence[str], width: int) -> bool:
    """Return whether a row may be headers and not a title, which fills only its first cells."""
    filled = sum(bool(cell) for cell in row)
    return filled >= max(1, (width + 1) // 2)


def _is_units(row: Sequence[str], is_unit: Callable[[str], bool]) -> bool:
    filled = [cell for cell in row if cell]
    # A row of units may say so itself, in a column that holds no numbers.
    filled = filled[1:] if filled and _LABEL.fullmatch(filled[0]) else filled
    return bool(filled) and all(_BRACKETED.fullmatch(cell) or is_unit(cell) for cell in filled)


def _bare_unit(cell: str) -> str:
    match = _BRACKETED.fullmatch(cell)
    return match[1].strip() if match else cell


def _are_groups(upper: Sequence[str], lower: Sequence[str]) -> bool:
    """Return whether a row names groups of the columns below: each begins a group, and names below are repeated."""
    filled = [index for index, cell in enumerate(upper) if cell]
    if any(looks_numeric(upper[index]) for index in filled):
        return False
    repeated = len(set(filter(None, lower))) < sum(map(bool, lower))
    named = sum(_BRANCHES.search(upper[index]) is not None for index in filled) > 1
    return len(filled) > 1 and (repeated or named) and len(filled) <= len(lower)


def _spread(row: Sequence[str], count: int) -> list[str]:
    """Return a row in which a blank cell repeats the name to its left, as a merged cell means it."""
    spread: list[str] = []
    for index in range(count):
        cell = row[index] if index < len(row) else ""
        spread.append(cell or (spread[-1] if spread else ""))
    return spread
