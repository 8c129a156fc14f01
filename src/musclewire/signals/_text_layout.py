"""How the table in a text file is laid out: separator, titles, rows of headers and units, where the numbers begin."""

from __future__ import annotations

import csv
import functools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from musclewire.errors import RecordingError
from musclewire.signals._clock_texts import is_clock_text
from musclewire.signals._number_style import NumberStyle, is_missing, looks_numeric, number_and_unit, style_of
from musclewire.signals._text_headers import header_rows, joined_headers, spaced_headers
from musclewire.signals._text_lines import Line
from musclewire.signals._units import is_unit

SEPARATOR_WORDS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "spaces"}
# Tab and semicolon come before the comma, because in a file that they separate a comma may be the decimal sign.
_SEPARATORS = ("\t", ";", "|", ",", " ")
# Lines from which separator and width follow: the last of the first piece, where titles are over.
_SAMPLE_LINES = 60
_MAX_COLUMNS = 4096
_MIN_SCORE_OF_TABS = 0.3
# Kinds of columns that a table of numbers is made of.
_COUNTED = frozenset({"numbers", "quantities", "times"})
_RULE = re.compile(r"[-=_+|,;\t ]*[-=_]{2,}[-=_+|,;\t ]*")


@dataclass(frozen=True)
class TextLayout:
    """The layout of a table in text.

    ``headers`` and ``units`` (None for a column whose unit is not given in a row of units) are of equal length;
    ``kinds`` says what the cells of a column are: "numbers", "quantities" (numbers with their unit), "times", "text" or
    "blank". ``first_line`` is the number of the first line of the table's rows, ``titles`` are the lines before the
    headers, ``header_lines`` those of the headers themselves.
    """

    separator: str
    headers: tuple[str, ...]
    units: tuple[str | None, ...]
    kinds: tuple[str, ...]
    style: NumberStyle
    first_line: int
    titles: tuple[str, ...]
    header_lines: frozenset[str] = frozenset()

    def __str__(self) -> str:
        """Return the layout in words."""
        style = f", {self.style}" if str(self.style) else ""
        return f"separated by {SEPARATOR_WORDS[self.separator]}{style}"


def split_lines(lines: Sequence[str], separator: str) -> list[list[str]]:
    """Return the cells of each line."""
    if separator == " ":
        return [line.split() for line in lines]
    how: dict[str, Any] = {"delimiter": separator, "skipinitialspace": separator != "\t"}
    try:
        rows = list(csv.reader(lines, **how))
        # A quote that does not end would take the next lines into its cell.
        return rows if len(rows) == len(lines) else [next(csv.reader([line], **how), []) for line in lines]
    except csv.Error:
        return [line.split(separator) for line in lines]


def layout_of(lines: Sequence[Line], comments: Sequence[str], separator: str | None, path: str) -> TextLayout:
    """Return the layout of a table from its first lines, without comments and blank lines.

    ``comments`` are the lines before the table that begin with a sign of a comment; a separator that is None is found.
    Raises RecordingError if there are no rows of numbers, or the headers do not fit them.
    """
    if separator is None:
        separator = _separator([text for _, text in lines[-_SAMPLE_LINES:]])
    rows = split_lines([text for _, text in lines], separator)
    width, numeric = _numeric_columns(rows[-_SAMPLE_LINES:])
    if not numeric:
        raise RecordingError(f"{path}: has no rows of numbers below its headers; a recording needs 2 or more")
    start = next((index for index, row in enumerate(rows) if _is_row(row, width, numeric)), len(rows))
    above = [row for row, (_, text) in zip(rows[:start], lines, strict=False) if not _RULE.fullmatch(text)]
    texts = [text for _, text in lines[:start] if not _RULE.fullmatch(text)]
    if separator == " " and texts:
        above[-1] = spaced_headers(texts[-1], width, path)
    names, units, used = header_rows(above, width, is_unit)
    if used and len(names) < width:
        raise RecordingError(_too_wide(path, lines[start], separator, len(names)))
    headers = names if used else _commented_headers(comments, separator, width, path)
    headers, units = _padded(headers, units, width)
    if len(headers) > _MAX_COLUMNS:
        raise RecordingError(f"{path}: has {len(headers):,} columns; export only those that are needed")
    body = rows[start:]
    cells = [
        (number_and_unit(cell) or (cell,))[0] for row in body for index, cell in enumerate(row) if index in numeric
    ]
    kinds = tuple(_kind([row[index] for row in body if index < len(row)]) for index in range(len(headers)))
    titles = tuple(texts[: len(texts) - used])
    header_lines = frozenset(texts[len(titles) :])
    return TextLayout(separator, headers, units, kinds, style_of(cells), lines[start][0], titles, header_lines)


