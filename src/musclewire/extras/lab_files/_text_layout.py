"""How the table in a text file is laid out: separator, which lines are its rows, and what stands above them.

One idea serves every program: the table is what most lines agree on. A column is what most of its cells are, a row is
a line that has such cells, and whatever is above the first row names the columns, states their units, or is a remark.
"""

from __future__ import annotations

import csv
import functools
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from musclewire.errors import RecordingError
from musclewire.extras.lab_files._number_style import NumberStyle, is_missing, looks_numeric, number_and_unit, style_of
from musclewire.extras.lab_files._text_lines import Line
from musclewire.files import is_clock_text, stated_periods_s, written_clock
from musclewire.signals import MetadataValue, entry_from_text, is_unit, scale_between

SEPARATOR_WORDS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "spaces"}
# Tab and semicolon come before the comma, because in a file that they separate a comma may be the decimal sign.
_SEPARATORS = ("\t", ";", "|", ",", " ")
_SAMPLE_LINES = 400  # the last ones at hand show the separator, whatever titles are above
_MAX_COLUMNS = 4096  # no recording has as many; text with many separators may
_MAX_UNIT_LENGTH = 16  # characters: longer text among the cells is a remark
_MIN_SCORE_OF_TABS = 0.3  # of 1: so small a part of numbers, with tabs, is a table in which much is text
# What a cell is. Columns of these three are measured; what is "text" or "blank" in most cells is not.
COUNTED = frozenset({"numbers", "quantities", "times"})
_RULE = re.compile(r"[-=_+|,;\t ]*[-=_]{2,}[-=_+|,;\t ]*")
_MAX_TITLE_LENGTH = 200  # characters: a longer line with a colon is prose, not a fact
# The header of a column that holds the units of the one before, "#5" without a header.
_OF_UNITS = re.compile(r"units?|einheit(?:en)?|#\d+", re.IGNORECASE)
_BLANKS = re.compile(r'(?<=")[^"]*(?="(?:\s|$))|[^\s"]+')
_SPACED_HEADER = re.compile(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")
_BRACKETED = re.compile(r"\s*[\[(<{](.*)[\])>}]\s*")
_BRACKETED_END = re.compile(r"[\[(]([^\[\]()]*)[\])]\s*$")
# Words of two groups of columns next to each other.
_BRANCHES = re.compile(r"heat|cool|aufheiz|abkühl|erwärm|load|forward|reverse|up\b|down\b", re.IGNORECASE)
_UNIT_WORD = re.compile(
    r"(?:^|[\W_]|(?<=[a-z])(?=U)|(?<=^[A-Z])(?=U))(?:units?|einheit(?:en)?)(?:$|[\W_])", re.IGNORECASE
)
_AXIS = re.compile(r"(?:[vhxy]|vertical|horizontal|data|axis|\W)*", re.IGNORECASE)
_SOURCE = re.compile(r"source|channel|trace ?name|signal", re.IGNORECASE)
_ACROSS = re.compile(r"^(?:h|x|horizontal)(?:$|[\W_]|(?=[A-Z]))|time|horizontal", re.IGNORECASE)


@dataclass(frozen=True)
class TextLayout:
    """The layout of a table in text; headers, units, kinds and styles have an entry for each column."""

    separator: str
    headers: tuple[str, ...]
    units: tuple[str | None, ...]  # None if it is not given apart from the header
    kinds: tuple[str, ...]  # what most cells are, as ``kind_of`` says
    styles: tuple[NumberStyle, ...]
    first_line: int  # number of the line of the first row
    titles: int  # number of lines above the headers
    header_lines: frozenset[str] = frozenset()
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)

    def __str__(self) -> str:
        """Return the layout in words."""
        style = f", {self.style}" if str(self.style) else ""
        return f"separated by {SEPARATOR_WORDS[self.separator]}{style}"

    @property
    def style(self) -> NumberStyle:
        """The style of most columns that are not plain, or plain if all are."""
        others = [self.styles[index] for index in self.counted if self.styles[index] != NumberStyle()]
        return max(others, key=others.count) if others else NumberStyle()

    @property
    def counted(self) -> tuple[int, ...]:
        """The columns that hold numbers or times."""
        return tuple(index for index, kind in enumerate(self.kinds) if kind in COUNTED)


