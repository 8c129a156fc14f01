"""Matching the columns of a table to ours: by our own name, by the caller's mapping, or by a synonym."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from musclewire.errors import RecordingError, argument, nearest_hint
from musclewire.files._import_mapping import ImportMapping
from musclewire.files._source_table import SourceColumn
from musclewire.signals import (
    BRANCH_TABLE,
    COLUMNS,
    Column,
    UnitConversion,
    columns_called,
    conversion_to_si,
    is_unit,
    key_of_header,
    known_column,
    measures,
    scale_between,
    scale_to_si,
)

How = Literal["own name", "synonym", "mapped", "values", "unit"]


@dataclass(frozen=True)
class MatchedHeader:
    """A header, the column it was matched to, and the conversion of its numbers to SI.

    ``value_si = factor * value + offset``; ``unit`` is that of the header or the mapping, or our own. ``is_text`` is
    True for times as text, which become seconds since the first of them.
    """

    header: str
    index: int
    column: str
    unit: str
    unit_given: bool
    factor: float
    offset: float
    how: How
    is_text: bool = False

    @property
    def conversion(self) -> UnitConversion:
        """The conversion of the numbers under this header to SI."""
        return UnitConversion(self.factor, self.offset)


@dataclass(frozen=True)
class IgnoredHeader:
    """A header that was not used, and why."""

    header: str
    reason: str


@dataclass(frozen=True)
class EmptyHeader(IgnoredHeader):
    """A header without a number below it, and the column that it would have been; None if its name is not known."""

    column: str | None


@dataclass(frozen=True)
class UndecidedHeader:
    """A header that would be a column, and the message that says what has to be decided first."""

    header: str
    index: int
    column: str
    message: str


class HeaderWithoutUnit(UndecidedHeader):
    """A header that would be a column if something stated its unit."""


@dataclass(frozen=True)
class HeaderMatch:
    """What became of every header."""

    taken: tuple[MatchedHeader, ...]
    ignored: tuple[IgnoredHeader, ...]
    undecided: tuple[UndecidedHeader, ...] = ()


class _NoUnitError(RecordingError):
    """Nothing states the unit of a column."""


class _AbsentHeaderError(RecordingError):
    """A mapping names a header that the table does not have."""


_BRACKETS = re.compile(r"\s*(?P<name>.*?)\s*(?:[\[(](?P<unit>[^\[\]()]*)[\])]|[<{](?P<other>[^<>{}]*)[>}])\s*")
_SLASH = re.compile(r"\s*(?P<name>.+?)\s*/\s*(?P<unit>.+?)\s*")
# What is between a name and its unit: "force_mN", "Time ms", "Voltage in V", "Zeit, s", "Strain%".
_BEFORE_UNIT = re.compile(r"\s+in\s+|\s*[,;:]\s*|[ _.\-]+|(?=[%°])")


_NUMBER = re.compile(r"\s*#(?P<number>\d+)\s*(?::(?P<unit>.*))?")
# A mapping that says how a clock is written, which holds a colon itself.
_WRITTEN_CLOCK = re.compile(r"(?P<header>.+):(?P<form>mm:ss|hh:mm)")


def numbered_headers(count: int) -> tuple[str, ...]:
    """Return the substitutes for headers in a file that has none: "#1", "#2", ..."""
    return tuple(f"#{number}" for number in range(1, count + 1))


def split_header(header: str) -> tuple[str, str | None]:
    """Return name and unit of "Name [unit]", "Name (unit)" or "Name / unit"; None without a unit."""
    match = _BRACKETS.fullmatch(header) or _SLASH.fullmatch(header)
    if match is None:
        return header.strip(), None
    parts = match.groupdict()
    return parts["name"], (parts["unit"] if parts["unit"] is not None else parts["other"]).strip()


def match_columns(
    columns: Sequence[SourceColumn],
    mapping: Mapping[str, str] | None,
    path: str,
    ignore: Sequence[str] = (),
    only_mapped: bool = False,
    clock: MatchedHeader | UndecidedHeader | None = None,
    of_the_clock: Sequence[int] = (),
    trust_mapping: bool = False,
) -> HeaderMatch:
    """Return what becomes of each column: taken, ignored with a reason, or undecided with a message.

    ``mapping`` is NAME -> "HEADER" or "HEADER:UNIT" and comes first; ``#2`` as HEADER is the second column, unless
    a header has this name. ``ignore`` are headers that are left out; with ``only_mapped`` so are all that are not in
    the mapping. ``clock`` is what the clock was found to be, ``of_the_clock`` are its columns. With ``trust_mapping``
    a unit of the mapping holds against one that the file states.

    Raises
    ------
    RecordingError
        If the mapping's unit is missing, unknown, of another quantity or not the one that the file states, a mapped or
        ignored header does not exist, or one header is mapped twice; one line that begins with ``path``.
    CallerError
        For a NAME in ``mapping`` that is no column.
    """
    others = {name: wanted for name, wanted in (mapping or {}).items() if name != "time_s"}
    mapped = [_mapped(name, wanted, columns, path, trust_mapping) for name, wanted in others.items()]
    by_index: dict[int, MatchedHeader | IgnoredHeader | UndecidedHeader] = {taken.index: taken for taken in mapped}
    if len(by_index) < len(mapped) or (mapping and "time_s" in mapping and set(by_index) & set(of_the_clock)):
        raise RecordingError(f"{path}: the mapping uses one header twice; map each header to one column")
    by_index |= _left_out(columns, ignore, by_index, path)
    if clock is not None:
        by_index |= {index: IgnoredHeader(columns[index].header, "part of the clock") for index in of_the_clock}
        by_index[clock.index] = clock
    for index, column in enumerate(columns):
        if index in by_index:
            continue
        if only_mapped:
            by_index[index] = IgnoredHeader(column.header, "not in the mapping file")
            continue
        found_by_name = _recognised(column, index, path, frozenset(mapping or ()), clock)
        if column.is_empty:
            would_be = None if isinstance(found_by_name, IgnoredHeader) else found_by_name.column
            found_by_name = EmptyHeader(column.header, "is empty", would_be)
        by_index[index] = found_by_name
    found = [by_index[index] for index in range(len(columns))]
    taken = _as_branch_table([item for item in found if isinstance(item, MatchedHeader)])
    taken, anybodys = _voltage_of_the_wire(taken, path)
    taken, twice = _taken_once(taken, path)
    undecided = (*anybodys, *(item for item in found if isinstance(item, UndecidedHeader)))
    ignored = tuple(item for item in found if isinstance(item, IgnoredHeader))
    return HeaderMatch(tuple(taken), ignored, undecided + twice)


def name_and_unit(column: SourceColumn) -> tuple[str, str | None]:
    """Return the name of a column, and the unit that the file states of it: next to its header, or in it."""
    name, unit = split_header(column.header)
    if column.unit is not None:
        return name, column.unit
    if unit is None:
        own = _own_column(name)
        return (name, own.unit) if own is not None else _with_unit_as_last_words(column.header)
    return name, unit


def index_of(name: str, wanted: str, columns: Sequence[SourceColumn], path: str) -> tuple[int, str | None]:
    """Return the column that a mapping names, and the unit that it adds."""
    return _find(name, wanted, [column.header for column in columns], path)


def indices_left_out(columns: Sequence[SourceColumn], mapping: ImportMapping, path: str) -> frozenset[int]:
    """Return the columns that a mapping takes for something else than the clock, or ignores."""
    taken = {index_of(name, wanted, columns, path)[0] for name, wanted in mapping.columns.items() if name != "time_s"}
    return frozenset(taken | set(_left_out(columns, mapping.ignore, {}, path)))


def missing_from(
    columns: Sequence[SourceColumn], mapping: Mapping[str, str], ignore: Sequence[str]
) -> tuple[frozenset[str], frozenset[str]]:
    """Return the names of a mapping and the ignored headers that a table does not have."""
    headers = [column.header for column in columns]

    def absent(name: str, wanted: str) -> bool:
        try:
            _find(name, wanted, headers, "")
        except _AbsentHeaderError:
            return True
        except RecordingError:
            return False
        return False

    names = frozenset(name for name, wanted in mapping.items() if absent(name, wanted))
    return names, frozenset(header for header in ignore if not _indices_called(header, columns))


def _left_out(
    columns: Sequence[SourceColumn],
    ignore: Sequence[str],
    mapped: Mapping[int, object],
    path: str,
) -> dict[int, IgnoredHeader]:
    found: dict[int, IgnoredHeader] = {}
    for wanted in ignore:
        indices = _indices_called(wanted, columns)
        if not indices:
            hint = nearest_hint(wanted, [column.header for column in columns])
            raise RecordingError(f"{path}: no column '{wanted}' to ignore{hint}")
        for index in indices:
            if index in mapped:
                raise RecordingError(f"{path}: column '{columns[index].header}' is both mapped and ignored; choose one")
            found[index] = IgnoredHeader(columns[index].header, "as asked for")
    return found


def _indices_called(wanted: str, columns: Sequence[SourceColumn]) -> list[int]:
    """Return the columns that a text names: exactly, else by letters and digits, without a unit, or by number."""
    counted = _NUMBER.fullmatch(wanted)
    # "#2" is the second column, and never the one that is headed "2".
    spellings: tuple[Callable[[str], str], ...] = (str.strip, key_of_header, _key_of_name)
    for spelling in spellings[:1] if counted else spellings:
        indices = [i for i, column in enumerate(columns) if spelling(wanted) == spelling(column.header) != ""]
        if indices:
            return indices
    in_range = counted is not None and 0 < int(counted["number"]) <= len(columns)
    return [int(counted["number"]) - 1] if counted and in_range else []


def _mapped(name: str, wanted: str, columns: Sequence[SourceColumn], path: str, trust_mapping: bool) -> MatchedHeader:
    ours = known_column(name)
    index, unit = _find(name, wanted, [column.header for column in columns], path)
    column = columns[index]
    if column.is_text:
        raise RecordingError(f"{path}: column '{column.header}' holds text, not numbers; map another to {name}")
    stated = _own_unit(column)
    scale = None if unit is None else scale_to_si(unit, name, stated, f"{path}: column '{column.header}'")
    if unit is not None and scale is not None:
        return MatchedHeader(column.header, index, name, unit, True, scale.factor, scale.offset, "mapped")
    if unit is not None and stated and not trust_mapping:
        require_same(unit, stated, column.header, name, path)
    unit = stated if unit is None else unit
    if unit is None and ours.unit:
        raise RecordingError(
            f"{path}: column '{column.header}' has no unit: add it to the mapping, as {name}={wanted}:{ours.unit}"
        )
    return _taken(column.header, index, ours, unit, "mapped", path)


def require_same(unit: str, stated: str, header: str, name: str, path: str) -> None:
    """Raise RecordingError if a mapping gives another unit than the file states."""
    if not measures(unit, name) or (is_unit(stated) and scale_between(unit, stated) != 1.0):
        other = f"give the sensor's scale, as {name}={header}:0.5 {COLUMNS[name].unit}/{stated}"
        cure = "leave the unit out of the mapping" if measures(stated, name) else other
        raise RecordingError(
            f"{path}: column '{header}' states {stated}, the mapping of {name} {unit}: {cure}, or let the mapping hold "
            "(" + argument("trust_mapping", True) + ")"
        )


def _stated_unit(column: SourceColumn) -> str | None:
    """Return the unit next to a header, or in it."""
    return split_header(column.header)[1] if column.unit is None else column.unit


def _own_unit(column: SourceColumn) -> str | None:
    """Return the unit that a column states by itself: next to its header, in it, or by one of our names."""
    own = None if column.unit is not None else _own_column(split_header(column.header)[0])
    return _stated_unit(column) if own is None else own.unit


def _find(name: str, wanted: str, headers: Sequence[str], path: str) -> tuple[int, str | None]:
    """Return the index of the header that ``wanted`` names, and the unit it adds."""
    header, colon, unit = wanted.rpartition(":")
    if clock := _WRITTEN_CLOCK.fullmatch(wanted):
        header, unit = clock["header"], clock["form"]
    exactly: tuple[Callable[[str], str], ...] = (str, str.strip)
    counted = _NUMBER.fullmatch(wanted)
    # "#2" is the second column, and never the one that is headed "2".
    loosely = () if counted else (key_of_header, _key_of_name)
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
    if counted and 0 < int(counted["number"]) <= len(headers):
        return int(counted["number"]) - 1, counted["unit"].strip() if counted["unit"] else None
    hint = nearest_hint(header if colon else wanted, headers)
    raise _AbsentHeaderError(f"{path}: no column '{header if colon else wanted}', mapped to {name}{hint}")


def _key_of_name(header: str) -> str:
    return key_of_header(split_header(header)[0])


def _recognised(
    source: SourceColumn,
    index: int,
    path: str,
    already_mapped: frozenset[str],
    clock: MatchedHeader | UndecidedHeader | None,
) -> MatchedHeader | IgnoredHeader | UndecidedHeader:
    header = source.header
    name, unit = split_header(header)
    unit = unit if source.unit is None else source.unit
    own = _own_column(name)
    if unit is None and own is None:
        # "Strain %" is percent, though "strain" alone is a fraction and punctuation does not matter in a name.
        name, unit = _with_unit_as_last_words(header)
    candidates = columns_called(name) if own is None else (own,)
    known = bool(candidates)
    fitting = [column for column in candidates if unit is not None and measures(unit, column.name)]
    if known and {column.name for column in fitting or candidates} == {"time_s"}:
        return IgnoredHeader(header, "no clock" if clock is None else f"'{clock.header}' is the clock")
    candidates = tuple(column for column in candidates if column.name != "time_s")
    if own is not None and source.is_text:
        problem = f"{path}: column '{header}' holds text, not numbers; write numbers, or ignore this column"
        return UndecidedHeader(header, index, own.name, problem)
    if own is not None:
        return _taken_by_own_name(header, index, own, unit, path, already_mapped)
    candidates = tuple(column for column in candidates if column.name not in already_mapped)
    if not candidates:
        return IgnoredHeader(header, "its column is mapped to another header" if known else "name not known")
    if source.is_text:
        return IgnoredHeader(header, "holds text, not numbers")
    fitting = [column for column in candidates if unit is not None and measures(unit, column.name)]
    column = (fitting or list(candidates))[0]
    if unit is None and column.unit and column.kind == "control":
        return IgnoredHeader(header, f"would be {column.name}, and has no unit")
    return _taken_or_undecided(header, index, column, unit, path)


def _taken_or_undecided(
    header: str, index: int, column: Column, unit: str | None, path: str
) -> MatchedHeader | UndecidedHeader:
    try:
        return _taken(header, index, column, unit, "synonym", path)
    except RecordingError as problem:
        kind = HeaderWithoutUnit if isinstance(problem, _NoUnitError) else UndecidedHeader
        return kind(header, index, column.name, str(problem))


def _own_column(name: str) -> Column | None:
    return COLUMNS.get("_".join(name.lower().split()))


def _taken_by_own_name(
    header: str, index: int, own: Column, unit: str | None, path: str, already_mapped: frozenset[str]
) -> MatchedHeader | IgnoredHeader | UndecidedHeader:
    if own.name in already_mapped:
        return IgnoredHeader(header, "its column is mapped to another header")
    taken = _taken_or_undecided(header, index, own, own.unit if unit is None else unit, path)
    if isinstance(taken, UndecidedHeader):
        return taken
    # A dimensionless name states no unit, so percent is allowed; time_s in ms is a contradiction.
    if own.unit and (taken.factor != 1.0 or taken.offset):
        problem = f"{path}: column '{header}': {own.name} is in {own.unit} by its name, not in {unit}; rename it"
        return UndecidedHeader(header, index, own.name, problem)
    return replace(taken, unit_given=unit is not None, how="own name")


def _with_unit_as_last_words(header: str) -> tuple[str, str | None]:
    """Split "force_mN", "Time ms" and "Temp deg C" if the rest is a known name and the last words are its unit."""
    for sign in _BEFORE_UNIT.finditer(header):
        name, unit = header[: sign.start()], header[sign.end() :].strip()
        if any(measures(unit, column.name) for column in columns_called(name) if unit):
            return name.strip(), unit
    return header.strip(), None


def _taken(
    header: str,
    index: int,
    column: Column,
    unit: str | None,
    how: How,
    path: str,
) -> MatchedHeader:
    if unit is None and column.unit:
        # The message suggests the SI unit, which the column needs in the end.
        bare = header.strip()
        raise _NoUnitError(
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


# Names that a sensor's converter gives its own output as well.
_ANY_VOLTAGE = frozenset({"voltage", "volts", "v", "u", "spannung", "measuredvoltage"})
_OF_A_WIRE = frozenset({
    "wire_current_a", "shunt_voltage_v", "drive_voltage_v", "wire_resistance_ohm", "wire_temperature_k",
})  # fmt: skip


def _voltage_of_the_wire(
    taken: list[MatchedHeader], path: str
) -> tuple[list[MatchedHeader], tuple[UndecidedHeader, ...]]:
    """A voltage that only says so may be a sensor's, unless something else of the wire is next to it."""
    voltages = [item for item in taken if item.column == "wire_voltage_v"]
    alone = len(voltages) == 1 and not {item.column for item in taken} & _OF_A_WIRE
    asked = [
        item
        for item in voltages
        if alone and item.how == "synonym"
        if key_of_header(_with_unit_as_last_words(split_header(item.header)[0])[0]) in _ANY_VOLTAGE
    ]
    undecided = tuple(
        UndecidedHeader(
            item.header,
            item.index,
            item.column,
            f"{path}: column '{item.header}' may be the wire's voltage or a sensor's; nothing else here is of a wire: "
            f"map it, wire_voltage_v={item.header}:{item.unit}, or ignore it",
        )
        for item in asked
    )
    return [item for item in taken if item not in asked], undecided


def _name_of(item: MatchedHeader, other: MatchedHeader) -> str:
    """Return how a mapping names a header: by its number if another has the same name."""
    return item.header if item.header != other.header else f"#{item.index + 1}:{item.unit}"


def _taken_once(taken: Sequence[MatchedHeader], path: str) -> tuple[list[MatchedHeader], tuple[UndecidedHeader, ...]]:
    """Return those whose column no other header is, and the others as undecided."""
    by_column: dict[str, list[MatchedHeader]] = {}
    for item in taken:
        by_column.setdefault(item.column, []).append(item)
    undecided: list[UndecidedHeader] = []
    for column, items in by_column.items():
        for item in items[1:]:
            problem = (
                f"{path}: columns '{items[0].header}' and '{item.header}' are both taken as {column}: "
                f"map the one you mean: {column}={_name_of(item, items[0])}"
            )
            undecided.append(UndecidedHeader(item.header, item.index, column, problem))
    return [items[0] for items in by_column.values()], tuple(undecided)
