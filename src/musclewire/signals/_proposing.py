"""What would make a file readable: the mapping that a refusal proposes, by units, words in headers and numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from musclewire.signals._columns import COLUMNS
from musclewire.signals._headers import HeaderMatch, IgnoredHeader, split_header
from musclewire.signals._import_mapping import ImportMapping
from musclewire.signals._source_table import SourceTable, head_of
from musclewire.signals._units import measures

# What a column with an unknown name is offered as, by its unit; the likeliest first.
OFFERED = (
    *("time_s", "wire_voltage_v", "shunt_voltage_v", "drive_voltage_v", "wire_current_a", "wire_resistance_ohm"),
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
# Units in which people write numbers without saying so, each with the largest number that a bench can have in it.
_USUAL: dict[str, tuple[tuple[str, float], ...]] = {
    "time_s": (("s", np.inf),),
    "wire_current_a": (("A", 20.0), ("mA", np.inf)),
    "displacement_m": (("mm", 500.0), ("um", np.inf)),
    "wire_temperature_k": (("degC", np.inf),),
    "reference_strain": (("", 1.0), ("%", np.inf)),
}
_VOLTAGE = (("V", 100.0), ("mV", np.inf))


def likely_unit(column: str, largest: float) -> str:
    """Return the unit in which numbers up to ``largest`` are likely to be, if nothing states it."""
    usual = _VOLTAGE if COLUMNS[column].unit == "V" else _USUAL.get(column, ((COLUMNS[column].unit, np.inf),))
    return next(unit for unit, limit in usual if largest <= limit)


def unknown_names(match: HeaderMatch) -> list[IgnoredHeader]:
    """Return the headers that were ignored because their name is not known."""
    return [item for item in match.ignored if item.reason == "name not known"]


def mapped_with_unit(table: SourceTable, header: str, index: int, column: str) -> str:
    """Return a header as a mapping names it, with the likely unit if the file states none that measures the column."""
    headers = [one.header for one in table.columns]
    name = header if headers.count(header) == 1 and header.strip() else f"#{index + 1}"
    stated = table.columns[index].unit
    unit = split_header(header)[1] if stated is None else stated
    if unit and measures(unit, column):
        return name if name == header else f"{name}:{unit}"
    own = likely_unit(column, _largest(table, index))
    # The mapping must state a unit that the header does not; without one there is nothing to state.
    return f"{name}:{own}" if own else name


def _moves(table: SourceTable, index: int) -> bool:
    cells = head_of(table, index)
    if isinstance(cells, list):
        return False
    finite = cells[np.isfinite(cells)]
    return bool(finite.size) and float(np.ptp(finite)) > 0.0


def _largest(table: SourceTable, index: int) -> float:
    cells = head_of(table, index)
    if isinstance(cells, list):
        return 0.0
    finite = cells[np.isfinite(cells)]
    return float(np.abs(finite).max()) if finite.size else 0.0


def columns_offered(table: SourceTable, match: HeaderMatch) -> ImportMapping:
    """Return a mapping of unknown names by their units, else by words in them; empty if none says anything."""
    known = {one.column for one in match.taken} | {one.column for one in match.undecided}
    unknown = unknown_names(match)
    places = _places(table, unknown)
    found: dict[str, str] = {}
    for item, index in places:
        # Numbers that never change measure nothing, whatever their name may say.
        if table.columns[index].is_text or not _moves(table, index):
            continue
        column = _offered_for(table, item.header, index, known | set(found))
        if column is not None:
            found[column] = mapped_with_unit(table, item.header, index, column)
    return ImportMapping(found)


def _places(table: SourceTable, items: Sequence[IgnoredHeader]) -> list[tuple[IgnoredHeader, int]]:
    """Return ignored headers with the number of their column; of equal ones each its own."""
    left = list(enumerate(column.header for column in table.columns))
    found: list[tuple[IgnoredHeader, int]] = []
    for item in items:
        place = next(pair for pair in left if pair[1] == item.header)
        left.remove(place)
        found.append((item, place[0]))
    return found


def _offered_for(table: SourceTable, header: str, index: int, known: set[str]) -> str | None:
    name, unit = split_header(header)
    unit = unit if table.columns[index].unit is None else table.columns[index].unit
    if unit:
        fitting = [offered for offered in OFFERED if measures(unit, offered)]
        by_word = [called for called, word in _WORDS if called in fitting and word.search(name)]
        return next((one for one in (*by_word, *fitting) if one not in known), None)
    return next((name_of for name_of, word in _WORDS if word.search(name) and name_of not in known), None)


def repeated_stamps(time_s: Sequence[float]) -> tuple[int, float] | None:
    """Return how many rows share one time stamp, and the time between rows [s]; None if it is not the same number."""
    times = np.asarray(time_s, dtype=np.float64)
    starts = np.flatnonzero(np.diff(times, prepend=times[0] - 1.0) != 0.0)
    sizes = np.diff(starts)
    if sizes.size < 2 or sizes[0] < 2 or (sizes[:-1] != sizes[0]).any() or sizes[-1] > sizes[0]:
        return None
    steps = np.diff(times[starts])
    if (steps <= 0.0).any() or float(np.ptp(steps)) > 0.05 * float(steps.mean()):
        return None
    return int(sizes[0]), float(steps.mean()) / int(sizes[0])
