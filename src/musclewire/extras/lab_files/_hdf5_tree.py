"""HDF5 files of others, netCDF-4 and MATLAB 7.3 among them, as folders of arrays; pandas' frames by their names.

No other file is opened: links are not followed, nor data outside. Nothing is unpickled.
"""

from __future__ import annotations

import contextlib
import itertools
import pickletools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import FileTable, check_limits, chosen_table, damage_reported, one_line
from musclewire.extras.lab_files._named_arrays import MAX_COLUMNS, Folder, NamedArray, decoded, names_columns, parts_of

MAX_OBJECTS = 20_000  # data sets: more are an archive of tests, of which a part has to be chosen
MAX_DEPTH = 32  # groups within groups: no program nests so deep
MAX_TEXT_LENGTH = 1_000_000  # characters of a data set that may be text; more are measured values
MAX_NAMES = 1_000  # texts that may be the names of columns
MATLAB_NUMBERS = frozenset({
    "double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "logical",
})  # fmt: skip
# What h5py's and netCDF's dimensions without values are called.
_NO_VALUES = "This is a netCDF dimension but not a netCDF variable"
_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def read_hdf5_of_others(path: Path, group: str | None = None) -> FileTable:
    """Return the table of one group of an HDF5 file; None takes the only one.

    Data sets of equal lengths are one table; so are records, a matrix, and a frame of pandas. Raises RecordingError for
    data outside the file and an unclear choice.
    """
    with damage_reported(path, "HDF5"):
        return chosen_table(path, "HDF5, group '{}'", parts_of(hdf5_folders(path), hdf5_path), group)


def hdf5_path(names: tuple[str, ...]) -> str:
    """Return a path as HDF5 writes it."""
    return "/" + "/".join(names)


def hdf5_folders(path: Path, what: str = "HDF5") -> list[Folder]:
    """Return the groups of an HDF5 file, of those that a hard link within it reaches."""
    import h5py

    with _opened(path, what) as file, damage_reported(path, what):
        items = list(itertools.islice(_items(file, (), set()), MAX_OBJECTS + 1))
        if len(items) > MAX_OBJECTS:
            raise RecordingError(f"{path}: holds more than {MAX_OBJECTS} data sets; export a part of it")
        tree: dict[tuple[str, ...], Folder] = {(): Folder((), attributes=_attributes(file))}
        for place, item in items:
            if isinstance(item, h5py.Dataset):
                _add(tree, place, item, path)
            elif "pandas_type" in item.attrs:
                tree[place] = _frame(place, item, {name: each for (name, *_), each in _items(item, (), set())}, path)
            else:
                tree[place] = Folder(place, attributes=_attributes(item))
        return list(tree.values())


