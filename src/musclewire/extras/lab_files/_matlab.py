"""MATLAB files: versions 4 and 5 read by SciPy, 7.3 by h5py, and the tables in their variables.

Vectors of equal length are a table, and so are the columns of a matrix; so is each struct that holds such.
"""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError
from musclewire.extras.lab_files._file_table import (
    FileColumn,
    FilePart,
    FileTable,
    check_limits,
    chosen_part,
    damage_reported,
    file_table,
    metadata_of,
    one_line,
)
from musclewire.extras.lab_files._hdf5_datasets import checked, decoded, numbers_of, opened
from musclewire.signals import COLUMNS, MetadataValue

# Our own .mat files keep the metadata, which MATLAB's names cannot all spell, as JSON in this variable.
METADATA_NAME = "musclewire_metadata"

MAX_COLUMNS = 10_000
MAX_DEPTH = 8
MAX_TEXT_LENGTH = 1_000_000
_UNITS = frozenset({"unit", "units"})
_ROOT = "variables"
_NUMERIC = frozenset({
    "double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "logical",
})  # fmt: skip
_CURES = {
    "cell": "turn it into columns in MATLAB (cell2mat) and save these",
    "table": "save its columns: S = table2struct(T, 'ToScalar', true); save('f.mat', '-struct', 'S')",
    "timetable": "save its columns: S = table2struct(timetable2table(T), 'ToScalar', true), with seconds(S.Time)",
    "function": "it holds no numbers; save the vectors themselves",
    "function_handle": "it holds no numbers; save the vectors themselves",
}
_OBJECT_CURE = (
    "only MATLAB can read it; save columns: S = table2struct(timetable2table(T), 'ToScalar', true), times by seconds()"
)


@dataclass(frozen=True)
class _MatlabArray:
    """A real array: its rows, and what reads some of them of each column. A row vector is kept as a column."""

    rows: int
    columns: tuple[Callable[[int, int], FloatArray], ...]


@dataclass(frozen=True)
class _UnusableVariable:
    """A variable that holds no table, such as a cell array, and what it is called in MATLAB."""

    matlab_class: str


# A variable is an array, a text, a struct (a mapping), an array of structs (a list), or nothing that is read.
_Struct = Mapping[str, Any]


