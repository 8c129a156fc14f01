"""MATLAB files of version 7.3, which are HDF5 with MATLAB's classes as attributes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.lab_files._file_table import FileTable, damage_reported, try_columns
from musclewire.extras.lab_files._hdf5_layout import check_readable, decoded, opened
from musclewire.extras.lab_files._hdf5_trial import check_by_trial
from musclewire.extras.lab_files._matlab_variables import (
    MatlabArray,
    UnusableVariable,
    Variable,
    parts_of_variables,
    table_of_variables,
)

__all__ = ["read_matlab73_table"]

_NUMERIC = frozenset({
    "double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "logical",
})  # fmt: skip
MAX_TEXT_LENGTH = 1_000_000
MAX_STRUCTS = 1000
MAX_DEPTH = 8


def read_matlab73_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of a MATLAB 7.3 file, or of one struct in it; numbers are read in ranges of rows.

    Raises RecordingError for damage, data outside the file, and classes that only MATLAB can read.
    """
    check_by_trial(path, __name__)
    with opened(path, "a MATLAB 7.3 file") as file, damage_reported(path, "a MATLAB 7.3 file"):
        return table_of_variables(_members(file, path, 0), "7.3", path, group)


def try_to_read(path: Path) -> None:
    """Read names, classes and the first block of every column, as a trial. Raises RecordingError as reading does."""
    with opened(path, "a MATLAB 7.3 file") as file, damage_reported(path, "a MATLAB 7.3 file"):
        for part in parts_of_variables(_members(file, path, 0)):
            try_columns(part)


def _members(group: Any, path: Path, depth: int) -> Mapping[str, Variable]:
    """Return the variables of a file or the fields of a struct; "#refs#" and the like are MATLAB's own."""
    import h5py

    found: dict[str, Variable] = {}
    for name in group:
        # A link may lead to another file; only what lies in this one is looked at.
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        item = group[name]
        if isinstance(item, h5py.Dataset):
            found[name] = _variable(item, path)
        elif isinstance(item, h5py.Group) and depth < MAX_DEPTH:
            found[name] = _struct(item, path, depth)
    return found


def _struct(group: Any, path: Path, depth: int) -> Variable:
    """Return a struct, or the list of an array of structs, in which each field is a data set of references."""
    import h5py

    fields = _members(group, path, depth + 1)
    references = {
        name: group[name]
        for name in group
        if isinstance(group.get(name, getlink=True), h5py.HardLink)
        and isinstance(group[name], h5py.Dataset)
        and "MATLAB_class" not in group[name].attrs
        and h5py.check_ref_dtype(group[name].dtype) is h5py.Reference
    }
    sizes = {dataset.size for dataset in references.values()}
    if not references or len(sizes) != 1 or not 0 < max(sizes) <= MAX_STRUCTS:
        return fields
    columns = {
        name: [_referred(group.file, ref, path) for ref in dataset[()].reshape(-1)]
        for name, dataset in (references.items())
    }
    return [{name: values[index] for name, values in columns.items()} for index in range(max(sizes))]


def _referred(file: Any, reference: Any, path: Path) -> Variable:
    import h5py

    item = file[reference] if reference else None
    return (
        _variable(item, path) if isinstance(item, h5py.Dataset) else UnusableVariable("struct in an array of structs")
    )


def _variable(dataset: Any, path: Path) -> Variable:
    matlab_class = decoded(dataset.attrs.get("MATLAB_class")) or ""
    if "MATLAB_empty" in dataset.attrs:
        return ""
    if matlab_class == "char" and dataset.dtype.kind == "u" and dataset.size <= MAX_TEXT_LENGTH:
        check_readable(dataset, path)
        # One row of text; UTF-16 code units, as MATLAB keeps them.
        return np.asarray(dataset[()], dtype="<u2").tobytes().decode("utf-16-le", errors="replace")
    if matlab_class not in _NUMERIC or dataset.dtype.kind not in "biuf" or len(dataset.shape) > 2:
        return UnusableVariable(matlab_class or "data set without MATLAB's class")
    return _numbers(dataset, path)


def _numbers(dataset: Any, path: Path) -> MatlabArray:
    """Return an array as MATLAB sees it: HDF5 keeps its dimensions in the opposite order."""
    name, shape = dataset.name, (*dataset.shape, 1, 1)[:2] if dataset.ndim < 2 else dataset.shape
    width, rows = shape
    row_vector = rows == 1 and width > 1

    def read(column: int, start: int, stop: int) -> FloatArray:
        with opened(path, "a MATLAB 7.3 file") as file:
            item = file[name]
            check_readable(item, path)
            if item.ndim < 2:
                values = item[start:stop] if item.ndim else item[()]
            else:
                values = item[start:stop, 0] if row_vector else item[column, start:stop]
            return np.asarray(values, dtype=np.float64).reshape(-1)

    if dataset.ndim < 2 or row_vector:
        return MatlabArray(dataset.size, 1, read)
    return MatlabArray(rows, width, read)