def _items(group: Any, place: tuple[str, ...], seen: set[int]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield what hard links within a file reach, each once, in the order in which the file lists it."""
    import h5py

    for name in group:
        # What MATLAB's references point to, and PyTables' indices, are no data.
        if name.startswith(("#", "_i_")) or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        item = group[name]
        address = h5py.h5o.get_info(item.id).addr
        if address not in seen:
            seen.add(address)
            yield (*place, name), item
            if isinstance(item, h5py.Group) and "pandas_type" not in item.attrs and len(place) < MAX_DEPTH:
                yield from _items(item, (*place, name), seen)


def _attributes(item: Any) -> dict[str, object]:
    """Return the attributes of a group or data set, without those of types that NumPy does not have."""
    found: dict[str, object] = {}
    for key in item.attrs:
        with contextlib.suppress(TypeError, OSError, ValueError):
            found[key] = item.attrs[key]
    return found


def _opened(path: Path, what: str = "HDF5") -> Any:
    """Return an HDF5 file opened for reading. Raises RecordingError if it is none, or damaged."""
    import h5py

    with damage_reported(path, what):
        try:
            return h5py.File(path, "r")
        except BlockingIOError:
            raise RecordingError(f"{path}: is still being written by another process; wait until it ends") from None


def _add(tree: dict[tuple[str, ...], Folder], place: tuple[str, ...], dataset: Any, path: Path) -> None:
    """Put a data set where it belongs: an array, a table of records, a text, or what is left out."""
    import h5py

    folder, name = tree[place[:-1]], place[-1]
    matlab_class = decoded(dataset.attrs.get("MATLAB_class"))
    if "MATLAB_empty" in dataset.attrs or str(decoded(dataset.attrs.get("NAME"))).startswith(_NO_VALUES):
        return
    if (text := _matlab_text(dataset, path)) is not None:
        folder.attributes[name] = text
    elif matlab_class is None and len(place) > 1 and h5py.check_ref_dtype(dataset.dtype) is h5py.Reference:
        # The fields of an array of structs are references, which MATLAB marks by no class.
        check_limits(path, cells=dataset.size, at_once=True)
        for number, reference in enumerate(_checked(dataset, path)[()].reshape(-1)[:MAX_COLUMNS], start=1):
            element = (*place[:-2], f"{place[-2]}({number})")
            referred = dataset.file[reference]
            tree.setdefault(element, Folder(element))
            if isinstance(referred, h5py.Dataset) and referred.dtype.kind != "O":
                _add(tree, (*element, name), referred, path)
    elif dataset.dtype.names and dataset.ndim == 1:
        tree[place] = Folder(place, list(_fields(dataset, path)), _attributes(dataset))
    elif dataset.dtype.kind in "biuf" and matlab_class in {None, *MATLAB_NUMBERS}:
        folder.arrays.append(_array(path, dataset, name))
    elif h5py.check_string_dtype(dataset.dtype) and dataset.size:
        if dataset.size == 1 or (dataset.size <= MAX_NAMES and names_columns(name)):
            found = [decoded(text) or "" for text in np.ravel(_checked(dataset, path)[()])]
            folder.attributes[name] = found if len(found) > 1 else found[0]
        else:
            folder.arrays.append(replace(_array(path, dataset, name), is_text=True))
    elif matlab_class == "cell" and dataset.size <= MAX_NAMES and (names := _texts_of_cell(dataset, path)):
        folder.attributes[name] = names
    else:
        folder.left_out[name] = (
            "it holds no real numbers" if matlab_class in {None, *MATLAB_NUMBERS} else str(matlab_class)
        )


def _matlab_text(dataset: Any, path: Path) -> str | None:
    """Return one row of text in UTF-16 code units, as MATLAB keeps it; None for anything else."""
    if (
        decoded(dataset.attrs.get("MATLAB_class")) != "char"
        or dataset.dtype.kind != "u"
        or dataset.size > MAX_TEXT_LENGTH
    ):
        return None
    return np.asarray(_checked(dataset, path)[()], dtype="<u2").tobytes().decode("utf-16-le", errors="replace")


def _texts_of_cell(dataset: Any, path: Path) -> list[str]:
    """Return the texts of a cell array of MATLAB, none if it holds anything else."""
    import h5py

    if h5py.check_ref_dtype(dataset.dtype) is not h5py.Reference:
        return []
    try:
        cells = [dataset.file[reference] for reference in _checked(dataset, path)[()].reshape(-1)]
    except ValueError:  # a reference to nothing
        return []
    texts = [_matlab_text(cell, path) if isinstance(cell, h5py.Dataset) else None for cell in cells]
    return [text for text in texts if text is not None] if None not in texts else []


def _checked(dataset: Any, path: Path) -> Any:
    """Return a data set. Raises RecordingError if its numbers are not in this file, or are more than are read."""
    if dataset.is_virtual or dataset.external:
        where = f"{path}: data set '{one_line(str(dataset.name))}'"
        raise RecordingError(f"{where} keeps its numbers in other files; copy them into one file (h5repack)")
    check_limits(path, cells=dataset.size or 0)
    return dataset


def _array(path: Path, dataset: Any, name: str, field: str = "", **attributes: object) -> NamedArray:
    """Return a data set, or a field of its records, as an array; no file stays open between reads."""
    key = dataset.name

    def read(index: tuple[int | slice, ...]) -> Any:
        with _opened(path) as file:
            item = _checked(file[key], path)
            return np.asarray(item.fields(field)[index[0]])[(..., *index[1:])] if field else item[index]

    shape = dataset.shape + (dataset.dtype[field].shape if field else ())
    return NamedArray(name, shape, read, attributes if field else _attributes(dataset))


def _fields(dataset: Any, path: Path) -> Iterator[NamedArray]:
    """Yield the fields of a table of records, each with the attributes that begin with its name."""
    for field in dataset.dtype.names[:MAX_COLUMNS]:
        if (kind := dataset.dtype[field].base.kind) in "biufS":
            start = f"{field.lower()}_"
            own = {key: value for key, value in _attributes(dataset).items() if key.lower().startswith(start)}
            array = _array(path, dataset, field, field, **{key[len(start) :]: value for key, value in own.items()})
            yield replace(array, is_text=kind == "S")


def _frame(place: tuple[str, ...], group: Any, members: Mapping[str, Any], path: Path) -> Folder:
    """Return what pandas' ``to_hdf`` wrote: each column by its name, and the index if it is a time or has a name."""
    folder = Folder(place)
    for dataset, field, names, kind in _blocks(group, members, path):
        block = _array(path, dataset, field or dataset.name.rpartition("/")[2], field)
        if (dataset.dtype[field] if field else dataset.dtype).base.kind not in "biuf":
            folder.left_out |= dict.fromkeys(names or [block.name], "it holds no numbers, and nothing is unpickled")
            continue
        width = block.shape[1] if len(block.shape) > 1 else 1
        named = names if len(names) == width else [f"{block.name} {number + 1}" for number in range(width)]
        folder.arrays += [_typed(block, name, index, kind) for index, name in enumerate(named[:MAX_COLUMNS])]
    return folder


def _blocks(group: Any, members: Mapping[str, Any], path: Path) -> Iterator[tuple[Any, str, list[str], str]]:
    """Yield data set, field of its records, names and kind of each block of columns, of the index if it is one."""
    if "table" in members:
        table, info = members["table"], [*_pickled_texts(group.attrs.get("info")), "", ""]
        indices = [(table, "index", info[info.index("index_name") + 1] if "index_name" in info else "", "index_kind")]
        blocks = [
            (table, field, _pickled_texts(table.attrs.get(f"{field}_kind")), f"{field}_dtype")
            for field in table.dtype.names or ()
            if field != "index"
        ]
    else:
        series = decoded(group.attrs.get("name")) or "values"
        indices = [
            (members[name], "", decoded(members[name].attrs.get("name")) or "", "kind")
            for name in ("index", "axis1")
            if name in members
        ]
        blocks = [
            (values, "", [series] if name == "values" else _names(members.get(f"{name[:-6]}items"), path), "value_type")
            for name, values in members.items()
            if name.endswith("values")
        ]
    for dataset, field, name, key in indices:
        kind = decoded(dataset.attrs.get(key)) or ""
        # Without a name, which pandas writes as the pickle "N.", an index of whole numbers only counts the rows.
        named = name if name not in {"", "N."} else "time" if "64" in kind else "index" if kind == "float" else ""
        if named:
            yield dataset, field, [named], kind
    for dataset, field, names, key in blocks:
        yield dataset, field, names, decoded(dataset.attrs.get(key)) or ""


def _typed(block: NamedArray, name: str, column: int, kind: str) -> NamedArray:
    """Return a column of a block: numbers, or what pandas counts in whole seconds, ms, us or ns."""
    unit = kind.partition("[")[2].partition("]")[0] or "ns"
    is_time = kind.startswith("datetime64") and unit in _SECONDS

    def read(index: tuple[int | slice, ...]) -> Any:
        values = block.read((*index, *[column] * (len(block.shape) - 1)))
        return np.asarray(values).astype(f"datetime64[{unit}]") if is_time else values

    lasts = {"unit": "s", "scale_factor": _SECONDS.get(unit), "_FillValue": np.iinfo(np.int64).min}
    return NamedArray(name, block.shape[:1], read, lasts if kind.startswith("timedelta64") else {"zone": ""}, is_time)


def _names(items: Any, path: Path) -> list[str]:
    if items is None or items.dtype.kind not in "Siu" or items.size > MAX_COLUMNS:
        return []
    return [decoded(item) or str(item) for item in _checked(items, path)[()].reshape(-1).tolist()]


def _pickled_texts(pickle: object) -> list[str]:
    """Return the texts in a pickled list of names, by a listing of its parts: nothing is unpickled."""
    try:
        raw = pickle if isinstance(pickle, bytes) else b""
        return [argument for _, argument, _ in pickletools.genops(raw) if isinstance(argument, str)]
    except ValueError:
        return []
