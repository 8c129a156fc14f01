"""Matching the headers of a table to columns: by our own name, by the caller's mapping, or by a synonym."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from musclewire.errors import RecordingError, nearest_hint
from musclewire.signals.columns import (
    BRANCH_TABLE,
    COLUMNS,
    Column,
    columns_called,
    key_of_header,
    known_column,
)
from musclewire.signals.units import Conversion, conversion_to_si, measures

__all__ = ["MatchedHeader", "IgnoredHeader", "numbered_headers", "split_header", "understand_headers"]


@dataclass(frozen=True)
class MatchedHeader:
    """A header, the column it was matched to, and the conversion of its numbers to SI.

    ``value_si = factor * value + offset``; ``unit`` is that of the header or the mapping, or our own.
    """

    header: str
    index: int
    column: str
    unit: str
    unit_given: bool
    factor: float
    offset: float
    how: Literal["own name", "synonym", "mapped"]

    @property
    def conversion(self) -> Conversion:
        """The conversion of the numbers under this header to SI."""
        return Conversion(self.factor, self.offset)


@dataclass(frozen=True)
class IgnoredHeader:
    """A header that was not used, and why."""

    header: str
    reason: str


_BRACKETS = re.compile(r"\s*(?P<name>.*?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]\s*")
_SLASH = re.compile(r"\s*(?P<name>.+?)\s*/\s*(?P<unit>.+?)\s*")
_LAST_WORD = re.compile(r"\s*(?P<name>.+)[ _](?P<unit>[^ _]*[^\W\d_%][^ _]*|%)\s*")


_NUMBER = re.compile(r"\s*#(?P<number>\d+)\s*(?::(?P<unit>.*))?")


def numbered_headers(count: int) -> tuple[str, ...]:
    """Return the substitutes for headers in a file that has none: "#1", "#2", ..."""
    return tuple(f"#{number}" for number in range(1, count + 1))


def split_header(header: str) -> tuple[str, str | None]:
    """Return name and unit of "Name [unit]", "Name (unit)" or "Name / unit"; None without a unit."""
    match = _BRACKETS.fullmatch(header) or _SLASH.fullmatch(header)
    return (match["name"], match["unit"].strip()) if match else (header.strip(), None)


def understand_headers(
    headers: Sequence[str], mapping: Mapping[str, str] | None, path: str
) -> tuple[tuple[MatchedHeader, ...], tuple[IgnoredHeader, ...]]:
    """Return the headers that match a column, and those that are ignored.

    ``mapping`` is NAME -> "HEADER" or "HEADER:UNIT" and comes first; ``#2`` as HEADER is the second column, unless
    a header has this name.

    Raises
    ------
    RecordingError
        If a unit is missing, unknown or of another quantity, a mapped header does not exist, or two headers match one
        column; one line that begins with ``path``.
    CallerError
        For a NAME in ``mapping`` that is no column.
    """
    mapped = [_mapped(name, wanted, headers, path) for name, wanted in (mapping or {}).items()]
    by_index: dict[int, MatchedHeader | IgnoredHeader] = {taken.index: taken for taken in mapped}
    if len(by_index) < len(mapped):
        raise RecordingError(f"{path}: the mapping uses one header twice; map each header to one column")
    for index, header in enumerate(headers):
        if index not in by_index:
            by_index[index] = _recognised(header, index, path, already_mapped=frozenset(mapping or ()))
    found = [by_index[index] for index in range(len(headers))]
    taken = _as_branch_table([item for item in found if isinstance(item, MatchedHeader)])
    _check_taken_once(taken, path)
    return tuple(taken), tuple(item for item in found if isinstance(item, IgnoredHeader))


def _mapped(name: str, wanted: str, headers: Sequence[str], path: str) -> MatchedHeader:
    column = known_column(name)
    index, unit = _find(name, wanted, headers, path)
    header = headers[index]
    if unit is None:
        own = _own_column(split_header(header)[0])
        unit = split_header(header)[1] if own is None else own.unit
    return _taken(header, index, column, unit, "mapped", path)


def _find(name: str, wanted: str, headers: Sequence[str], path: str) -> tuple[int, str | None]:
    """Return the index of the header that ``wanted`` names, and the unit it adds."""
    header, colon, unit = wanted.rpartition(":")
    exactly: tuple[Callable[[str], str], ...] = (str, str.strip)
    loosely = (key_of_header, _key_of_name)
    # A header may hold a colon itself, so the whole text comes first; loosely it comes last, because without
    # its punctuation "strain:%" is "strain" and would lose the unit.
    tries = [(wanted, None, exactly), (header, unit.strip(), exactly + loosely), (wanted, None, loosely)]
    for text, extra, spellings in tries if colon else tries[::2]:
        for spelling in spellings:
            indices = [i for i, other in enumerate(headers) if spelling(text) == spelling(other)]
            if len(indices) == 1 and spelling(text):
                return indices[0], extra
            if indices and spelling(text):
                same = ", ".join(f"'{headers[i]}'" for i in indices)
                raise RecordingError(f"{path}: {name}={wanted} fits {same}; write the whole header, with its unit")
    counted = _NUMBER.fullmatch(wanted)
    if counted and 0 < int(counted["number"]) <= len(headers):
        return int(counted["number"]) - 1, counted["unit"].strip() if counted["unit"] else None
    hint = nearest_hint(header if colon else wanted, headers)
    raise RecordingError(f"{path}: no column '{header if colon else wanted}', mapped to {name}{hint}")


def _key_of_name(header: str) -> str:
    return key_of_header(split_header(header)[0])


def _recognised(header: str, index: int, path: str, already_mapped: frozenset[str]) -> MatchedHeader | IgnoredHeader:
    name, unit = split_header(header)
    own = _own_column(name)
    if own is not None:
        return _taken_by_own_name(header, index, own, unit, path, already_mapped)
    candidates = columns_called(name)
    if unit is None and not candidates:
        name, unit, candidates = _with_unit_as_last_word(header)
    candidates = tuple(column for column in candidates if column.name not in already_mapped)
    if not candidates:
        return IgnoredHeader(
            header, "its column is mapped to another header" if columns_called(name) else "name not known"
        )
    fitting = [column for column in candidates if unit is not None and measures(unit, column.name)]
    column = (fitting or list(candidates))[0]
    if unit is None and column.unit and column.kind == "control":
        return IgnoredHeader(header, f"would be {column.name}, and has no unit")
    return _taken(header, index, column, unit, "synonym", path)


def _own_column(name: str) -> Column | None:
    return COLUMNS.get("_".join(name.lower().split()))


def _taken_by_own_name(
    header: str, index: int, own: Column, unit: str | None, path: str, already_mapped: frozenset[str]
) -> MatchedHeader | IgnoredHeader:
    if own.name in already_mapped:
        return IgnoredHeader(header, "its column is mapped to another header")
    taken = _taken(header, index, own, own.unit if unit is None else unit, "own name", path)
    # A dimensionless name states no unit, so percent is allowed; time_s in ms is a contradiction.
    if own.unit and (taken.factor != 1.0 or taken.offset):
        raise RecordingError(
            f"{path}: column '{header}': {own.name} is in {own.unit} by its name, not in {unit}; rename it"
        )
    return replace(taken, unit_given=unit is not None)


def _with_unit_as_last_word(header: str) -> tuple[str, str | None, tuple[Column, ...]]:
    """Split "force_mN" and "Time ms" into name and unit if the rest is a known name and the last word its unit."""
    match = _LAST_WORD.fullmatch(header)
    if match is None:
        return header, None, ()
    candidates = tuple(c for c in columns_called(match["name"]) if measures(match["unit"], c.name))
    return (match["name"], match["unit"], candidates) if candidates else (header, None, ())


def _taken(
    header: str,
    index: int,
    column: Column,
    unit: str | None,
    how: Literal["own name", "synonym", "mapped"],
    path: str,
) -> MatchedHeader:
    if unit is None and column.unit:
        # The message suggests the SI unit, which the column needs in the end.
        bare = header.strip()
        raise RecordingError(
            f"{path}: column '{bare}' has no unit: write '{bare} [{column.unit}]' in the header "
            f"or map it: {column.name}={bare}:{column.unit}"
        )
    conversion = conversion_to_si(unit or "", column.name, f"{path}: column '{header.strip()}'")
    return MatchedHeader(
        header, index, column.name, unit or "", unit is not None, conversion.factor, conversion.offset, how
    )


def _as_branch_table(taken: list[MatchedHeader]) -> list[MatchedHeader]:
    """In a printed loop "resistance" is the abscissa of both branches, not a measurement over time."""
    columns = {item.column for item in taken}
    is_table = {"strain_heating", "strain_cooling"} <= columns and not {"time_s", BRANCH_TABLE[0]} & columns
    if not is_table:
        return taken
    return [replace(item, column=BRANCH_TABLE[0]) if item.column == "wire_resistance_ohm" else item for item in taken]


def _check_taken_once(taken: Sequence[MatchedHeader], path: str) -> None:
    first: dict[str, MatchedHeader] = {}
    for item in taken:
        other = first.setdefault(item.column, item)
        if other is not item:
            raise RecordingError(
                f"{path}: columns '{other.header}' and '{item.header}' are both taken as {item.column}: "
                f"map the one you mean: {item.column}={item.header}"
            )