def split_lines(lines: Sequence[str], separator: str) -> list[list[str]]:
    """Return the cells of each line."""
    if separator == " ":
        return [_BLANKS.findall(line) if '"' in line else line.split() for line in lines]
    how: dict[str, Any] = {"delimiter": separator, "skipinitialspace": separator != "\t"}
    try:
        rows = list(csv.reader(lines, **how))
        # A quote that does not end would take the next lines into its cell.
        return rows if len(rows) == len(lines) else [next(csv.reader([line], **how), []) for line in lines]
    except csv.Error:
        return [line.split(separator) for line in lines]


@functools.lru_cache(maxsize=65_536)
def kind_of(cell: str) -> str:
    """Return what a cell is: one of ``COUNTED``, "blank" (a mark of none included) or "text"."""
    if is_missing(cell):
        return "blank"
    if looks_numeric(cell):
        return "numbers"
    found = number_and_unit(cell)
    if found is not None and is_unit(found[1]):
        return "quantities"
    return "times" if is_clock_text(cell) else "text"


def layout_of(lines: Sequence[Line], comments: Sequence[str], separator: str | None, path: str) -> TextLayout:
    """Return the layout of a table from its first lines, without comments and blank lines; None finds the separator.

    Raises RecordingError if there are no rows of numbers, or the headers do not fit them.
    """
    if separator is None:
        separator = separator_of([text for _, text in lines[-_SAMPLE_LINES:]])
    rows = split_lines([text for _, text in lines], separator)
    width, kinds = _columns_of(rows)
    counted = [index for index, kind in enumerate(kinds) if kind in COUNTED]
    if not counted:
        raise RecordingError(f"{path}: has no rows of numbers below its headers; a recording needs 2 or more")
    start = next((index for index, row in enumerate(rows) if _is_first(row, width, kinds)), len(rows))
    above = [(text, row) for (_, text), row in zip(lines[:start], rows, strict=False) if not _RULE.fullmatch(text)]
    left = [index for index, kind in enumerate(kinds) if kind == "beside"]
    beside = [[row[i] for i in left if i < len(row) and row[i].strip()] for row in rows[start:]]
    head = _Head(above, comments, separator, width, kinds, path, [row for row in beside if row])
    if head.used and len(head.names) < width and not head.is_short_by_blanks(rows[start:]):
        raise RecordingError(_too_wide(path, lines[start], separator, len(head.names)))
    count = max(width, len(head.names))
    if count > _MAX_COLUMNS:
        raise RecordingError(f"{path}: has {count:,} columns; export only those that are needed")
    names = [head.names[index] if index < len(head.names) else "" for index in range(count)]
    units = [head.units.get(index) for index in range(count)]
    for name, unit in zip(names, units, strict=True):
        stated = _BRACKETED_END.search(name)
        if unit and stated and is_unit(stated[1]) and scale_between(unit, stated[1]) not in (1.0, None):
            said = f"column '{name}' states {stated[1]}, and apart from it the file states {unit}"
            raise RecordingError(f"{path}: {said}: correct one of the two, or map it with the unit that is right")
    body = [row for row in rows[start:] if conforms(row, counted)]
    styles = [style_of((number_and_unit(row[i]) or (row[i],))[0] for row in body if i < len(row)) for i in range(count)]
    return TextLayout(
        separator,
        tuple(name or f"#{index + 1}" for index, name in enumerate(names)),
        tuple(units),
        (*kinds, *["blank"] * (count - width)),
        _agreeing(styles),
        lines[start][0] if start < len(lines) else lines[-1][0] + 1,
        len(above) - head.used,
        # Settings for each channel stand in for names.
        frozenset(text for text, _ in above[len(above) - head.used if head.used else 0 :]),
        head.metadata,
    )


