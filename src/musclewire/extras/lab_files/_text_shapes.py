"""Text that is a table in disguise: stamps before each line, names with their values, JSON, a table on its side.

Each function of ``SHAPES`` looks at the first lines and returns what turns the lines of such a file into those of a
plain table, or None. The rules for tables in text read what comes out, so that there is one parser.
"""

from __future__ import annotations

import itertools
import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from musclewire.extras.lab_files._number_style import is_missing, looks_numeric
from musclewire.extras.lab_files._text_layout import separator_of, split_lines
from musclewire.extras.lab_files._text_lines import Line
from musclewire.files import is_clock_text
from musclewire.signals import is_unit

_NUMBER = r"[+-]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?"
_PAIR = re.compile(r"\s*(?P<name>[^\W\d][^:=]*?|\d+\s*[^\W\d][^:=]*?)\s*[:=]\s*(?P<value>.*?)\s*")
# What may be between pairs, the surest first; a comma may be in a number, and a blank next to its unit.
_BETWEEN_PAIRS = (re.compile(r"[;|\t]|  +"), re.compile(r","), re.compile(r"\s+(?=[^\W\d][^\s:=]*\s*[:=])"))
_QUANTITY = re.compile(rf"({_NUMBER})\s*([^\W\d_][^\s\d]{{0,9}}|[%°Ω]\S{{0,4}})")
_STAMP = re.compile(r"\s*(?:\[\s*(?P<inside>[^\]]{5,40}?)\s*\]\s?|(?P<before>\S[^>]{3,38}?\S)\s*->\s?)")
_MIN_LINES = 4  # of a kind: fewer may be by chance
_MIN_PART = 0.9  # of the lines at hand, which have to be of it: a device prints a greeting among them
_MIN_SAMPLES_PER_SIGNAL = 5  # a table on its side has so many more columns than rows,
_MAX_SIGNALS = 64  # of which there are few


class Shape(NamedTuple):
    """What a file is, in words, and what makes lines of a plain table of its lines."""

    words: str
    lines: Callable[[Iterator[Line]], Iterator[Line]]
    separator: str = "\t"


def shape_of(head: Sequence[Line]) -> Shape | None:
    """Return the shape of a text by its first lines, None if it is a plain table."""
    return next((shape for find in SHAPES if (shape := find(head)) is not None), None)


def _most(found: int, head: Sequence[Line]) -> bool:
    return found >= _MIN_LINES and found >= _MIN_PART * (len(head) - 2)


def _stamped(head: Sequence[Line]) -> Shape | None:
    """Whatever a terminal puts a stamp in front of: "12:21:00.200 -> ..." or "[2026-03-01 12:21:00] ..."."""

    def parts(text: str) -> tuple[str, str] | None:
        match = _STAMP.match(text)
        stamp = "" if match is None else match["inside"] or match["before"]
        return (stamp, text[match.end() :]) if match is not None and is_clock_text(stamp) else None

    found = [(number, *both) for number, text in head if (both := parts(text)) is not None]
    if not _most(len(found), head):
        return None
    rest = [(number, text) for number, _, text in found if text.strip()]
    inner = shape_of(rest)
    plain = rest if inner is None else list(inner.lines(iter(rest)))
    separator = separator_of([text for _, text in plain]) if inner is None else "\t"

    def lines(all_lines: Iterator[Line]) -> Iterator[Line]:
        stamps: dict[int, str] = {}

        def without() -> Iterator[Line]:
            for number, text in all_lines:
                both = parts(text)
                if both is not None:
                    stamps[number] = both[0]
                yield number, text if both is None else both[1]

        for number, text in without() if inner is None else inner.lines(without()):
            stamp = stamps.pop(number, None)
            headers = inner is not None and not number
            # Separated by blanks, the stamp's own would be a separator.
            joint = "\t" if separator == " " else separator
            row = joint.join(text.split()) if separator == " " else text
            yield number, text if stamp is None and not headers else f"{'stamp' if headers else stamp}{joint}{row}"

    words = "a stamp before each line" if inner is None else f"a stamp before {inner.words}"
    return Shape(words, lines, "\t" if separator == " " else separator)


