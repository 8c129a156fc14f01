"""Long tables: a row for each number, with the name of what was measured, its time and its value; one column a name."""

from __future__ import annotations

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.files._clocks import Clock, ClockReader, FirstRows, NoClock, find_clock
from musclewire.files._headers import name_and_unit
from musclewire.files._source_table import Cells, SourceColumn, SourceTable, TableInMemory, heads_of
from musclewire.signals import is_unit, key_of_header, scale_between

_NAMES = frozenset({"source", "src", "name", "channel", "sensor", "variable", "signal", "quantity", "series", "key"})
_VALUES = frozenset({"value", "reading", "val", "wert", "measurement"})
_UNITS = frozenset({"unit", "units", "einheit"})
_MAX_SERIES = 64  # names in a table: no bench has as many channels, and more are texts of another kind


def spread_series(table: SourceTable) -> SourceTable:
    """Return a long table with a column for each name, any other as it is.

    Rows are those of the series that was measured least often; the others come to its times by straight lines.
    """
    keys = [key_of_header(column.header) for column in table.columns]
    names, values = ([i for i, key in enumerate(keys) if key in known] for known in (_NAMES, _VALUES))
    units = [i for i, key in enumerate(keys) if key in _UNITS and table.columns[i].is_text]
    if len(names) != 1 or len(values) != 1 or table.columns[values[0]].is_text:
        return table
    stated = [name_and_unit(column) for column in table.columns]
    rows = FirstRows(table.path, table.columns, heads_of(table), stated)
    clock = find_clock(rows, None, frozenset({*names, *values, *units}))
    if clock is None:
        return table
    header = table.columns[clock.index].header if isinstance(clock, NoClock) else clock.header
    found = [*names, *values, *units[:1]]
    blocks = [block for block in table.blocks([*found, *_columns_of(clock)]) if not block.is_end]
    reader = None if isinstance(clock, NoClock) else ClockReader(clock, table.path)
    times = [
        np.asarray(block.values[-1], dtype=np.float64)
        if reader is None
        else reader.seconds(block.values[len(found) :], block.place)
        for block in blocks
    ]

    def texts(place: int) -> list[str]:
        return [cell if isinstance(cell, str) else f"{cell:g}" for block in blocks for cell in block.values[place]]

    numbers = np.concatenate([np.asarray(block.values[1], dtype=np.float64) for block in blocks])
    column = SourceColumn(header, None if reader is None else "s")
    of_units = [unit.strip() for unit in texts(2)] if units else []
    stated_unit = table.columns[values[0]].unit
    of_units = [stated_unit] * numbers.size if stated_unit and not of_units else of_units
    return _spread(table, column, texts(0), np.concatenate(times), numbers, of_units)


def _columns_of(clock: Clock | NoClock) -> tuple[int, ...]:
    return (clock.index,) if isinstance(clock, NoClock) else clock.all_indices


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
        unit = units[rows[0]] if units and is_unit(units[rows[0]]) else None
        if unit is not None:
            scales = [scale_between(units[row], unit) or np.nan for row in rows]
            if not np.isfinite(scales).all():
                raise RecordingError(
                    f"{table.path}: '{name}' is in {unit} and in another unit that measures another thing"
                )
            values[rows] *= scales
        columns.append(SourceColumn(name, unit))
        same = rows.size == common.size and bool((times[rows] == common).all())
        cells.append(values[rows] if same else np.interp(common, times[rows], values[rows]))
        if not same:
            notes.append(f"'{name}' by straight lines at the times of '{slowest}'")
    kept = tuple(np.asarray(one)[inside] for one in cells)
    layout = f"{table.layout}, a row for each number"
    return TableInMemory(
        table.path, layout, tuple(columns), kept, table.metadata, {}, tuple(notes), "row of '" + slowest + "'"
    )


def _described(found: dict[str, np.ndarray[tuple[int], np.dtype[np.intp]]], times: FloatArray) -> list[str]:
    return [f"'{name}' ({rows.size} rows, {times[rows[0]]:g} to {times[rows[-1]]:g})" for name, rows in found.items()]
