"""How the table in a text file is laid out: separator, which lines are its rows, and what stands above them.

One idea serves every program: the table is what most lines agree on. A column is what most of its cells are, a row is
a line that has such cells, and whatever is above the first row names the columns, states their units, or is a remark.
"""

from __future__ import annotations

import csv
import functools
import itertools
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

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
_MIN_SCORE_OF_TABS = 0.3  # of 1: so small a part of numbers, with tabs, is a table in which much is text
_MAX_UNIT_LENGTH = 16  # characters: longer text among the cells is a remark
# What a cell is. Columns of these three are measured; what is "text" or "blank" in most cells is not.
COUNTED = frozenset({"numbers", "quantities", "times"})
_RULE = re.compile(r"[-=_+|,;\t ]*[-=_]{2,}[-=_+|,;\t ]*")
_MAX_TITLE_LENGTH = 200  # characters: a longer line with a colon is prose, not a fact
# The header of a column that holds the units of the one before, "#5" without a header.
OF_UNITS = re.compile(r"units?|einheit(?:en)?|#\d+", re.IGNORECASE)
_BLANKS = re.compile(r'(?<=")[^"]*(?="(?:\s|$))|[^\s"]+')
_SPACED_HEADER = re.compile(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")
_BRACKETED = re.compile(r"\s*[\[(<{](.*)[\])>}]\s*")
_BRACKETED_END = re.compile(r"[\[(]([^\[\]()]*)[\])]\s*$")
_UNIT_WORD = re.compile(
    r"(?:^|[\W_]|(?<=[a-z])(?=U)|(?<=^[A-Z])(?=U))(?:units?|einheit(?:en)?)(?:$|[\W_])", re.IGNORECASE
)
_AXIS = re.compile(r"(?:[vhxy]|vertical|horizontal|data|axis|\W)*", re.IGNORECASE)
_OF = re.compile(r"\b(?:of|von)\s")
_SIGNS = " .:;,_-[]()"  # around a name
_TIME = re.compile(r"(?:x|x-axis|time\w*|t|source)(?:\W.*)?", re.IGNORECASE)
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
        return counted_of(self.kinds)


def counted_of(kinds: Sequence[str]) -> tuple[int, ...]:
    """Return the columns of numbers or times among columns of these kinds."""
    return tuple(index for index, kind in enumerate(kinds) if kind in COUNTED)


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
    counted = counted_of(kinds)
    if not counted:
        raise RecordingError(f"{path}: has no rows of numbers below its headers; a recording needs 2 or more")
    whole = (len(row) >= width and is_row(row, kinds) and kind_of(row[counted[0]]) in COUNTED for row in rows)
    start = next((index for index, is_first in enumerate(whole) if is_first), len(rows))
    body = rows[start:]
    texts = [text for _, text in lines[:start] if not _RULE.fullmatch(text)]
    above = [list(map(_one_line, row)) for row in split_lines(texts, separator)]
    if separator == " " and above and len(above[-1]) != width:
        above[-1] = spaced_headers(texts[-1], width)
        if not above[-1]:
            cure = "separate columns with commas or tabs"
            raise RecordingError(f"{path}: the headers do not fit the {width} numbers below them; {cure}")
    head = _head_of(above, width, kinds)
    # Of words with blanks between them only the signs separate a name from its value.
    remarks = [[" ".join(row)] if separator == " " else row for row in above[: len(above) - head.line_count]]
    beside = [[row[i] for i, kind in enumerate(kinds) if kind == "beside" and i < len(row)] for row in body]
    said = [*([comment] for comment in comments), *remarks, *(list(filter(str.strip, row)) for row in beside)]
    names = head.names or _commented_headers(comments, separator, width)
    if not names and any(map(any, beside)):
        # Settings to the left of the rows name the only channel; what it was recorded over comes first.
        source = next((row[1] for row in said if len(row) > 1 and _SOURCE.fullmatch(row[0])), "CH1")
        of_counted = dict(zip(counted, ("Time", source), strict=False))
        names = [of_counted.get(index, "") for index in range(width)]
    for (number, _), row in zip(lines[start:], body, strict=True):
        if head.line_count and any(map(str.strip, row[len(names) : width])):
            raise too_wide(f"{path}: line {number}", row, len(names), separator)
    count = max(width, len(names))
    if count > _MAX_COLUMNS:
        raise RecordingError(f"{path}: has {count:,} columns; export only those that are needed")
    names = [*names, *[""] * (count - len(names))]
    stated = {**_stated_units(said, names, counted), **head.units}
    units = [stated.get(index) for index in range(count)]
    _check_units(names, units, path)
    like = [row for row in body if is_row(row, kinds)]
    styles = [style_of((number_and_unit(row[i]) or (row[i],))[0] for row in like if i < len(row)) for i in range(count)]
    titles = len(above) - head.line_count
    return TextLayout(
        separator,
        tuple(name or f"#{index + 1}" for index, name in enumerate(names)),
        tuple(units),
        (*kinds, *["blank"] * (count - width)),
        _agreeing(styles),
        lines[start][0] if start < len(lines) else lines[-1][0] + 1,
        titles,
        # Settings for each channel stand in for names.
        frozenset(texts[titles if head.line_count else 0 :]),
        {**_metadata_of(said, separator), **head.settings},
    )


def _check_units(names: Sequence[str], units: Sequence[str | None], path: str) -> None:
    """Raise RecordingError if a name states another unit than the file does apart from it."""
    for name, unit in zip(names, units, strict=True):
        stated = _BRACKETED_END.search(name)
        if unit and stated and is_unit(stated[1]) and scale_between(unit, stated[1]) not in (1.0, None):
            said = f"column '{name}' states {stated[1]}, and apart from it the file states {unit}"
            raise RecordingError(f"{path}: {said}: correct one of the two, or map it with the unit that is right")


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
    cells = sum(map(len, like))
    fraction = sum(map(_may_be_measured, (cell for row in like for cell in row))) / cells if cells else 0.0
    return width > 1 and bool(COUNTED & set(kinds)), round(fraction * len(like) / len(rows), 3)


@functools.lru_cache(maxsize=65_536)
def _may_be_measured(cell: str) -> bool:
    """Return whether a cell is a number, a time or the unit of one."""
    kind = kind_of(cell)
    return kind in COUNTED or (kind == "text" and len(cell) < _MAX_UNIT_LENGTH and is_unit(cell))


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
    kinds = tuple(map(_kind_of_most, columns))
    late = tuple(_kind_of_most(cells[len(cells) // 2 :]) for cells in columns)
    has_ended = [now == "blank" != kind for now, kind in zip(late, kinds, strict=True)]
    if not any(ended and kind == "text" for ended, kind in zip(has_ended, kinds, strict=True)):
        return width, kinds
    # Words that end with the first rows are settings: above the rows if they have words for other columns too,
    wide = [row for row in rows if len(row) == width and row[0].strip()]
    if any(kind_of(row[i]) == "text" for row in wide for i, now in enumerate(late) if now != "blank"):
        return width, late
    # and else next to them.
    return width, tuple("beside" if ended else kind for ended, kind in zip(has_ended, kinds, strict=True))


def _kind_of_most(cells: Sequence[str]) -> str:
    """Return what most cells of a column are."""
    found = [kind_of(cell) for cell in cells]
    filled = [kind for kind in found if kind != "blank"]
    if not filled:
        return "blank"
    kind = max(("numbers", "quantities", "times"), key=filled.count)
    return kind if 2 * filled.count(kind) >= len(filled) else "text"


def is_row(row: Sequence[str], kinds: Sequence[str]) -> bool:
    """Return whether most of the cells that should be numbers or times are, and not all of them are missing."""
    counted = counted_of(kinds)
    if len(row) <= counted[-1] or (kinds[0] == "blank" and row[0].strip()):
        return False
    found = [kind_of(row[index]) for index in counted]
    good = sum(kind in COUNTED for kind in found)
    return good > 0 and 2 * (good + found.count("blank")) >= len(found)


class _Head(NamedTuple):
    """What the lines right above the rows say: names and units of columns, and settings in columns of their own."""

    names: Sequence[str] = ()
    units: Mapping[int, str] = {}
    settings: Mapping[str, MetadataValue] = {}
    line_count: int = 0


def _head_of(rows: Sequence[list[str]], width: int, kinds: Sequence[str]) -> _Head:
    """Return what the last of the rows of cells above the table say: blank ones, units, names and groups of them."""
    counted, lines = counted_of(kinds), list(rows)
    if of_channels := _settings_of_channels(rows, width, kinds):
        each = [row[1:] for row in of_channels if not _are_units(row, counted)]
        texts = (row for row in each if len(set(row)) == len(row) and {*map(kind_of, row)} == {"text"})
        name_row = next(texts, None)
        return _Head() if name_row is None else _Head(["", *name_row])
    while lines and not any(lines[-1]):
        lines.pop()
    units: list[str] = []
    if len(lines) > 1 and _are_units(lines[-1], counted) and _may_be_names(lines[-2], width):
        units = lines.pop() if not _are_units(lines[-2], counted) else []
    if not lines or not _may_be_names(lines[-1], width):
        return _Head()
    names = lines.pop()
    settings: dict[str, MetadataValue] = {}
    for index, (name, below) in enumerate(itertools.zip_longest(names, units[: len(names)], fillvalue="")):
        # A scope writes its settings once, in columns of their own that have no cells in its rows.
        entry = _assignment(name) or (entry_from_text(name, below) if looks_numeric(below) else None)
        if entry is not None and index not in counted:
            settings.update([entry])
            names[index] = ""
    if lines and _are_groups(lines[-1], names):
        group, upper = "", lines.pop()
        for index, (cell, name) in enumerate(zip(upper + [""] * len(names), list(names), strict=False)):
            # A blank cell repeats the name to its left, as a merged cell means it.
            group = cell or group
            names[index] = f"{group} {name}".strip()
    while names and not names[-1]:
        names.pop()
    of_cells = {index: _bare(cell) for index, cell in enumerate(units) if _is_unit_cell(cell)}
    return _Head(names[: width if settings else None], of_cells, settings, len(rows) - len(lines))


def _settings_of_channels(rows: Sequence[list[str]], width: int, kinds: Sequence[str]) -> list[list[str]]:
    """Return the lines with a setting and its value for each channel, as a scope writes them above its rows, or none.

    The rows below them begin with a blank; a single such line is names.
    """
    whole = [row for row in rows if len(row) == width and all(row)]
    are_above = kinds[0] == "blank" and len(counted_of(kinds)) == width - 1 and rows and rows[-1] in whole
    return whole if are_above and len(whole) > 1 else []


def _may_be_names(row: Sequence[str], width: int) -> bool:
    """Return whether a row may be headers and not a title or a setting, which fill only its first cells."""
    filled = sum(map(bool, row))
    is_setting = 0 < filled <= 2 < width and (row[0].endswith(":") or _assignment(row[0]) is not None)
    return filled >= max(1, (width + 1) // 2) and not is_setting


def _are_units(row: Sequence[str], counted: Sequence[int]) -> bool:
    """Return whether at least half of the cells above numbers are units; what is beyond the rows does not count."""
    filled = [row[i] for i in counted if i < len(row) and row[i]]
    return bool(filled) and 2 * sum(map(_is_unit_cell, filled)) >= len(filled)


def _stated_units(rows: Sequence[Sequence[str]], names: Sequence[str], counted: Sequence[int]) -> dict[int, str]:
    """Return the units that lines above the table state of one column by its name, or of all in their order."""
    units: dict[int, str] = {}
    for row in rows:
        key, cells = _pair_of(row) or ("", [])
        values = [*itertools.takewhile(bool, (cell.rpartition(":")[2].strip() for cell in cells))]
        if not values or not _UNIT_WORD.search(key) or not all(map(is_unit, values)):
            continue
        of_what = _OF.sub("", _UNIT_WORD.sub(" ", key)).strip(_SIGNS).lower()
        is_across = _ACROSS.search(key) is not None
        columns = [i for i in counted if len(values) == 1 and of_what and names[i].strip(_SIGNS).lower() == of_what]
        if not columns and len(values) == len(counted) and not is_across:
            columns = [*counted]
        elif not columns and _AXIS.fullmatch(of_what):
            columns = [i for i in counted if (_TIME.fullmatch(names[i]) is not None) == is_across]
        if len(values) <= len(columns):
            units = {**dict(zip(columns, values, strict=False)), **units}
    return units


def _is_unit_cell(cell: str) -> bool:
    bare = _bare(cell)
    return bool(bare) and ((not looks_numeric(bare) and is_unit(bare)) or bool(written_clock(bare)))


def _bare(cell: str) -> str:
    match = _BRACKETED.fullmatch(cell)
    return match[1].strip() if match else cell


def _one_line(cell: str) -> str:
    return " ".join("".join(letter if letter.isprintable() else " " for letter in cell).split())


def spaced_headers(line: str, width: int) -> list[str]:
    """Return headers that may contain spaces themselves ("Time [s]  Wire voltage [V]") as ``width`` cells, or none."""
    ways = (_SPACED_HEADER.findall(line), re.split(r"\s{2,}", line.strip()))
    return next((headers for headers in ways if len(headers) == width), [])


def _are_groups(upper: Sequence[str], lower: Sequence[str]) -> bool:
    """Return whether a row names groups of the columns below: each begins a group, and names below are repeated."""
    filled = [cell for cell in upper if cell]
    names = [name for name in lower if name and not OF_UNITS.fullmatch(name)]
    return 1 < len(filled) <= len(lower) and len(set(names)) < len(names) and {*map(kind_of, filled)} == {"text"}


def _commented_headers(comments: Sequence[str], separator: str, width: int) -> list[str]:
    """Return the last comment as headers, as numpy.savetxt writes them, or none."""
    last = comments[-1] if comments else ""
    headers = spaced_headers(last, width) if separator == " " else split_lines([last], separator)[0] if last else []
    found = [_one_line(cell) for cell in headers]
    return found if len(found) == width and "=" not in last and not all(map(looks_numeric, found)) else []


def too_wide(where: str, row: Sequence[str], width: int, separator: str) -> RecordingError:
    """Return the error about a row with more cells than there are headers."""
    count = max(index for index, cell in enumerate(row, start=1) if cell.strip())
    said = f"{where} has {count} cells for {width} headers"
    if separator == "," and "." not in "".join(row):
        return RecordingError(f"{said}; with decimal commas separate the columns with semicolons")
    return RecordingError(f"{said}; name every column, or put cells with {SEPARATOR_WORDS[separator]} in quotes")


def _metadata_of(rows: Sequence[Sequence[str]], separator: str) -> dict[str, MetadataValue]:
    """Return what lines above the table state as ``key = value`` or ``key: value``, or as two cells."""
    found: dict[str, MetadataValue] = {}
    for row in rows:
        text = separator.join(row)
        pair = _assignment(text)
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