def _json_lines(head: Sequence[Line]) -> Shape | None:
    """An object a line, as MicroPython, MQTT and dashboards write."""

    def object_in(text: str) -> dict[str, object] | None:
        try:
            found = json.loads(text) if text.lstrip().startswith("{") else None
        except (ValueError, RecursionError):
            return None
        return found if isinstance(found, dict) else None

    found = [each for _, text in head if (each := object_in(text)) is not None]
    if not _most(len(found), head):
        return None
    names = list(dict.fromkeys(name for each in found for name in each))

    def lines(all_lines: Iterator[Line]) -> Iterator[Line]:
        yield 0, _joined(names)
        for number, text in all_lines:
            each = object_in(text)
            cells = [] if each is None else [each.get(name) for name in names]
            yield number, text if each is None else _joined("" if cell is None else str(cell) for cell in cells)

    return Shape("a JSON object a line", lines)


def _joined(cells: Iterator[str] | Sequence[str]) -> str:
    return "\t".join(" ".join(cell.split()) for cell in cells)


def _value_of(text: str) -> str | None:
    """Return a value of a pair as a cell, None if it is neither a number, with its unit or without, nor one word."""
    text = text.strip()
    match = _QUANTITY.fullmatch(text)
    if looks_numeric(text) or is_missing(text) or is_clock_text(text) or (match is not None and is_unit(match[2])):
        return text
    return text if text and text.isalpha() else None


def _pairs_in(text: str) -> dict[str, str] | None:
    """Return the names with their values of a line that holds nothing else."""
    for between in _BETWEEN_PAIRS:
        found = _pairs_of([part for part in between.split(text) if part.strip()])
        if found is not None:
            return found
    return None


def _pairs_of(parts: Sequence[str]) -> dict[str, str] | None:
    pairs: dict[str, str] = {}
    for part in parts:
        match = _PAIR.fullmatch(part)
        value = None if match is None else _value_of(match["value"])
        if match is None or value is None:
            return None
        pairs[match["name"]] = value
    return pairs or None


def _lines_of_pairs(head: Sequence[Line]) -> Shape | None:
    """A sketch's prints: names with their values in each line."""
    found = [pairs for _, text in head if (pairs := _pairs_in(text)) is not None and len(pairs) > 1]
    if not _most(len(found), head):
        return None
    names = list(dict.fromkeys(name for pairs in found for name in pairs))
    if sum(map(len, found)) < 0.8 * len(names) * len(found):
        return None

    def lines(all_lines: Iterator[Line]) -> Iterator[Line]:
        yield 0, _joined(names)
        for number, text in all_lines:
            pairs = _pairs_in(text) or {}
            # A line that is none of these is a row without its numbers: it is asked about, not passed over.
            known = any(name in pairs for name in names)
            yield number, _joined([pairs.get(name, "") for name in names]) if known else text

    return Shape("names with values in each line", lines)


def _blocks_of_pairs(head: Sequence[Line]) -> Shape | None:
    """A sketch's prints: a line for each name with its value, and again from the first name on."""

    def pair_in(text: str) -> tuple[str, str] | None:
        pairs = _pairs_in(text)
        return next(iter(pairs.items())) if pairs is not None and len(pairs) == 1 else None

    words = [(number, text) for number, text in head if any(map(str.isalnum, text))]
    found = [pair for _, text in words if (pair := pair_in(text)) is not None]
    counted = Counter(name for name, _ in found)
    if (
        not _most(len(found), words)
        or min(counted.values()) * 3 < max(counted.values())
        or counted[found[0][0]] < _MIN_LINES
    ):
        return None
    if sum(any(map(str.isdigit, value)) for _, value in found) < 0.5 * len(found):
        return None
    names, first = list(counted), found[0][0]

    def lines(all_lines: Iterator[Line]) -> Iterator[Line]:
        yield 0, _joined(names)
        block: dict[str, str] = {}
        began = 0
        for number, text in all_lines:
            pair = pair_in(text)
            if pair is None:
                continue
            if pair[0] == first:
                if block:
                    yield began, _joined([block.get(name, "") for name in names])
                block, began = {}, number
            block[pair[0]] = pair[1]
        # The print may have ended within a block.
        if len(block) == len(names):
            yield began, _joined([block[name] for name in names])

    return Shape(f"names with values, {len(names)} lines a row", lines)


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


SHAPES = (_stamped, _json_lines, _blocks_of_pairs, _lines_of_pairs, _signals_in_rows)