def read_matlab_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of the variables of a MATLAB file, or of the struct ``group``; None takes the only one.

    Vectors of equal length are columns, and so are those of a matrix; scalars and texts are metadata; a struct
    "units" states the unit of each variable. Raises RecordingError that names MATLAB's cure for other classes.
    """
    with path.open("rb") as file:
        is_hdf5 = file.read(10).startswith((b"MATLAB 7.3", b"\x89HDF"))
    with damage_reported(path, "a MATLAB 7.3 file" if is_hdf5 else "a MATLAB file"):
        variables, version = _variables_of_7_3(path) if is_hdf5 else _variables_of_5(path)
        parts = list(_parts("", variables, 0))
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


def _variables_of_5(path: Path) -> tuple[_Struct, str]:
    """Return the variables of version 5 or 4: classes of numbers, text and structs, and the names of others."""
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import matfile_version

    with warnings.catch_warnings():
        # A duplicate or unreadable variable is reported below, as missing.
        warnings.simplefilter("ignore")
        listed = whosmat(str(path), appendmat=False)
        check_limits(path, cells=sum(math.prod(shape) for _, shape, _ in listed), at_once=True)
        wanted = [name for name, _, kind in listed if kind in _NUMERIC or kind in {"char", "struct"}]
        loaded = loadmat(str(path), variable_names=wanted, appendmat=False, simplify_cells=True) if wanted else {}
    found = {name: _from_scipy(loaded[name]) for name in wanted if name in loaded}
    others = {name: _UnusableVariable("object" if kind == "opaque" else kind) for name, _, kind in listed}
    return {**others, **found}, "4" if matfile_version(str(path))[0] == 0 else "5"


def _from_scipy(value: Any) -> Any:
    if isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return {name: _from_scipy(item) for name, item in value.items() if not name.startswith("__")}
    if isinstance(value, (list, np.ndarray)) and len(np.shape(value)) == 1 and all(isinstance(x, dict) for x in value):
        return [_from_scipy(item) for item in value]
    if isinstance(value, (np.ndarray, np.generic, int, float)) and np.ndim(value) < 3:
        table = np.asarray(value)
        if table.dtype.kind == "U":
            return ""
        if table.dtype.kind in "biuf":
            table = table.reshape(-1, 1) if table.ndim < 2 else table[:, :MAX_COLUMNS]
            return _MatlabArray(table.shape[0], tuple(_in_memory(table[:, index]) for index in range(table.shape[1])))
    return _UnusableVariable("cell" if isinstance(value, np.ndarray) and value.dtype.kind == "O" else "complex array")


def _in_memory(values: Any) -> Callable[[int, int], FloatArray]:
    return lambda start, stop: np.asarray(values[start:stop], dtype=np.float64)


def _variables_of_7_3(path: Path) -> tuple[_Struct, str]:
    with opened(path, "a MATLAB 7.3 file") as file:
        return _members(file, path, 0), "7.3"


def _members(group: Any, path: Path, depth: int) -> Any:
    """Return the variables of a file, the fields of a struct, or a list of those of an array of structs."""
    import h5py

    # A link may lead to another file; only what lies in this one is looked at. "#refs#" and the like are MATLAB's own.
    names = [name for name in group if isinstance(group.get(name, getlink=True), h5py.HardLink) and name[0] != "#"]
    if depth > MAX_DEPTH:
        return {}
    found: dict[str, Any] = {}
    for name in names:
        item = group[name]
        if isinstance(item, h5py.Group):
            found[name] = _members(item, path, depth + 1)
        elif isinstance(item, h5py.Dataset):
            found[name] = _from_hdf5(item, path)
    # The fields of an array of structs are references, which MATLAB marks by no class.
    fields = {name: values for name, values in found.items() if isinstance(values, list)}
    lengths = {len(values) for values in fields.values()}
    if not fields or len(lengths) != 1 or depth == 0:
        return found
    return [{name: values[index] for name, values in fields.items()} for index in range(min(lengths))]


def _from_hdf5(dataset: Any, path: Path) -> Any:
    """Return a variable: HDF5 keeps its dimensions in the opposite order."""
    import h5py

    matlab_class = decoded(dataset.attrs.get("MATLAB_class")) or ""
    if "MATLAB_empty" in dataset.attrs:
        return ""
    if not matlab_class and h5py.check_ref_dtype(dataset.dtype) is h5py.Reference:
        referred = [dataset.file[reference] for reference in checked(dataset, path)[()].reshape(-1)]
        return [_from_hdf5(each, path) if isinstance(each, h5py.Dataset) else "" for each in referred]
    if matlab_class == "char" and dataset.dtype.kind == "u" and dataset.size <= MAX_TEXT_LENGTH:
        # One row of text; UTF-16 code units, as MATLAB keeps them.
        return np.asarray(checked(dataset, path)[()], dtype="<u2").tobytes().decode("utf-16-le", errors="replace")
    if matlab_class not in _NUMERIC or dataset.dtype.kind not in "biuf" or dataset.ndim not in {1, 2}:
        return _UnusableVariable(matlab_class or "data set without MATLAB's class")
    if dataset.ndim == 1:
        return _MatlabArray(dataset.size, (numbers_of(path, dataset),))
    width, rows = dataset.shape
    if rows == 1:
        return _MatlabArray(width, (numbers_of(path, dataset, None, 0),))
    return _MatlabArray(rows, tuple(numbers_of(path, dataset, each, None) for each in range(min(width, MAX_COLUMNS))))


def _parts(name: str, struct: _Struct, depth: int) -> Iterator[FilePart]:
    if {"time", "signals"} <= set(struct) and (simulink := _structure_with_time(name, struct)):
        yield simulink
        return
    units = next((value for key, value in struct.items() if key.lower() in _UNITS and isinstance(value, Mapping)), {})
    vectors: dict[int, list[FileColumn]] = {}
    for key, value in struct.items():
        if isinstance(value, _MatlabArray) and value.rows > 1:
            if len(value.columns) == 1:
                vectors.setdefault(value.rows, []).extend(_columns(key, value, units))
            else:
                yield FilePart(f"{name}.{key}".lstrip("."), _columns(key, value, units), value.rows, _metadata(struct))
    for rows, equal in vectors.items():
        called = name or _ROOT
        yield FilePart(called if len(vectors) == 1 else f"{called}, {rows} rows", tuple(equal), rows, _metadata(struct))
    for key, value in struct.items():
        called = f"{name}.{key}".lstrip(".")
        if depth >= MAX_DEPTH or key.lower() in _UNITS:
            continue
        if isinstance(value, Mapping):
            yield from _parts(called, value, depth + 1)
        for number, item in enumerate(value if isinstance(value, list) else (), start=1):
            if isinstance(item, Mapping):
                yield from _parts(f"{called}({number})", item, depth + 1)


def _columns(name: str, numbers: _MatlabArray, units: _Struct) -> tuple[FileColumn, ...]:
    unit = units.get(name)
    return tuple(
        FileColumn(
            name if len(numbers.columns) == 1 else f"{name} {index}", unit if isinstance(unit, str) else None, read
        )
        for index, read in enumerate(numbers.columns, start=1)
    )


def _structure_with_time(name: str, struct: _Struct) -> FilePart | None:
    """Return what Simulink saves as "structure with time": ``time``, and ``signals`` with values and label each."""
    time, signals = struct["time"], struct["signals"]
    if not isinstance(time, _MatlabArray) or not isinstance(signals, (list, Mapping)):
        return None
    columns = [FileColumn("time", "s", time.columns[0])]
    for number, signal in enumerate(signals if isinstance(signals, list) else [signals], start=1):
        values, label = signal.get("values"), signal.get("label")
        if isinstance(values, _MatlabArray) and values.rows == time.rows:
            columns += _columns(label if isinstance(label, str) and label else f"signal {number}", values, {})
    return FilePart(name or _ROOT, tuple(columns), time.rows, {})


def _metadata(struct: _Struct) -> dict[str, MetadataValue]:
    found: dict[str, object] = {}
    for key, value in struct.items():
        if isinstance(value, str) and key != METADATA_NAME:
            found[key] = value
        elif isinstance(value, _MatlabArray) and value.rows == len(value.columns) == 1:
            found[key] = float(value.columns[0](0, 1)[0])
    return metadata_of(found)


def _own_metadata(variables: _Struct, path: Path) -> dict[str, MetadataValue]:
    text = variables.get(METADATA_NAME)
    if not isinstance(text, str):
        return {}
    try:
        return {str(key): value for key, value in json.loads(text).items()}
    except (ValueError, AttributeError, RecursionError):
        raise RecordingError(f"{path}: its variable {METADATA_NAME} is damaged; use another copy") from None


def _unusable(struct: _Struct, depth: int = 0) -> tuple[str, str] | None:
    """Return name and class of the first variable that only MATLAB can read, of structs within a struct, too."""
    for key, value in struct.items():
        if isinstance(value, _UnusableVariable):
            return key, value.matlab_class
        if isinstance(value, Mapping) and depth < MAX_DEPTH and (inner := _unusable(value, depth + 1)):
            return f"{key}.{inner[0]}", inner[1]
    return None


Columns = Mapping[str, FloatArray]
Metadata = Mapping[str, MetadataValue]

MATLAB_VERSIONS = ("5", "7.3")

# An element of version 5 states its size in 32 bits, and MATLAB reads half of that.
MAX_COLUMN_BYTES = 2**31 - 1024
_HEADER_BYTES = 512
_TEXT = "MATLAB 7.3 MAT-file, written by musclewire HDF5 schema 1.00 ."


def fill_of_version(version: str | None) -> Callable[[Columns, Metadata, Path], None]:
    """Return what writes a version; None is 5, or 7.3 where that is needed. Raises CallerError for another one."""
    known = {None: fill_matlab, "5": fill_matlab_5, "7.3": fill_matlab_73}
    if version not in known:
        raise CallerError(f"MATLAB version '{version}' is not written; give {' or '.join(MATLAB_VERSIONS)}")
    return known[version]


def fill_matlab(columns: Columns, metadata: Metadata, path: Path) -> None:
    """Write version 5, which everything reads, or 7.3 if a column is too large for it."""
    largest = max((values.nbytes for values in columns.values()), default=0)
    fill = fill_matlab_5 if largest <= MAX_COLUMN_BYTES else fill_matlab_73
    fill(columns, metadata, path)


def fill_matlab_5(columns: Columns, metadata: Metadata, path: Path) -> None:
    """Write columns as column vectors with our names, ``units`` and ``metadata`` as structs of text and numbers."""
    from scipy.io import savemat

    largest = max((values.nbytes for values in columns.values()), default=0)
    if largest > MAX_COLUMN_BYTES:
        raise CallerError(f"{path}: a column of {largest} bytes does not fit into MATLAB 5; write version 7.3")
    variables: dict[str, Any] = {name: values[:, np.newaxis] for name, values in columns.items()}
    variables["units"] = _units(columns)
    variables["metadata"] = _fields(metadata) or np.zeros((0, 0))
    variables[METADATA_NAME] = json.dumps(dict(metadata))
    savemat(str(path), variables, appendmat=False, do_compression=True, long_field_names=True)


def fill_matlab_73(columns: Columns, metadata: Metadata, path: Path) -> None:
    """Write the same as version 7.3, compressed in chunks, without a limit of size."""
    import h5py

    with h5py.File(path, "w", userblock_size=_HEADER_BYTES, track_order=True) as file:
        for name, values in columns.items():
            _array(file, name, values[np.newaxis, :], chunks=(1, min(max(values.size, 1), 65_536)))
        _struct(file, "units", _units(columns))
        _struct(file, "metadata", _fields(metadata))
        _text(file, METADATA_NAME, json.dumps(dict(metadata)))
    with path.open("rb+") as raw:
        raw.write(_TEXT.encode().ljust(116) + b"\0" * 8 + b"\x00\x02IM")


def _units(columns: Mapping[str, FloatArray]) -> dict[str, str]:
    return {name: COLUMNS[name].unit or "1" for name in columns}


def _fields(metadata: Mapping[str, MetadataValue]) -> dict[str, Any]:
    """Return the metadata as fields of a struct: MATLAB's names have no point and at most 63 letters."""
    fields = {key.replace(".", "_")[:63]: value for key, value in metadata.items()}
    return {key: np.zeros((0, 0)) if value is None else value for key, value in fields.items()}


