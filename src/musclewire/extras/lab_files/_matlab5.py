"""MATLAB files of version 5 (and 4), read by SciPy after a check of their structure."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import FileTable, damage_reported
from musclewire.extras.lab_files._matlab5_check import MAX_BYTES, check_matlab5
from musclewire.extras.lab_files._matlab_variables import (
    MatlabArray,
    Struct,
    UnusableVariable,
    Variable,
    table_of_variables,
)

__all__ = ["read_matlab5_table"]

# Classes whose contents may hold numbers for us; of others only the name is read.
_READ = frozenset({
    "double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "logical", "char",
    "struct",
})  # fmt: skip


def read_matlab5_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of a MATLAB 4 or 5 file, or of one struct in it. Raises RecordingError as one line."""
    with damage_reported(path, "a MATLAB file"):
        variables, version = _variables(path)
        return table_of_variables(variables, version, path, group)


def _variables(path: Path) -> tuple[Struct, str]:
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import matfile_version

    name = str(path)
    with warnings.catch_warnings():
        # A duplicate or unreadable variable is reported below, as missing.
        warnings.simplefilter("ignore")
        major = matfile_version(name)[0]
        if major == 1:
            check_matlab5(path)
        elif path.stat().st_size > MAX_BYTES:
            raise RecordingError(f"{path}: is a MATLAB 4 file of more than 512 MiB; save it with '-v7.3'")
        kinds = {key: matlab_class for key, _, matlab_class in whosmat(name, appendmat=False)}
        wanted = [key for key, matlab_class in kinds.items() if matlab_class in _READ]
        loaded = loadmat(name, variable_names=wanted, appendmat=False) if wanted else {}
    variables = {key: _variable(loaded[key]) for key in wanted if key in loaded}
    others = {key: UnusableVariable(_name_of(kind)) for key, kind in kinds.items() if kind not in _READ}
    return {**variables, **others}, "4" if major == 0 else "5"


def _name_of(matlab_class: str) -> str:
    return {"opaque": "object (a table, timetable, datetime or string)", "function": "function_handle"}.get(
        matlab_class, matlab_class
    )


def _variable(value: Any) -> Variable:
    if not isinstance(value, np.ndarray):
        return UnusableVariable("sparse matrix" if hasattr(value, "tocsc") else type(value).__name__)
    if value.dtype.names:
        return _structs(value)
    if value.dtype.kind == "U":
        return str(value.reshape(-1)[0]) if value.size == 1 else ""
    if value.dtype.kind not in "biuf" or value.ndim > 2:
        return UnusableVariable("cell" if value.dtype.kind == "O" else "complex or 3-D array")
    return _numbers(value)


def _structs(value: Any) -> Variable:
    if type(value).__name__ in {"MatlabObject", "MatlabOpaque", "MatlabFunction"}:
        return UnusableVariable("object")
    items: list[Variable] = [
        {name: _variable(item[name]) for name in value.dtype.names} for item in value.reshape(-1, order="F")
    ]
    return items[0] if len(items) == 1 else items


def _numbers(value: Any) -> MatlabArray:
    table = value.reshape(-1, 1) if 1 in value.shape else value

    def read(column: int, start: int, stop: int) -> FloatArray:
        return np.asarray(table[start:stop, column], dtype=np.float64)

    return MatlabArray(table.shape[0], table.shape[1], read)
