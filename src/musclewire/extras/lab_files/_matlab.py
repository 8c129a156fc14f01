"""MATLAB files: versions 4 and 5 read by SciPy, 7.3 by h5py, and the tables in their variables.

Vectors of equal length are a table, and so are the columns of a matrix; so is each struct that holds such.
"""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError
from musclewire.extras.lab_files._file_table import (
    MAX_CELLS_AT_ONCE,
    FileTable,
    check_limits,
    chosen_table,
    damage_reported,
    one_line,
)
from musclewire.extras.lab_files._hdf5_tree import MATLAB_NUMBERS, MAX_NAMES, hdf5_folders
from musclewire.extras.lab_files._named_arrays import Folder, NamedArray, names_columns, parts_of
from musclewire.signals import COLUMNS, FileWriter, MetadataValue

# Our own .mat files keep the metadata, which MATLAB's names cannot all spell, as JSON in this variable.
METADATA_NAME = "musclewire_metadata"

MAX_DEPTH = 8  # structs within structs
_ROOT = "variables"
_CURES = {
    "cell": "turn it into columns in MATLAB (cell2mat) and save these",
    "table": "save its columns: S = table2struct(T, 'ToScalar', true); save('f.mat', '-struct', 'S')",
    "timetable": "save its columns: S = table2struct(timetable2table(T), 'ToScalar', true), with seconds(S.Time)",
    "function": "it holds no numbers; save the vectors themselves",
    "function_handle": "it holds no numbers; save the vectors themselves",
}
_OBJECT_CURE = (
    "only MATLAB can read it; save columns: t = ts.Time; x = ts.Data; of a timeseries, or of a timetable "
    "S = table2struct(timetable2table(T), 'ToScalar', true), times by seconds()"
)


