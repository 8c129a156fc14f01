"""What would make a file readable: the mapping that a refusal proposes, by units, words in headers and numbers."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.files import (
    HeaderMatch,
    HeaderWithoutUnit,
    IgnoredHeader,
    ImportMapping,
    ImportPlan,
    SourceColumn,
    SourceTable,
    UndecidedHeader,
    head_of,
    name_and_unit,
    split_header,
)
from musclewire.signals import COLUMNS, measures, needs_no_clock, scale_between

# What a column with an unknown name is offered as, by its unit; the likeliest first.
OFFERED = (
    *("time_s", "wire_voltage_v", "shunt_voltage_v", "wire_current_a", "wire_resistance_ohm"),
    *("displacement_m", "force_n", "wire_temperature_k", "stress_pa"),
)
# Parts of names without a unit that say what was measured.
_WORDS = (
    ("displacement_m", re.compile(r"pos|stroke|disp|laser|lvdt|weg|hub|contraction", re.IGNORECASE)),
    ("force_n", re.compile(r"force|load|kraft", re.IGNORECASE)),
    ("wire_resistance_ohm", re.compile(r"resist|ohm|(?:^|[\W_])r(?:[\W_]|$)", re.IGNORECASE)),
    ("wire_voltage_v", re.compile(r"volt|spannung|(?:^|[\W_])[vu](?:[\W_]|$)", re.IGNORECASE)),
    ("wire_current_a", re.compile(r"curr|strom|ampere|(?:^|[\W_])(?:amps?|i)(?:[\W_]|$)", re.IGNORECASE)),
    ("wire_temperature_k", re.compile(r"temp", re.IGNORECASE)),
)


# What a heated wire can have; readings outside are in another unit.
_WIRE_OHM = (0.1, 500.0)  # resistance [ohm]
_POWER_W = (5e-3, 500.0)  # largest power [W]
_UNITS_OF = {"wire_voltage_v": ("V", "mV"), "wire_current_a": ("A", "mA"), "wire_resistance_ohm": ("ohm",)}


def proposed_addition(plan: ImportPlan) -> ImportMapping | None:
    """Return what to add to the mapping against the plan's problem, None if nothing is known."""
    match, table = plan.match, plan.table
    offered = columns_offered(table, match)
    for item in match.undecided:
        twice = next((one for one in match.taken if one.column == item.column), None)
        if twice is not None:
            return ImportMapping({item.column: mapped_with_unit(table, twice.header, twice.index, twice.column)})
        if "or ignore it" in item.message:
            return None
        if item.column == "time_s":
            unit = None if plan.no_clock is None else plan.no_clock.offered
            return None if unit is None else offered.joined(ImportMapping({"time_s": f"{item.header}:{unit}"}))
        # What the file does not state a person has to know, unless it can be one thing only.
        judged = judged_units(table, match)
        return None if judged is None else offered.joined(judged)
    found = set(plan.names) | set(offered.columns)
    has_clock = "time_s" in found or needs_no_clock(found)
    return offered if found - {"time_s", "cycle"} and has_clock else None


def judged_units(table: SourceTable, match: HeaderMatch) -> ImportMapping | None:
    """Return units by which columns without any give a wire's resistance and power; None if there are several ways."""
    items: list[UndecidedHeader] = [item for item in match.undecided if isinstance(item, HeaderWithoutUnit)]
    if len(items) < len(match.undecided) or any(item.column not in _UNITS_OF for item in items):
        return None
    items += _by_words(table, match, {item.column for item in items} | {item.column for item in match.taken})
    stated = {item.column: [item.unit] for item in match.taken if item.column in _UNITS_OF}
    choices = stated | {item.column: list(_UNITS_OF[item.column]) for item in items}
    indices = {item.column: item.index for item in match.taken if item.column in choices}
    indices |= {item.column: item.index for item in items}
    values = {name: np.abs(np.asarray(head_of(table, index), dtype=np.float64)) for name, index in indices.items()}
    fitting = [
        units
        for units in (dict(zip(choices, each, strict=True)) for each in itertools.product(*choices.values()))
        if _is_a_wire({name: (scale_between(units[name], COLUMNS[name].unit) or 0.0) * values[name] for name in units})
    ]
    if len(fitting) != 1:
        return None
    return ImportMapping({item.column: f"{_named(table, item)}:{fitting[0][item.column]}" for item in items})


