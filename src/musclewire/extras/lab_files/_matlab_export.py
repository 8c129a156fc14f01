"""Recordings as MATLAB files: a variable for each column, structs of units and metadata; version 5, or 7.3 (HDF5).

Layout of 7.3: MathWorks' MAT-files are HDF5 behind 512 bytes of header, dimensions in the opposite order, and the class
of each variable as the attribute ``MATLAB_class``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.lab_files._matlab import METADATA_NAME
from musclewire.signals import COLUMNS, MetadataValue

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