def _struct(file: Any, name: str, fields: Mapping[str, Any]) -> None:
    group = file.create_group(name)
    group.attrs["MATLAB_class"] = np.bytes_("struct")
    for key, value in fields.items():
        if isinstance(value, str):
            _text(group, key, value)
        else:
            _array(group, key, np.atleast_2d(np.asarray(value)))


def _text(group: Any, name: str, text: str) -> None:
    units = np.frombuffer(text.encode("utf-16-le", errors="replace"), dtype="<u2")
    _array(group, name, units[:, np.newaxis], matlab_class="char").attrs["MATLAB_int_decode"] = np.int32(2)


def _array(group: Any, name: str, values: Any, matlab_class: str | None = None, **how: Any) -> Any:
    """Write an array whose dimensions are already in HDF5's order; MATLAB marks an empty one by its sizes."""
    classes = {"bool": "logical", "float64": "double"}
    written = values.astype(np.uint8) if values.dtype == np.bool_ else values
    if not values.size:
        dataset = group.create_dataset(name, data=np.array([0, 0], dtype=np.uint64))
        dataset.attrs["MATLAB_empty"] = np.uint8(1)
    else:
        dataset = group.create_dataset(name, data=written, compression="gzip" if how else None, **how)
    dataset.attrs["MATLAB_class"] = np.bytes_(matlab_class or classes.get(str(values.dtype), str(values.dtype)))
    if values.dtype == np.bool_:
        dataset.attrs["MATLAB_int_decode"] = np.int32(1)
    return dataset
