"""What a MATLAB file holds, whatever its version, and the tables in it: vectors of equal length, matrices, structs."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import (
    FileColumn,
    FilePart,
    FileTable,
    chosen_part,
    file_table,
    metadata_of,
    one_line,
)

__all__ = [
    "METADATA_NAME",
    "MatlabArray",
    "Struct",
    "UnusableVariable",
    "Variable",
    "parts_of_variables",
    "table_of_variables",
]

# Our own .mat files keep the metadata, which MATLAB's names cannot all spell, as JSON in this variable.
METADATA_NAME = "musclewire_metadata"

MAX_COLUMNS = 10_000
MAX_DEPTH = 8
_UNITS = frozenset({"unit", "units"})


@dataclass(frozen=True)
class MatlabArray:
    """A real array of two dimensions as MATLAB sees it; ``read(column, start, stop)`` returns rows of a column.

    A row vector is kept as a column.
    """

    rows: int
    width: int
    read: Callable[[int, int, int], FloatArray]


@dataclass(frozen=True)
class UnusableVariable:
    """A variable that holds no table, such as a cell array, and what it is called in MATLAB."""

    matlab_class: str


Variable = MatlabArray | str | UnusableVariable | Mapping[str, "Variable"] | list["Variable"]
Struct = Mapping[str, "Variable"]

_CURES = {
    "cell": "turn it into columns in MATLAB (cell2mat) and save these",
    "table": "save its columns: S = table2struct(T, 'ToScalar', true); save('f.mat', '-struct', 'S')",
    "timetable": "save its columns: S = table2struct(timetable2table(T), 'ToScalar', true), with seconds(S.Time)",
    "function_handle": "it holds no numbers; save the vectors themselves",
}
_OBJECT_CURE = (
    "only MATLAB can read it; save columns: S = table2struct(timetable2table(T), 'ToScalar', true), times by seconds()"
)


def table_of_variables(variables: Struct, version: str, path: Path, group: str | None) -> FileTable:
    """Return the table of the variables of a MATLAB file, or of the struct ``group``; None takes the only one.

    Vectors of equal length are columns, and so are those of a matrix; scalars and texts are metadata; a struct
    "units" states the unit of each variable. Raises RecordingError that names MATLAB's cure for other classes.
    """
    parts = parts_of_variables(variables)
    unusable = _unusable(variables)
    if unusable and not any(part.row_count > 1 for part in parts):
        name, what = unusable
        cure = _CURES.get(what, _OBJECT_CURE)
        raise RecordingError(f"{path}: variable '{one_line(name)}' is a {one_line(what)}: {cure}")
    part = chosen_part(parts, group, path)
    # What is next to the structs holds for each of them.
    metadata = {**_metadata(variables), **part.metadata, **_own_metadata(variables, path)}
    layout = f"MATLAB {version}" + (f", {one_line(part.name)}" if part.name != _ROOT else "")
    return file_table(path, layout, replace(part, metadata=metadata))


_ROOT = "variables"


def parts_of_variables(variables: Struct) -> list[FilePart]:
    """Return all tables in the variables of a file."""
    return list(_parts("", variables, 0))


def _parts(name: str, struct: Struct, depth: int) -> Iterator[FilePart]:
    if {"time", "signals"} <= set(struct) and (simulink := _structure_with_time(name, struct)):
        yield simulink
        return
    units = next((value for key, value in struct.items() if key.lower() in _UNITS and isinstance(value, Mapping)), {})
    vectors: dict[int, list[FileColumn]] = {}
    for key, value in struct.items():
        if isinstance(value, MatlabArray) and value.rows > 1:
            columns = _columns(key, value, units)
            if value.width == 1:
                vectors.setdefault(value.rows, []).extend(columns)
            else:
                yield FilePart(f"{name}.{key}".lstrip("."), columns, value.rows, _metadata(struct))
    for rows, equal in vectors.items():
        called = name or _ROOT
        yield FilePart(called if len(vectors) == 1 else f"{called}, {rows} rows", tuple(equal), rows, _metadata(struct))
    yield from _inner_parts(name, struct, depth)


def _inner_parts(name: str, struct: Struct, depth: int) -> Iterator[FilePart]:
    """Yield the tables of structs within a struct, and of each element of an array of structs."""
    for key, value in struct.items():
        called = f"{name}.{key}".lstrip(".")
        if depth >= MAX_DEPTH or key.lower() in _UNITS:
            continue
        if isinstance(value, Mapping):
            yield from _parts(called, value, depth + 1)
        elif isinstance(value, list):
            for number, item in enumerate(value, start=1):
                if isinstance(item, Mapping):
                    yield from _parts(f"{called}({number})", item, depth + 1)


def _columns(name: str, numbers: MatlabArray, units: Struct) -> tuple[FileColumn, ...]:
    unit = units.get(name)

    def column(index: int) -> FileColumn:
        called = name if numbers.width == 1 else f"{name} {index + 1}"
        return FileColumn(
            called, unit if isinstance(unit, str) else None, lambda start, stop: numbers.read(index, start, stop)
        )

    return tuple(column(index) for index in range(min(numbers.width, MAX_COLUMNS)))


def _structure_with_time(name: str, struct: Struct) -> FilePart | None:
    """Return what Simulink saves as "structure with time": ``time``, and ``signals`` with values and label each."""
    time, signals = struct["time"], struct["signals"]
    if not isinstance(time, MatlabArray) or isinstance(signals, (MatlabArray, str, UnusableVariable)):
        return None
    columns = [FileColumn("time", "s", lambda start, stop: time.read(0, start, stop))]
    for number, signal in enumerate(signals if isinstance(signals, list) else [signals], start=1):
        values = signal.get("values") if isinstance(signal, Mapping) else None
        if isinstance(signal, Mapping) and isinstance(values, MatlabArray) and values.rows == time.rows:
            label = signal.get("label")
            columns += _columns(label if isinstance(label, str) and label else f"signal {number}", values, {})
    return FilePart(name or _ROOT, tuple(columns), time.rows, {})


def _metadata(struct: Struct) -> dict[str, str | int | float | bool | None]:
    found: dict[str, object] = {}
    for key, value in struct.items():
        if isinstance(value, str) and key != METADATA_NAME:
            found[key] = value
        elif isinstance(value, MatlabArray) and (value.rows, value.width) == (1, 1):
            found[key] = float(value.read(0, 0, 1)[0])
    return metadata_of(found)


def _own_metadata(variables: Struct, path: Path) -> dict[str, str | int | float | bool | None]:
    text = variables.get(METADATA_NAME)
    if not isinstance(text, str):
        return {}
    try:
        return {str(key): value for key, value in json.loads(text).items()}
    except (ValueError, AttributeError, RecursionError):
        raise RecordingError(f"{path}: its variable {METADATA_NAME} is damaged; use another copy") from None


def _unusable(struct: Struct, depth: int = 0) -> tuple[str, str] | None:
    """Return name and class of the first variable that only MATLAB can read, of structs within a struct, too."""
    for key, value in struct.items():
        if isinstance(value, UnusableVariable):
            return key, value.matlab_class
        if isinstance(value, Mapping) and depth < MAX_DEPTH and (inner := _unusable(value, depth + 1)):
            return f"{key}.{inner[0]}", inner[1]
    return None