def read_matlab_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of the variables of a MATLAB file, or of the struct ``group``; None takes the only one.

    Raises RecordingError that names MATLAB's cure for classes of other than numbers and text.
    """
    with path.open("rb") as file:
        is_hdf5 = file.read(10).startswith((b"MATLAB 7.3", b"\x89HDF"))
    what = "a MATLAB 7.3 file" if is_hdf5 else "a MATLAB file"
    with damage_reported(path, what):
        folders, version = (hdf5_folders(path, what), "7.3") if is_hdf5 else _folders_of_5(path)
        unusable = [
            (".".join((*folder.path, name)), kind) for folder in folders for name, kind in folder.left_out.items()
        ]
        own = [folder.attributes.pop(METADATA_NAME, None) for folder in folders if not folder.path]
        for folder in folders:
            folder.arrays = [_on_its_side(array, is_hdf5) for array in folder.arrays]
        parts = parts_of(folders, lambda names: ".".join(names) or _ROOT)
        if unusable and not any(part.row_count > 1 for part in parts):
            name, kind = unusable[0]
            cure = _CURES.get(kind, _OBJECT_CURE)
            raise RecordingError(f"{path}: variable '{one_line(name)}' is a {one_line(kind)}: {cure}")
        own_metadata = _own_metadata(own, path)
        parts = [replace(part, metadata={**part.metadata, **own_metadata}) for part in parts]
        table = chosen_table(path, f"MATLAB {version}, {{}}", parts, group)
        return replace(table, layout=table.layout.removesuffix(f", {_ROOT}"))


def _folders_of_5(path: Path) -> tuple[list[Folder], str]:
    """Return the variables of version 5 or 4: classes of numbers, text and structs, and the names of others."""
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import matfile_version

    with warnings.catch_warnings():
        # A duplicate or unreadable variable is reported below, as missing.
        warnings.simplefilter("ignore")
        listed = whosmat(str(path), appendmat=False)
        check_limits(path, cells=sum(math.prod(shape) for _, shape, _ in listed), at_once=True)
        wanted = [
            name
            for name, shape, kind in listed
            if kind in {"char", "struct", *MATLAB_NUMBERS} or (kind == "cell" and math.prod(shape) <= MAX_NAMES)
        ]
        loaded = loadmat(str(path), variable_names=wanted, appendmat=False, simplify_cells=True) if wanted else {}
    # A cell array of texts names columns; any other is no table.
    for name, _, kind in listed:
        if kind == "cell" and not all(
            isinstance(text, str) for text in np.ravel(np.array(loaded.get(name), dtype=object))
        ):
            loaded.pop(name, None)
    others = {name: "object" if kind == "opaque" else kind for name, _, kind in listed if name not in loaded}
    folders = list(_folders({name: loaded[name] for name in wanted if name in loaded}, ()))
    folders[0].left_out |= others
    return folders, "4" if matfile_version(str(path))[0] == 0 else "5"


def _folders(struct: Mapping[str, Any], path: tuple[str, ...]) -> Iterator[Folder]:
    """Yield a struct, and then the structs within it."""
    folder = Folder(path)
    inner: dict[str, Mapping[str, Any]] = {}
    for name, value in struct.items():
        if isinstance(value, Mapping):
            inner[name] = value
        elif isinstance(value, (list, np.ndarray)) and np.ndim(value) == 1 and all(isinstance(x, dict) for x in value):
            inner |= {f"{name}({number})": each for number, each in enumerate(value, start=1)}
        elif isinstance(value, str):
            folder.attributes[name] = value
        elif (array := np.asarray(value)).dtype.kind in "biuf":
            folder.arrays.append(NamedArray(name, array.shape, array.__getitem__))
        elif array.size and all(isinstance(text, str) for text in array.flat):
            if names_columns(name):
                folder.attributes[name] = array.ravel().tolist()
            else:
                folder.arrays.append(NamedArray(name, (array.size,), array.ravel().__getitem__, is_text=True))
        elif array.dtype.kind != "U":
            folder.left_out[name] = "cell" if array.dtype.kind == "O" else "complex array"
    yield folder
    for name, each in inner.items():
        if len(path) < MAX_DEPTH:
            yield from _folders(each, (*path, name))


def _on_its_side(array: NamedArray, is_hdf5: bool) -> NamedArray:
    """Return an array; of a matrix wider than high, what its first row and first column say of its rows.

    Simulink's To File writes a signal in each row, the time first; a first column rises where channels outnumber rows.
    """
    # HDF5 keeps MATLAB's dimensions in the opposite order.
    shape = array.shape[::-1] if is_hdf5 else array.shape
    if len(array.axes) != 2 or len(shape) != 2 or not shape[0] < shape[1] <= MAX_CELLS_AT_ONCE:
        return array
    row, column = (0, slice(0, shape[1])), (slice(0, shape[0]), 0)
    rises = [
        bool((np.diff(array.read(index[::-1] if is_hdf5 else index).ravel()) > 0.0).all()) for index in (row, column)
    ]
    stated: dict[str, object] = {}
    if rises[0]:
        stated["units"] = ["s", *[""] * (shape[0] - 1)]
    elif rises[1]:
        stated["columns"] = [f"{array.name} {number}" for number in range(1, shape[1] + 1)]
    return replace(array, attributes={**array.attributes, **stated})


def _own_metadata(texts: Sequence[object], path: Path) -> dict[str, MetadataValue]:
    if not any(isinstance(text, str) for text in texts):
        return {}
    try:
        return {str(key): value for key, value in json.loads(str(texts[0])).items()}
    except (ValueError, AttributeError, RecursionError):
        raise RecordingError(f"{path}: its variable {METADATA_NAME} is damaged; use another copy") from None


Columns = Mapping[str, FloatArray]
Metadata = Mapping[str, MetadataValue]

MATLAB_VERSIONS = ("5", "7.3")

# An element of version 5 states its size in 32 bits, and MATLAB reads half of that.
MAX_COLUMN_BYTES = 2**31 - 1024
_HEADER_BYTES = 512  # of version 7.3, before the HDF5
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


WRITER = FileWriter(fill_of_version)
