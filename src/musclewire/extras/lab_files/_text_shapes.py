"""Text that is a table in disguise: stamps before each line, names with their values, JSON, a table on its side.

The first lines show what turns the lines of such a file into those of a plain table. The rules for tables in text read
what comes out, so that there is one parser.
"""

from __future__ import annotations

import itertools
import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

from musclewire.extras.lab_files._number_style import looks_numeric
from musclewire.extras.lab_files._text_layout import kind_of, separator_of, split_lines
from musclewire.extras.lab_files._text_lines import Line
from musclewire.files import is_clock_text

_PAIR = re.compile(r"\s*(?P<name>[^\W\d][^:=]*?|\d+\s*[^\W\d][^:=]*?)\s*[:=]\s*(?P<value>.*?)\s*")
# What may be between pairs, the surest first; a comma may be in a number, and a blank next to its unit.
_BETWEEN_PAIRS = (re.compile(r"[;|\t]|  +"), re.compile(r","), re.compile(r"\s+(?=[^\W\d][^\s:=]*\s*[:=])"))
_STAMP = re.compile(r"\s*(?:\[\s*(?P<inside>[^\]]{5,40}?)\s*\]\s?|(?P<before>\S[^>]{3,38}?\S)\s*->\s?)")
_MIN_LINES = 4  # of a kind: fewer may be by chance
_MIN_PART = 0.9  # of the lines at hand, which have to be of it: a device prints a greeting among them
_MIN_FILLED = 0.5  # of the cells of a table made of names with values
_MIN_SAMPLES_PER_SIGNAL = 5  # a table on its side has so many more columns than rows,
_MAX_SIGNALS = 64  # of which there are few


class Shape(NamedTuple):
    """What a file is, in words, and what makes lines of a plain table of its lines."""

    words: str
    lines: Callable[[Iterator[Line]], Iterator[Line]]
    separator: str = "\t"


def shape_of(head: Sequence[Line]) -> Shape | None:
    """Return the shape of a text by its first lines, None if it is a plain table."""
    is_stamped = _are_most([text for _, text in head if _stamp_and_rest(text)[0]], head)
    named = _named_values(head, is_stamped)
    return named or (_stamped(head) if is_stamped else _signals_in_rows(head))


def _are_most(found: Sequence[object], among: Sequence[object]) -> bool:
    return len(found) >= _MIN_LINES and len(found) >= _MIN_PART * (len(among) - 2)


def _stamp_and_rest(text: str) -> tuple[str, str]:
    """Return what a terminal puts before a line ("12:21:00.200 -> ...", "[2026-03-01 12:21:00] ..."), and the line."""
    match = _STAMP.match(text)
    stamp = match["inside"] or match["before"] if match is not None else ""
    return (stamp, text[match.end() :]) if match is not None and is_clock_text(stamp) else ("", text)


def _stamped(head: Sequence[Line]) -> Shape:
    """A plain table whose lines each have a stamp before them, which becomes its first column."""
    pairs = (_stamp_and_rest(text) for _, text in head)
    separator = separator_of([rest for stamp, rest in pairs if stamp and rest.strip()])
    # Separated by blanks, the stamp's own would be a separator.
    joint = "\t" if separator == " " else separator

    def lines(all_lines: Iterator[Line]) -> Iterator[Line]:
        for number, text in all_lines:
            stamp, rest = _stamp_and_rest(text)
            row = joint.join(rest.split()) if separator == " " else rest
            yield number, f"{stamp}{joint}{row}" if stamp else row

    return Shape("a stamp before each line", lines, joint)


def _values_in(text: str) -> dict[str, str]:
    """Return the names with their values of a line that holds nothing else, as JSON or as pairs."""
    if text.lstrip().startswith("{"):
        try:
            found = json.loads(text)
        except (ValueError, RecursionError):
            return {}
        return {name: "" if value is None else str(value) for name, value in found.items()}
    for between in _BETWEEN_PAIRS:
        pairs = [_PAIR.fullmatch(part) for part in between.split(text) if part.strip()]
        values = {pair["name"]: pair["value"] for pair in pairs if pair is not None and _is_value(pair["value"])}
        if len(values) == len(pairs):
            return values
    return {}


def _is_value(text: str) -> bool:
    return kind_of(text) != "text" or text.isalpha()


def _named_values(head: Sequence[Line], is_stamped: bool) -> Shape | None:
    """What a sketch, MQTT or a dashboard prints: values with their names, a row in each line or a value in each line.

    Of several lines a row begins with the first name.
    """

    def parts(text: str) -> tuple[list[str], dict[str, str]]:
        stamp, rest = _stamp_and_rest(text) if is_stamped else ("", text)
        return [stamp] if is_stamped else [], _values_in(rest)

    words = [text for _, text in head if any(map(str.isalnum, text))]
    found = [values for text in words if (values := parts(text)[1])]
    is_row_a_line = 2 * sum(len(values) > 1 for values in found) > len(found)
    found = [values for values in found if (len(values) > 1) == is_row_a_line]
    counted = Counter(name for values in found for name in values)
    names, cells = list(counted), [value for values in found for value in values.values()]
    if (
        not _are_most(found, words)
        or counted[names[0]] < _MIN_LINES
        or len(cells) < _MIN_FILLED * len(names) * max(counted.values())
        or 2 * sum(any(map(str.isdigit, cell)) for cell in cells) < len(cells)
    ):
        return None

    def lines(all_lines: Iterator[Line]) -> Iterator[Line]:
        yield 0, _joined([*(["stamp"] if is_stamped else []), *names])
        began, stamp, row = 0, list[str](), dict[str, str]()
        for number, text in all_lines:
            first, values = parts(text)
            if is_row_a_line:
                # A line that is none of these is a row without its numbers: it is asked about, not passed over.
                known = not counted.keys().isdisjoint(values)
                yield number, _joined([*first, *(values.get(name, "") for name in names)]) if known else text
                continue
            # So does one whose first name is damaged with any name that comes again.
            if names[0] in values or not row.keys().isdisjoint(values):
                if row:
                    yield began, _joined([*stamp, *(row.get(name, "") for name in names)])
                began, stamp, row = number, first, {}
            row |= values
        # The print may have ended within a row; names that are rare are damaged ones.
        if all(name in row for name, count in counted.items() if 2 * count > max(counted.values())):
            yield began, _joined([*stamp, *(row.get(name, "") for name in names)])

    stamps = "a stamp before " if is_stamped else ""
    how = " in each line" if is_row_a_line else f", {len(names)} lines a row"
    return Shape(f"{stamps}names with values{how}", lines)


def _joined(cells: Iterable[str]) -> str:
    return "\t".join(" ".join(cell.split()) for cell in cells)


def _signals_in_rows(head: Sequence[Line]) -> Shape | None:
    """A table on its side: a line for each signal, its name first."""
    if not 2 <= len(head) <= _MAX_SIGNALS:
        return None
    texts = [text for _, text in head]
    separator = separator_of(texts)
    rows = split_lines(texts, separator)
    count = max(map(len, rows))
    whole = [row for row in rows if len(row) == count]
    # Numbers that run to the right, below each other a name.
    if count < _MIN_SAMPLES_PER_SIGNAL * len(rows) or len(whole) < 2 or any(looks_numeric(row[0]) for row in whole):
        return None

    def lines(all_lines: Iterator[Line]) -> Iterator[Line]:
        wide = [row for row in split_lines([text for _, text in all_lines], separator) if len(row) == count]
        for number, cells in enumerate(itertools.zip_longest(*wide, fillvalue=""), start=0):
            yield number, _joined(cells)

    return Shape("a signal in each line", lines)
