"""Text that is a table in disguise: what instruments put around their numbers, and what sketches print.

Each function of ``SHAPES`` looks at the first lines and returns what turns the lines of such a file into those of a
plain table, or None. The rules for tables in text read what comes out, so that there is one parser.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from musclewire.errors import RecordingError
from musclewire.signals._number_style import is_missing, looks_numeric
from musclewire.signals._text_lines import Line
from musclewire.signals._units import is_unit

_NUMBER = r"[+-]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?"
_PAIR = re.compile(rf"\s*(?P<name>[^\W\d][^:=]*?)\s*[:=]\s*(?P<value>{_NUMBER}|[^\W\d]+)\s*(?P<unit>[^\s\d:=,;]*)\s*")
_PAIRS = re.compile(
    rf"(?P<name>[^\W\d](?:\w| (?=\w))*)\s*[:=]\s*(?P<value>{_NUMBER}?|[^\W\d]+)\s*(?P<unit>[^\s\d:=,;|]*)(?:[\s,;|]+|$)"
)
_START = re.compile(rf"\s*t0\s*=\s*({_NUMBER})\s*")
_STEP = re.compile(rf"\s*tInc\s*=\s*({_NUMBER})\s*")
_AXIS = frozenset({"time", "source", "x-axis", "x"})
# Fewer lines of a kind may be anything.
_LEAST = 4


class Shape(NamedTuple):
    """What a file is, in words, and what makes lines of a plain table of its lines."""

    words: str
    lines: Callable[[Iterator[Line]], Iterator[Line]]


def shape_of(head: Sequence[Line], path: str) -> Shape | None:
    """Return the shape of a text by its first lines, None if it is a plain table."""
    return next((shape for find in SHAPES if (shape := find(head, path)) is not None), None)


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split(",")]


def _preamble_to_the_left(head: Sequence[Line], path: str) -> Shape | None:
    """Tektronix TDS: three columns of settings, then time and voltage; only the first rows have the settings."""
    del path
    if not head or not head[0][1].startswith("Record Length,") or len(_cells(head[0][1])) < 5:
        return None
    if not all(map(looks_numeric, _cells(head[0][1])[3:5])):
        return None
    stated = {cells[0]: cells[1] for cells in (_cells(text) for _, text in head[:30]) if len(cells) > 1 and cells[0]}
    channel, volts = stated.get("Source") or "CH1", stated.get("Vertical Units") or ""
    headers = f"Time [{stated.get('Horizontal Units') or 's'}],{channel}" + (f" [{volts}]" if volts else "")

    def rows(lines: Iterator[Line]) -> Iterator[Line]:
        yield 0, headers
        for number, text in lines:
            yield number, ",".join(_cells(text)[3:5])

    return Shape("an oscilloscope's settings to the left of its numbers", rows)


def _counted_rows(head: Sequence[Line], path: str) -> Shape | None:
    """Rigol: the first row states the time of the first sample and the step, and the rows are counted."""
    del path
    if len(head) < _LEAST:
        return None
    names = _cells(head[0][1])
    found = {
        key: [match[1] for name in names if (match := sign.fullmatch(name))]
        for key, sign in (("start", _START), ("step", _STEP))
    }
    below = _cells(head[1][1])
    if found["start"] and found["step"]:
        start, step, skip = float(found["start"][0]), float(found["step"][0]), 1
        kept = [index for index, name in enumerate(names) if name and "=" not in name]
        headers = [names[index] for index in kept]
    elif {"Start", "Increment"} <= set(names) and len(below) > max(map(names.index, ("Start", "Increment"))):
        stated = [below[names.index(key)] for key in ("Start", "Increment")]
        if not all(map(looks_numeric, stated)):
            return None
        start, step, skip = float(stated[0]), float(stated[1]), 2
        kept = [index for index, name in enumerate(names) if name not in {"", "X", "Start", "Increment"}]
        kept = [index for index in kept if index < len(below)]
        headers = [f"{names[index]} [{below[index]}]" if is_unit(below[index]) else names[index] for index in kept]
    else:
        return None

    def rows(lines: Iterator[Line]) -> Iterator[Line]:
        yield 0, ",".join(["Time [s]", *headers])
        for count, (number, text) in enumerate(itertools.islice(lines, skip, None)):
            cells = _cells(text)
            yield number, ",".join([repr(start + count * step), *(cells[i] if i < len(cells) else "" for i in kept)])

    return Shape(f"an oscilloscope's rows from {start:g} s on, every {step:g} s", rows)


def _units_above(head: Sequence[Line], path: str) -> Shape | None:
    """Siglent and today's Tektronix: units of axis and channels in lines above the headers."""
    del path
    stated = {cells[0].lower(): cells[1:] for cells in (_cells(text) for _, text in head[:60]) if len(cells) > 1}
    across, along = stated.get("horizontal units"), stated.get("vertical units")
    if not across or along is None:
        return None
    where = [number for number, text in head if _cells(text)[0].lower() in _AXIS and len(_cells(text)) > 1]
    if not where:
        return None
    units = [across[0], *(cell.rpartition(":")[2] for cell in along)]

    def rows(lines: Iterator[Line]) -> Iterator[Line]:
        for number, text in lines:
            if number < where[0]:
                yield number, text
            elif number == where[0]:
                names = ["Time", *_cells(text)[1:]]
                stated = [units[index] if index < len(units) else "" for index in range(len(names))]
                yield number, ",".join(f"{n} [{u}]" if u else n for n, u in zip(names, stated, strict=True))
            elif not _cells(text)[0].lower().startswith("second"):
                yield number, text

    return Shape("an oscilloscope's settings above its numbers", rows)


