"""Long tables: a row for each number, with the name of what was measured, its time and its value; one column a name."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.signals._columns import key_of_header
from musclewire.signals._source_table import Cells, SourceColumn, SourceTable, TableInMemory
from musclewire.signals._units import is_unit

_NAMES = frozenset({"source", "src", "name", "channel", "sensor", "variable", "signal", "quantity", "series", "key"})
_VALUES = frozenset({"value", "reading", "val", "wert", "measurement"})
_UNITS = frozenset({"unit", "units", "einheit"})
_MAX_SERIES = 64


def spread_series(table: SourceTable) -> SourceTable:
    """Return a long table with a column for each name, at the times of the series that was measured least often.

    Series of other times come to these by straight lines. Any other table is returned as it is.
    """
    keys = [key_of_header(column.header) for column in table.columns]
    names, values = ([i for i, key in enumerate(keys) if key in known] for known in (_NAMES, _VALUES))
    units = [i for i, key in enumerate(keys) if key in _UNITS and table.columns[i].is_text]
    clocks = [i for i, column in enumerate(table.columns) if i not in {*names, *values, *units} and not column.is_text]
    if len(names) != 1 or len(values) != 1 or not clocks or not table.columns[names[0]].is_text:
        return table
    read = _read(table, [names[0], clocks[0], values[0], *units[:1]])
    if read is None:
        return table
    return _spread(table, table.columns[clocks[0]], *read)


def _read(table: SourceTable, indices: Sequence[int]) -> tuple[list[str], FloatArray, FloatArray, list[str]] | None:
    """Return names, times, values and units of all rows, None if there are none."""
    blocks = [block.values for block in table.blocks(indices)]
    if not blocks:
        return None

    def texts(place: int) -> list[str]:
        return [str(cell).strip() for cell in itertools.chain.from_iterable(block[place] for block in blocks)]

    def numbers(place: int) -> FloatArray:
        return np.concatenate([np.asarray(block[place], dtype=np.float64) for block in blocks])

    return texts(0), numbers(1), numbers(2), texts(3) if len(indices) > 3 else []


def _spread(
    table: SourceTable, clock: SourceColumn, names: list[str], times: FloatArray, values: FloatArray, units: list[str]
) -> SourceTable:
    series: dict[str, list[int]] = {}
    for row, name in enumerate(names):
        series.setdefault(name, []).append(row)
    usable = np.isfinite(times) & np.isfinite(values)
    found = {name: np.array([row for row in rows if usable[row]], dtype=np.intp) for name, rows in series.items()}
    found = {name: rows for name, rows in found.items() if rows.size > 1}
    if not found or len(series) > _MAX_SERIES:
        return table
    slowest = min(found, key=lambda name: found[name].size)
    common = times[found[slowest]]
    cells: list[Cells] = [common]
    columns = [SourceColumn(clock.header, clock.unit)]
    notes = [*table.notes, f"{len(found)} series below each other: " + ", ".join(_described(found, times))]
    # What all series have in common: beyond it nothing is known of one of them.
    ordered = {name: rows[np.argsort(times[rows], kind="stable")] for name, rows in found.items()}
    begin, end = (f(times[rows[i]] for rows in ordered.values()) for f, i in ((max, 0), (min, -1)))
    inside = (common >= begin) & (common <= end)
    for name, rows in ordered.items():
        same = rows.size == common.size and bool((times[rows] == common).all())
        cells.append(values[rows] if same else np.interp(common, times[rows], values[rows]))
        columns.append(SourceColumn(name, units[rows[0]] if units and is_unit(units[rows[0]]) else None))
        if not same:
            notes.append(f"'{name}' by straight lines at the times of '{slowest}'")
    kept = tuple(np.asarray(one)[inside] for one in cells)
    layout = f"{table.layout}, a row for each number"
    return TableInMemory(
        table.path, layout, tuple(columns), kept, table.metadata, {}, tuple(notes), "row of '" + slowest + "'"
    )


def _described(found: dict[str, np.ndarray[tuple[int], np.dtype[np.intp]]], times: FloatArray) -> list[str]:
    return [f"'{name}' ({rows.size} rows, {times[rows[0]]:g} to {times[rows[-1]]:g})" for name, rows in found.items()]
