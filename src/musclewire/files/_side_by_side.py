"""Two branches next to each other in a table, heating in some columns and cooling in others, one after the other."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.files._headers import split_header
from musclewire.files._source_table import SourceColumn, SourceTable, TableInMemory
from musclewire.signals import columns_called

_BRANCHES = (
    ("heating", re.compile(r"heating|heat-?up|warming|aufheizen|erwärmen|(?<![^\W_])heat(?![^\W_])", re.IGNORECASE)),
    ("cooling", re.compile(r"cooling|cool-?down|abkühlen|(?<![^\W_])cool(?![^\W_])", re.IGNORECASE)),
)
# Each branch has its own columns of the heating and what follows; a printed loop has only one of strain.
_MIN_COLUMNS = 2
# What rises in heating and falls in cooling, the surest first.
_DRIVING = ("wire_temperature_k", "wire_current_a", "drive_voltage_v", "wire_voltage_v")


def stacked_branches(table: SourceTable) -> SourceTable:
    """Return a table whose columns are two branches with the rows of heating first, those of cooling after them.

    A temperature, current or voltage of each orders its rows. Any other table is returned as it is.
    """
    branches = [_columns_of(pattern, table.columns) for _, pattern in _BRANCHES]
    names = [name for name in branches[0] if name in branches[1]]
    driving_names = [name for driving in _DRIVING for name in names if _means(name, driving)]
    if len(names) < _MIN_COLUMNS or not driving_names or len(branches[0]) != len(branches[1]):
        return table
    indices = [branch[name] for branch in branches for name in names]
    values = _all_numbers(table, indices)
    if values is None:
        return table
    return _stacked(table, names, driving_names[0], [values[: len(names)], values[len(names) :]], branches[0])


def _columns_of(pattern: re.Pattern[str], columns: Sequence[SourceColumn]) -> dict[str, int]:
    """Return the columns of a branch by their header without the branch's name; of a unit the letters' case counts."""
    found: dict[str, int] = {}
    for index, column in enumerate(columns):
        if pattern.search(column.header) and not column.is_text:
            name, unit = split_header(" ".join(pattern.sub(" ", column.header).replace("_", " ").split()))
            found[f"{name.lower()} [{unit}]" if unit else name.lower()] = index
    return found


def _means(header: str, driving: str) -> bool:
    return any(column.name == driving for column in columns_called(split_header(header)[0]))


def _all_numbers(table: SourceTable, indices: Sequence[int]) -> list[FloatArray] | None:
    blocks = [block.values for block in table.blocks(indices) if not block.is_end]
    if not blocks:
        return None
    columns = zip(*blocks, strict=True)
    return [np.concatenate([np.asarray(cells, dtype=np.float64) for cells in parts]) for parts in columns]


def _stacked(
    table: SourceTable,
    names: Sequence[str],
    drive: str,
    branches: Sequence[Sequence[FloatArray]],
    where: dict[str, int],
) -> TableInMemory:
    notes = list(table.notes)
    ordered: list[list[FloatArray]] = []
    for (word, _), branch, direction in zip(_BRANCHES, branches, (1.0, -1.0), strict=True):
        filled = ~np.all(np.isnan(branch), axis=0)
        rows = [values[filled] for values in branch]
        driven = rows[names.index(drive)]
        turned = driven.size > 1 and direction * (driven[-1] - driven[0]) < 0.0
        ordered.append([values[::-1] for values in rows] if turned else rows)
        notes.append(f"{driven.size} rows of {word}{', from the last to the first' if turned else ''}")
    columns = tuple(SourceColumn(name, table.columns[where[name]].unit) for name in names)
    values = tuple(np.concatenate(parts) for parts in zip(*ordered, strict=True))
    layout = f"{table.layout}, heating and cooling next to each other"
    return TableInMemory(table.path, layout, columns, values, table.metadata, {}, tuple(notes), "stacked row")