def _unit_of(unit: str) -> str:
    return unit if unit and is_unit(unit) else ""


def _as_table(
    names: Sequence[str], units: dict[str, str], found: Iterator[tuple[int, dict[str, tuple[str, str]]]], path: str
) -> Iterator[Line]:
    """Yield headers and rows of what was printed as names with values; a unit that changes on the way is an error."""
    yield 0, "\t".join(f"{name} [{units[name]}]" if units[name] else name for name in names)
    for number, values in found:
        for name, (_, unit) in values.items():
            if name in units and _unit_of(unit) != units[name]:
                said = f"'{unit}' and before '{units[name]}'"
                raise RecordingError(
                    f"{path}: line {number}: the unit of '{name}' is {said}; write one unit throughout"
                )
        yield number, "\t".join(values.get(name, ("", ""))[0] for name in names)


def _blocks_of_pairs(head: Sequence[Line], path: str) -> Shape | None:
    """A sketch's prints: a line for each name with its value, and again from the first name on."""
    pairs = [match for _, text in head if (match := _PAIR.fullmatch(text))]
    counted = Counter(match["name"] for match in pairs)
    if not pairs or min(counted.values()) * 3 < max(counted.values()) or counted[pairs[0]["name"]] < _LEAST:
        return None
    values = sum(looks_numeric(match["value"]) for match in pairs)
    # A rule between blocks is no pair; anything else that often is not would make it another kind of file.
    words = [text for _, text in head if any(map(str.isalnum, text))]
    if len(pairs) < 0.9 * len(words) or values < 0.5 * len(pairs):
        return None
    first = pairs[0]["name"]
    names = list(counted)
    units = {match["name"]: _unit_of(match["unit"]) for match in reversed(pairs)}

    def blocks(lines: Iterator[Line]) -> Iterator[tuple[int, dict[str, tuple[str, str]]]]:
        block: dict[str, tuple[str, str]] = {}
        began = 0
        for number, text in lines:
            match = _PAIR.fullmatch(text)
            if match is None:
                continue
            if match["name"] == first:
                if block:
                    yield began, block
                block, began = {}, number
            block[match["name"]] = (match["value"], match["unit"])
        # The print may have ended within a block.
        if len(block) == len(names):
            yield began, block

    return Shape(
        f"names with values, {len(names)} lines a row", lambda lines: _as_table(names, units, blocks(lines), path)
    )


def _lines_of_pairs(head: Sequence[Line], path: str) -> Shape | None:
    """A sketch's prints: names with their values in each line."""

    def pairs_in(text: str) -> dict[str, tuple[str, str]] | None:
        found: dict[str, tuple[str, str]] = {}
        end = 0
        for match in _PAIRS.finditer(text.strip()):
            if match.start() != end:
                return None
            end = match.end()
            found[match["name"]] = (match["value"], match["unit"])
        return found if end == len(text.strip()) and len(found) > 1 else None

    lines_with = [pairs for _, text in head if (pairs := pairs_in(text)) is not None]
    if len(lines_with) < _LEAST or len(lines_with) < 0.9 * len(head):
        return None
    names = list(lines_with[len(lines_with) // 2])
    numbers = [looks_numeric(pairs[name][0]) for pairs in lines_with for name in names if name in pairs]
    if sum(numbers) < 0.5 * len(lines_with) * len(names):
        return None
    units = {name: _unit_of(next(pairs[name][1] for pairs in lines_with if name in pairs)) for name in names}

    def rows(lines: Iterator[Line]) -> Iterator[tuple[int, dict[str, tuple[str, str]]]]:
        began = False
        for number, text in lines:
            pairs = pairs_in(text)
            began = began or pairs is not None
            # A line in between that is none of these is a row without its numbers: it is asked about, not passed over.
            if began and (pairs is not None or any(map(str.isalnum, text))):
                found = pairs or {}
                yield number, {name: pair for name, pair in found.items() if name in units and not is_missing(pair[0])}

    return Shape("names with values in each line", lambda lines: _as_table(names, units, rows(lines), path))


SHAPES = (_preamble_to_the_left, _counted_rows, _units_above, _blocks_of_pairs, _lines_of_pairs)