def _separator(sample: Sequence[str]) -> str:
    """Return the separator by which most cells are numbers and times."""
    scores = {separator: _score(sample, separator) for separator in _SEPARATORS}
    # A tab separates cells and nothing else, whatever spaces are in them.
    if scores["\t"][0] and scores["\t"][1] >= _MIN_SCORE_OF_TABS:
        return "\t"
    best = max(_SEPARATORS, key=lambda separator: scores[separator])
    if scores[best][0]:
        return best
    return next((separator for separator in _SEPARATORS[:-1] if separator in sample[0]), ",")


def _score(sample: Sequence[str], separator: str) -> tuple[bool, float]:
    rows = split_lines(sample, separator)
    width, numeric = _numeric_columns(rows)
    like = [row for row in rows if len(_stripped(row)) == width and _count(row)]
    cells = sum(len(row) for row in like)
    fraction = sum(_count(row) for row in like) / cells if cells else 0.0
    return width > 1 and bool(numeric), round(fraction * len(like) / len(rows), 3)


def _count(row: Sequence[str]) -> int:
    return sum(looks_numeric(cell) or is_clock_text(cell) or _is_quantity(cell) for cell in row)


@functools.lru_cache(maxsize=4096)
def _is_quantity(cell: str) -> bool:
    """Return whether a cell is a number with its unit."""
    found = number_and_unit(cell)
    return found is not None and is_unit(found[1])


def _stripped(row: Sequence[str]) -> Sequence[str]:
    end = len(row)
    while end and not row[end - 1].strip():
        end -= 1
    return row[:end]


def _numeric_columns(rows: Sequence[Sequence[str]]) -> tuple[int, frozenset[int]]:
    """Return the usual width of rows with numbers, and the columns that hold numbers or times in half of these."""
    like = [_stripped(row) for row in rows if _count(row) and 3 * (_count(row) + sum(map(is_missing, row))) >= len(row)]
    if not like:
        return 0, frozenset()
    counted = Counter(len(row) for row in like)
    width = max(counted, key=lambda width: (counted[width], width))
    like = [row for row in like if len(row) == width]
    columns = zip(*like, strict=True)
    return width, frozenset(index for index, cells in enumerate(columns) if _kind(cells) in _COUNTED)


def _kind(cells: Sequence[str]) -> str:
    """Return what most cells of a column are."""
    filled = [cell for cell in cells if not is_missing(cell)]
    if not filled:
        return "blank"
    numbers = sum(map(looks_numeric, filled))
    if 2 * numbers >= len(filled):
        return "numbers"
    if 2 * sum(map(_is_quantity, filled)) >= len(filled):
        return "quantities"
    return "times" if 2 * sum(map(is_clock_text, filled)) >= len(filled) else "text"


def _is_row(row: Sequence[str], width: int, numeric: frozenset[int]) -> bool:
    """Return whether a line is a row of the table, a damaged one included, and not a header or title."""
    if len(_stripped(row)) < max(1, min(numeric) + 1) or len(_stripped(row)) < width // 2:
        return False
    good = [_count([row[index]]) or is_missing(row[index]) for index in sorted(numeric) if index < len(row)]
    return bool(_count([row[min(numeric)]])) and 2 * sum(map(bool, good)) >= len(numeric)


def _too_wide(path: str, line: Line, separator: str, headers: int) -> str:
    cells = len(_stripped(split_lines([line[1]], separator)[0]))
    return too_wide(f"{path}: line {line[0]} has {cells} cells for {headers} headers", line[1], separator)


def too_wide(beginning: str, text: str, separator: str) -> str:
    """Return the message about a line with more cells than there are headers."""
    if separator == "," and "." not in text:
        return f"{beginning}; with decimal commas separate the columns with semicolons"
    return f"{beginning}; name every column, or put cells with {SEPARATOR_WORDS[separator]} in quotes"


def _commented_headers(comments: Sequence[str], separator: str, width: int, path: str) -> tuple[str, ...]:
    """Return the last comment as headers, as numpy.savetxt writes them, or none."""
    last = comments[-1] if comments else ""
    if not last or "=" in last:
        return ()
    headers = split_lines([last], separator)[0] if separator != " " else _spaced_or_none(last, width, path)
    found = joined_headers([headers])
    return found if len(found) == width and not all(map(looks_numeric, found)) else ()


def _spaced_or_none(line: str, width: int, path: str) -> list[str]:
    try:
        return spaced_headers(line, width, path)
    except RecordingError:
        return []


def _padded(
    headers: Sequence[str], units: Sequence[str | None], width: int
) -> tuple[tuple[str, ...], tuple[str | None, ...]]:
    """Return headers and units for every column; a column without a header is called by its number."""
    count = max(width, len(headers))
    names = [headers[index].strip() if index < len(headers) else "" for index in range(count)]
    filled = tuple(name or f"#{index + 1}" for index, name in enumerate(names))
    return filled, tuple(units[index] if index < len(units) else None for index in range(count))
