"""Where the table of a sheet begins: titles and parameters above it, names in one row, perhaps units in the next."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, time, timedelta
from typing import Any

from musclewire.signals import split_header

__all__ = ["SheetLayout", "layout_of", "number_of_text"]

MAX_UNIT_LENGTH = 12
_NUMBER_AS_TEXT = re.compile(r"[+-]?[0-9]+(?:[.,][0-9]+)?(?:[eE][+-]?[0-9]+)?")
_DATE_AS_TEXT = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2}[T ][0-9]{2}:")


@dataclass(frozen=True)
class SheetLayout:
    """Names and units of the columns (none: ""), where the numbers begin (from 0), and entries above the table."""

    headers: tuple[str, ...]
    units: tuple[str, ...]
    first_row: int
    width: int
    entries: Mapping[str, object] = field(default_factory=dict)

    def unit_of(self, index: int) -> str | None:
        """Return the unit that the row of units states for a column, without brackets; None without one."""
        unit = self.units[index].strip("[]() ") if index < len(self.units) else ""
        return unit or None


def layout_of(rows: Sequence[Sequence[Any]]) -> SheetLayout | None:
    """Return the layout of a sheet by its first rows, or None if no row of them is the first of a table.

    Such a row and the next have numbers or dates in the same columns; of several the one with most of them is taken,
    so that a list of parameters above the table is not taken for it.
    """
    best: tuple[int, int] | None = None
    for number in range(len(rows) - 1):
        numeric = _numeric(rows[number])
        begins = numeric & _numeric(rows[number + 1]) and not numeric <= _numeric(_row(rows, number - 1))
        if begins and (best is None or len(numeric) > best[0]) and _has_names(rows, number, numeric):
            best = len(numeric), number
    return None if best is None else _layout(rows, best[1])


def _row(rows: Sequence[Sequence[Any]], number: int) -> Sequence[Any]:
    return rows[number] if number >= 0 else ()


def _has_names(rows: Sequence[Sequence[Any]], number: int, numeric: set[int]) -> bool:
    return number == 0 or any(_text(_row(rows, number - 1), index) for index in numeric) or len(numeric) > 1


def _layout(rows: Sequence[Sequence[Any]], first: int) -> SheetLayout:
    numeric = _numeric(rows[first])
    width = max(len(rows[first]), max(numeric) + 1)
    names = _row(rows, first - 1)
    units: Sequence[Any] = ()
    above = first - 1
    if _are_units(names, numeric) and any(_text(_row(rows, first - 2), index) for index in numeric):
        names, units, above = _row(rows, first - 2), names, first - 2
    if not any(_text(names, index) for index in range(width)):
        return SheetLayout((), (), first, width, _entries(rows[:first]))
    headers = tuple(_text(names, index) for index in range(max(width, len(names))))
    texts = tuple(_text(units, index) for index in range(len(headers)))
    return SheetLayout(headers, texts, first, len(headers), _entries(rows[: max(above, 0)]))


def _numeric(row: Sequence[Any]) -> set[int]:
    return {index for index, value in enumerate(row) if _is_numeric(value)}


def _is_numeric(value: Any) -> bool:
    """Return whether a cell holds a number, a date or a time, kept as such or as text."""
    if isinstance(value, str):
        return bool(_NUMBER_AS_TEXT.fullmatch(value.strip()) or _DATE_AS_TEXT.match(value.strip()))
    return isinstance(value, (int, float, date, time, timedelta)) and not isinstance(value, bool)


def number_of_text(text: str) -> float | None:
    """Return the number that a cell keeps as text, with point or comma; NaN for an empty one, None for words."""
    if not text.strip():
        return math.nan
    return float(text.strip().replace(",", ".")) if _NUMBER_AS_TEXT.fullmatch(text.strip()) else None


def _text(row: Sequence[Any], index: int) -> str:
    value = row[index] if index < len(row) else None
    return value.strip() if isinstance(value, str) and not _is_numeric(value) else ""


def _are_units(row: Sequence[Any], numeric: set[int]) -> bool:
    """Return whether a row states units: short texts, in brackets or such as a header could end with."""
    texts = [_text(row, index) for index in numeric]
    known = [text for text in texts if text]
    return bool(known) and all(len(text) <= MAX_UNIT_LENGTH and _is_unit(text) for text in known)


def _is_unit(text: str) -> bool:
    from musclewire.signals import quantity_with_suffix

    bare = text.strip("[]() ")
    if bare in {"", "-", "1", "%"}:
        return True
    return split_header(text)[0] in {"", text} and quantity_with_suffix(f"1 {bare}") is not None


def _entries(rows: Sequence[Sequence[Any]]) -> dict[str, object]:
    """Return the pairs of name and value above a table: rows of two cells, the second of them perhaps with a unit."""
    found: dict[str, object] = {}
    for row in rows:
        filled = [value for value in row if value is not None and value != ""]
        if len(filled) in {2, 3} and isinstance(filled[0], str) and not isinstance(filled[1], (date, time)):
            unit = f" [{filled[2]}]" if len(filled) == 3 and isinstance(filled[2], str) else ""
            found[filled[0].rstrip(": =") + unit] = str(filled[1]) if unit else filled[1]
    return found