def _agreeing(styles: Sequence[NumberStyle]) -> tuple[NumberStyle, ...]:
    """Return the styles of columns; one without a sign in its numbers is written as the others are."""
    points = any(style.decimal == "." and not style.is_open for style in styles)
    # Among columns with points a comma is a decimal sign only where it cannot be between thousands.
    sure = [style.grouped if points and style.grouped is not None else style for style in styles]
    commas = [style for style in sure if style.decimal == ","]
    usual = max(commas, key=commas.count) if commas else NumberStyle()
    return tuple(usual if style.is_open else style for style in sure)


def separator_of(sample: Sequence[str]) -> str:
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
    width, kinds = _columns_of(rows)
    like = [row for row in rows if len(row) == width and _counted(row)]
    cells = sum(len(row) for row in like)
    units = sum(
        len(cell) < _MAX_UNIT_LENGTH and kind_of(cell) == "text" and is_unit(cell) for row in like for cell in row
    )
    fraction = (sum(map(_counted, like)) + units) / cells if cells else 0.0
    return width > 1 and bool(COUNTED & set(kinds)), round(fraction * len(like) / len(rows), 3)


def _counted(row: Sequence[str]) -> int:
    return sum(kind_of(cell) in COUNTED for cell in row)


def _columns_of(rows: Sequence[Sequence[str]]) -> tuple[int, tuple[str, ...]]:
    """Return how many cells most rows with numbers have, and what most cells of each column are."""
    like = [row for row in rows if 3 * (_counted(row) + sum(map(is_missing, row))) >= len(row) and _counted(row)]
    if not like:
        return 0, ()
    counted = Counter(len(row) for row in like)
    width = max(counted, key=lambda width: (counted[width], width))
    like = [row for row in like if len(row) == width]
    columns = list(zip(*like, strict=True))
    kinds = [_kind_of_most(cells) for cells in columns]
    # Settings next to the first rows, each a word and its value, are not of the table.
    ended = [not any(cell.strip() for cell in cells[len(cells) // 2 :]) for cells in columns]
    words = any(over and kind == "text" for over, kind in zip(ended, kinds, strict=True))
    # Where such lines hold other things than numbers in the other columns, they are settings for each channel.
    others = [i for i, over in enumerate(ended) if not over]
    wide = [row for row in rows if len(row) == width and row[0].strip()]
    if words and any(kind_of(row[i]) == "text" for row in wide for i in others):
        rows_below = [row for row in like if not row[0].strip()]
        return width, tuple(_kind_of_most(cells) for cells in zip(*rows_below, strict=True))
    return width, tuple(
        "beside" if words and over and kind != "blank" else kind for over, kind in zip(ended, kinds, strict=True)
    )


def _kind_of_most(cells: Sequence[str]) -> str:
    """Return what most cells of a column are."""
    found = [kind_of(cell) for cell in cells]
    filled = [kind for kind in found if kind != "blank"]
    if not filled:
        return "blank"
    kind = max(("numbers", "quantities", "times"), key=filled.count)
    return kind if 2 * filled.count(kind) >= len(filled) else "text"


def _is_first(row: Sequence[str], width: int, kinds: Sequence[str]) -> bool:
    """Return whether a line is a whole row of the table and not a header or title."""
    if len(row) < width or (kinds[0] == "blank" and row[0].strip()):
        return False
    counted = [index for index, kind in enumerate(kinds) if kind in COUNTED]
    return conforms(row, counted) and kind_of(row[counted[0]]) in COUNTED


def conforms(row: Sequence[str], counted: Sequence[int]) -> bool:
    """Return whether most of the cells that should be numbers or times are, and not all of them are missing."""
    kinds = [kind_of(row[index]) if index < len(row) else "blank" for index in counted]
    good = sum(kind in COUNTED for kind in kinds)
    return bool(good) and 2 * (good + kinds.count("blank")) >= len(kinds)


class _Head:
    """What stands above the rows: names, units below them or stated of them, remarks as metadata."""

    def __init__(
        self,
        above: Sequence[tuple[str, list[str]]],
        comments: Sequence[str],
        separator: str,
        width: int,
        kinds: Sequence[str],
        path: str,
        beside: Sequence[Sequence[str]] = (),
    ) -> None:
        self._width, self._counted = width, [i for i, kind in enumerate(kinds) if kind in COUNTED]
        # Above rows that begin with a blank stand settings with a value for each channel, or a single line of names.
        self._begins_blank = kinds[0] == "blank" and sum(len(row) == width and all(row) for _, row in above) > 1
        self._separator = separator
        self.names: list[str] = []
        self.units: dict[int, str] = {}
        self.used = 0
        lines = [(text, [_one_line(cell) for cell in row]) for text, row in above]
        if separator == " " and lines and len(lines[-1][1]) != width:
            lines[-1] = (lines[-1][0], spaced_headers(lines[-1][0], width, path))
        while self.used < len(lines) and not any(lines[-1 - self.used][1]):
            self.used += 1
        rest = lines[: len(lines) - self.used]
        stated: dict[str, MetadataValue] = {}
        if not self._take_rows(rest, stated):
            self.used = 0
            self._take_lines_of_channels([row for _, row in rest])
            if not self.names:
                self.names = list(_commented_headers(comments, separator, width, path))
        remarks = rest[: len(lines) - self.used]
        entries = [*(metadata_of(comments, " ").items()), *(metadata_of([t for t, _ in remarks], separator).items())]
        self.metadata = {**dict(entries), **stated}
        # Of words with blanks between them only the signs separate a name from its value.
        cells = ([text] if separator == " " else row for text, row in remarks)
        stated_rows = [*([comment] for comment in comments), *cells, *beside]
        if beside and not self.names:
            # Settings to the left of the rows name the only channel; what it was recorded over comes first.
            source = next((row[1] for row in beside if len(row) > 1 and _SOURCE.fullmatch(row[0])), "CH1")
            self.names = [""] * width
            for index, name in zip(self._counted, ("Time", source), strict=False):
                self.names[index] = name
            self.metadata |= metadata_of([separator.join(row) for row in beside], separator)
        self._take_stated_units(stated_rows)

    def is_short_by_blanks(self, rows: Sequence[Sequence[str]]) -> bool:
        """Return whether the rows only have separators behind the last column with a name."""
        count = len(self.names)
        return all(not any(cell.strip() for cell in row[count:]) for row in rows)

    def _take_rows(self, lines: Sequence[tuple[str, list[str]]], stated: dict[str, MetadataValue]) -> bool:
        """Take the names, the units below them, and the names of groups above them; False if no line is names."""
        rows = [row for _, row in lines]
        below = len(rows) > 1 and self._are_units(rows[-1])
        below = below and self._may_be_names(rows[-2]) and not self._are_units(rows[-2])
        if not rows or not (below or self._may_be_names(rows[-1])):
            return False
        used = 1
        if below:
            self.units = {i: _bare(cell) for i, cell in enumerate(rows[-1]) if _is_unit_cell(cell)}
            # A scope writes its settings once, in columns of their own that have no cells in its rows.
            names_above = rows[-2]
            for index, (name, cell) in enumerate(zip(rows[-2], rows[-1], strict=False)):
                entry = entry_from_text(name, cell) if index not in self._counted and looks_numeric(cell) else None
                if entry is not None:
                    stated.update([entry])
                    names_above[index] = ""
            rows, used = rows[:-1], 2
        names: list[list[str]] = [list(rows[-1])]
        if len(rows) > 1 and _are_groups(rows[-2], rows[-1]):
            names, used = [_spread(rows[-2], len(rows[-1])), rows[-1]], used + 1
        self.names = list(joined_headers(names))
        for index, name in enumerate(self.names):
            if (pair := _assignment(name)) is not None and index not in self._counted:
                stated.update([pair])
                self.names[index] = ""
        kept = max([i for i, name in enumerate(self.names) if name and i < max(self._width, 1)], default=-1)
        if stated:
            self.names = self.names[: max(kept + 1, self._width)]
        self.used += used
        return True

    def _may_be_names(self, row: Sequence[str]) -> bool:
        """Return whether a row may be headers and not a title or a setting, which fill only its first cells."""
        filled = sum(bool(cell) for cell in row)
        settings = len(row) and filled <= 2 < self._width and (row[0].endswith(":") or _assignment(row[0]))
        return filled >= max(1, (self._width + 1) // 2) and not settings and not self._is_of_channels(row)

    def _is_of_channels(self, row: Sequence[str]) -> bool:
        """Return whether a row is a setting with its value for each channel, above rows that begin with a blank."""
        of_settings = self._begins_blank and len(self._counted) == self._width - 1
        return of_settings and len(row) == self._width and all(row)

    def _are_units(self, row: Sequence[str]) -> bool:
        """Return whether at least half of the cells above numbers are units; what is beyond the rows does not count."""
        filled = [row[i] for i in self._counted if i < len(row) and row[i]]
        return bool(filled) and 2 * sum(map(_is_unit_cell, filled)) >= len(filled)

    def _take_lines_of_channels(self, rows: Sequence[Sequence[str]]) -> None:
        """Take names and units from settings with a value for each channel, as a scope writes them above its rows."""
        count = len(self._counted)
        each = [row for row in rows if len(row) > count and self._is_of_channels(row) and all(row[1 : count + 1])]
        named = [row for row in each if all(kind_of(cell) == "text" for cell in row[1 : count + 1])]
        named = [row for row in named if not _UNIT_WORD.search(row[0]) and not self._are_units(row)]
        distinct = [row for row in named if len(set(row[1 : count + 1])) == count]
        if distinct:
            self.names = ["", *distinct[0][1 : count + 1]]

    def _take_stated_units(self, rows: Sequence[Sequence[str]]) -> None:
        """Take the units that lines above the table state of one column by its name, or of all in their order."""
        for row in rows:
            pair = _pair_of(row)
            if pair is None or not _UNIT_WORD.search(pair[0]):
                continue
            key, values = pair[0], [value.rpartition(":")[2].strip() for value in pair[1]]
            values = values[: next((i for i, value in enumerate(values) if not value), len(values))]
            if not values or not all(map(is_unit, values)):
                continue
            others = [i for i in self._counted if self._named_time(i) == bool(_ACROSS.search(key))]
            targets = [i for i in self._counted if self._is_named_in(i, key)] if len(values) == 1 else []
            if not targets and len(values) == len(self._counted) and not _ACROSS.search(key):
                targets = self._counted
            elif not targets and len(values) <= len(others) and _AXIS.fullmatch(_UNIT_WORD.sub(" ", key).strip()):
                targets = others
            for index, unit in zip(targets, values, strict=False):
                self.units.setdefault(index, unit)

    def _named_time(self, index: int) -> bool:
        name = self.names[index] if index < len(self.names) else ""
        return re.fullmatch(r"(?:x|x-axis|time\w*|t|source)(?:\W.*)?", name, re.IGNORECASE) is not None

    def _is_named_in(self, index: int, key: str) -> bool:
        name = self.names[index] if index < len(self.names) else ""
        rest = _UNIT_WORD.sub(" ", key)
        return (
            bool(name)
            and re.fullmatch(rf"\W*(?:of\s+|von\s+)?{re.escape(name)}\W*", rest.strip(), re.IGNORECASE) is not None
        )


def _is_unit_cell(cell: str) -> bool:
    bare = _bare(cell)
    return bool(bare) and ((not looks_numeric(bare) and is_unit(bare)) or bool(written_clock(bare)))


def _bare(cell: str) -> str:
    match = _BRACKETED.fullmatch(cell)
    return match[1].strip() if match else cell


def _one_line(cell: str) -> str:
    return " ".join("".join(letter if letter.isprintable() else " " for letter in cell).split())


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
    for headers in (_SPACED_HEADER.findall(line), re.split(r"\s{2,}", line.strip()), line.split()):
        if len(headers) == width:
            return headers
    raise RecordingError(
        f"{path}: the headers do not fit the {width} numbers below them; separate columns with commas or tabs"
    )


def _are_groups(upper: Sequence[str], lower: Sequence[str]) -> bool:
    """Return whether a row names groups of the columns below: each begins a group, and names below are repeated."""
    filled = [index for index, cell in enumerate(upper) if cell]
    if any(kind_of(upper[index]) != "text" for index in filled):
        return False
    names = [name for name in lower if name and not _OF_UNITS.fullmatch(name)]
    repeated = len(set(names)) < len(names)
    named = sum(_BRANCHES.search(upper[index]) is not None for index in filled) > 1
    return len(filled) > 1 and (repeated or named) and len(filled) <= len(lower)


def _spread(row: Sequence[str], count: int) -> list[str]:
    """Return a row in which a blank cell repeats the name to its left, as a merged cell means it."""
    spread: list[str] = []
    for index in range(count):
        cell = row[index] if index < len(row) else ""
        spread.append(cell or (spread[-1] if spread else ""))
    return spread


def _commented_headers(comments: Sequence[str], separator: str, width: int, path: str) -> tuple[str, ...]:
    """Return the last comment as headers, as numpy.savetxt writes them, or none."""
    last = comments[-1] if comments else ""
    if not last or "=" in last:
        return ()
    try:
        headers = split_lines([last], separator)[0] if separator != " " else spaced_headers(last, width, path)
    except RecordingError:
        return ()
    found = joined_headers([headers])
    return found if len(found) == width and not all(map(looks_numeric, found)) else ()


def _too_wide(path: str, line: Line, separator: str, headers: int) -> str:
    cells = len(split_lines([line[1].rstrip(separator)], separator)[0])
    return too_wide(f"{path}: line {line[0]} has {cells} cells for {headers} headers", line[1], separator)


def too_wide(beginning: str, text: str, separator: str) -> str:
    """Return the message about a line with more cells than there are headers."""
    if separator == "," and "." not in text:
        return f"{beginning}; with decimal commas separate the columns with semicolons"
    return f"{beginning}; name every column, or put cells with {SEPARATOR_WORDS[separator]} in quotes"


def metadata_of(texts: Sequence[str], separator: str) -> dict[str, MetadataValue]:
    """Return what lines above the table state as ``key = value`` or ``key: value``, or as two cells."""
    found: dict[str, MetadataValue] = {}
    for text in texts:
        row = [_one_line(cell) for cell in split_lines([text], separator)[0]] if separator != " " else [text]
        pair = _assignment(text) if "=" in text else None
        if pair is None and (cells := _pair_of([cell for cell in row if cell])) is not None:
            pair = entry_from_text(cells[0], _common(cells[1]))
        if pair is not None and len(text) <= _MAX_TITLE_LENGTH:
            key, value = pair
            # Of two channels that state their rates one below the other, both are kept.
            others = found.get(key, value) != value and stated_periods_s({key: value}, unit_stated=True)
            found[f"second_{key}" if others else key] = value
    return found


def _common(values: Sequence[str]) -> str:
    """Return the value of a setting that is the same for each channel, with its unit if that has a cell of its own."""
    if len(values) == 2 and is_unit(values[1]):
        return f"{values[0]} {values[1]}"
    return values[0] if len(set(values)) == 1 else " ".join(values)


def _assignment(text: str) -> tuple[str, MetadataValue] | None:
    key, sign, value = text.partition("=")
    return entry_from_text(key, value) if sign and key.strip() else None


def _pair_of(row: Sequence[str]) -> tuple[str, list[str]] | None:
    """Return the key of a setting and its values: "key, value, ...", "key: value" or "key = value"."""
    if len(row) > 1:
        return (row[0].rstrip(": "), list(row[1:])) if ":" not in row[0][:-1] else None
    text = row[0] if row else ""
    for sign in ("=", ": "):
        key, found, value = text.partition(sign)
        if found and key.strip():
            return key.strip(), [value.strip(" \t;,|")]
    return None


def unit_columns(layout: TextLayout, rows: Sequence[Sequence[str]]) -> Iterator[tuple[int, str]]:
    """Yield each column that holds only the units of the numbers to its left, with the first unit in it."""
    for index, kind in enumerate(layout.kinds):
        if (
            kind == "text"
            and index
            and layout.kinds[index - 1] == "numbers"
            and _OF_UNITS.fullmatch(layout.headers[index])
        ):
            cells = [row[index].strip() for row in rows if index < len(row) and not is_missing(row[index])]
            if cells and all(is_unit(cell) and scale_between(cell, cells[0]) is not None for cell in set(cells)):
                yield index, cells[0]