def _by_words(table: SourceTable, match: HeaderMatch, known: set[str]) -> list[UndecidedHeader]:
    """Return the headers without a unit that a word in them says to be one of these columns."""
    found: list[UndecidedHeader] = []
    for item, index in _places(table, unknown_names(match)):
        source, left = table.columns[index], _UNITS_OF.keys() - known - {one.column for one in found}
        names = [name for name, word in _WORDS if word.search(item.header)][:1]
        if names and names[0] in left and not source.is_text and _unit_of(source) is None:
            found.append(UndecidedHeader(item.header, index, names[0], ""))
    return found


def _is_a_wire(values: Mapping[str, FloatArray]) -> bool:
    """Return whether readings are those of a heated wire; of a voltage or a current alone nothing is known."""
    if "wire_resistance_ohm" in values:
        return _WIRE_OHM[0] <= float(np.nanmedian(values["wire_resistance_ohm"])) <= _WIRE_OHM[1]
    if not {"wire_voltage_v", "wire_current_a"} <= values.keys():
        return True
    volts, amperes = (float(np.nanquantile(values[name], 0.9)) for name in ("wire_voltage_v", "wire_current_a"))
    within = amperes > 0.0 and _WIRE_OHM[0] <= volts / amperes <= _WIRE_OHM[1]
    return within and _POWER_W[0] <= volts * amperes <= _POWER_W[1]


def _named(table: SourceTable, item: UndecidedHeader) -> str:
    headers = [one.header for one in table.columns]
    return item.header if headers.count(item.header) == 1 else f"#{item.index + 1}"


def unknown_names(match: HeaderMatch) -> list[IgnoredHeader]:
    """Return the headers that were ignored because their name is not known."""
    return [item for item in match.ignored if item.reason == "name not known"]


def mapped_with_unit(table: SourceTable, header: str, index: int, column: str) -> str:
    """Return a header as a mapping names it, with the likely unit if the file states none that measures the column."""
    headers = [one.header for one in table.columns]
    name = header if headers.count(header) == 1 and header.strip() else f"#{index + 1}"
    stated = table.columns[index].unit or split_header(header)[1]
    if (unit := _unit_of(table.columns[index])) and measures(unit, column):
        return name if name == header and stated else f"{name}:{unit}"
    return f"{name}:{COLUMNS[column].unit}"


def columns_offered(table: SourceTable, match: HeaderMatch) -> ImportMapping:
    """Return a mapping of unknown names by their units, and by words in them; empty if none says anything."""
    known = {one.column for one in match.taken} | {one.column for one in match.undecided}
    found: dict[str, str] = {}
    for item, index in _places(table, unknown_names(match)):
        source = table.columns[index]
        column = None if source.is_text or not _unit_of(source) else _offered_for(source, known | set(found))
        if column is not None:
            found[column] = mapped_with_unit(table, item.header, index, column)
    return ImportMapping(found)


def _unit_of(column: SourceColumn) -> str | None:
    """Return the unit that a column states, in whatever place, its name's last word included."""
    unit = name_and_unit(column)[1]
    last = re.split(r"[\s_]+", column.header)[-1]
    return last if unit is None and last != column.header and any(measures(last, name) for name in OFFERED) else unit


def _places(table: SourceTable, items: Sequence[IgnoredHeader]) -> list[tuple[IgnoredHeader, int]]:
    """Return ignored headers with the number of their column; of equal ones each its own."""
    left = list(enumerate(column.header for column in table.columns))
    found: list[tuple[IgnoredHeader, int]] = []
    for item in items:
        place = next(pair for pair in left if pair[1] == item.header)
        left.remove(place)
        found.append((item, place[0]))
    return found


def _offered_for(source: SourceColumn, known: set[str]) -> str | None:
    name, unit = split_header(source.header)[0], str(_unit_of(source))
    fitting = [offered for offered in OFFERED if offered != "time_s" and measures(unit, offered)]
    by_word = [called for called, word in _WORDS if called in fitting and word.search(name)]
    return next((one for one in (*by_word, *fitting) if one not in known), None)
