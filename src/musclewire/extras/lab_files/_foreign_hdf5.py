"""HDF5 files of other programs: a group of data sets of equal length, a table of records, or a matrix with names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.extras.lab_files._file_table import (
    FileColumn,
    FilePart,
    FileTable,
    chosen_part,
    damage_reported,
    file_table,
    metadata_of,
    one_line,
)
from musclewire.extras.lab_files._hdf5_datasets import checked, decoded, numbers_of, opened, text_attribute

_UNIT_NAMES = ("unit", "units", "unit_string", "engineeringunits", "uom")
_NAMES = ("columns", "column_names", "names", "fields", "channels", "labels", "headers", "variables")
MAX_COLUMNS = 10_000


def read_hdf5_of_others(path: Path, group: str | None = None) -> FileTable:
    """Return the table of one group of an HDF5 file; None takes the only one.

    Data sets of a group that have equal lengths are one table, each a column; so are the fields of a table of records,
    and the columns of a matrix. Only hard links within the file are followed. Raises RecordingError for data outside
    the file and an unclear choice.
    """
    with opened(path) as file, damage_reported(path, "HDF5"):
        part = chosen_part(list(_parts(file, path)), group, path)
    return file_table(path, f"HDF5, group '{one_line(part.name)}'", part)


def _parts(file: Any, path: Path) -> Iterator[FilePart]:
    folders: dict[str, list[Any]] = {"/": []}
    for dataset in _datasets(file):
        folder = dataset.name.rpartition("/")[0] or "/"
        folders.setdefault(folder, []).append(dataset)
    for folder, datasets in folders.items():
        scalars = {dataset.name.rpartition("/")[2]: dataset for dataset in datasets if dataset.size == 1}
        numbers = {key: _scalar(each, path) for key, each in scalars.items()}
        metadata = metadata_of({**file.attrs, **file[folder].attrs, **numbers})
        for part in _parts_of_folder(folder, [dataset for dataset in datasets if dataset.size != 1], path):
            yield FilePart(part.name, part.columns, part.row_count, metadata)


def _datasets(file: Any) -> list[Any]:
    """Return every data set that a hard link reaches, each once."""
    import h5py

    found: list[Any] = []
    file.visititems(lambda _, item: found.append(item) if isinstance(item, h5py.Dataset) else None)
    return found


def _scalar(dataset: Any, path: Path) -> object:
    # Text of variable length could point to anything large; a number cannot.
    return np.asarray(checked(dataset, path)[()]).reshape(-1)[0] if dataset.dtype.kind in "biuf" else None


def _parts_of_folder(folder: str, datasets: list[Any], path: Path) -> Iterator[FilePart]:
    by_length: dict[int, list[Any]] = {}
    for dataset in datasets:
        if dataset.dtype.kind in "biuf" and len([length for length in dataset.shape if length != 1]) == 1:
            by_length.setdefault(dataset.size, []).append(dataset)
        elif dataset.dtype.names and dataset.ndim == 1:
            yield _records(dataset, path)
        elif dataset.dtype.kind in "biuf" and dataset.ndim == 2:
            yield _matrix(dataset, path)
    for rows, equal in by_length.items():
        name = folder if len(by_length) == 1 else f"{folder}, {rows} rows"
        yield FilePart(name, tuple(_vector(dataset, path) for dataset in equal), rows)


def _vector(dataset: Any, path: Path) -> FileColumn:
    axis = int(np.argmax(dataset.shape))
    name = text_attribute(dataset, "long_name", "label") or dataset.name.rpartition("/")[2]
    index = (None if each == axis else 0 for each in range(dataset.ndim))
    return FileColumn(name, text_attribute(dataset, *_UNIT_NAMES), numbers_of(path, dataset, *index))


def _records(dataset: Any, path: Path) -> FilePart:
    fields = [name for name in dataset.dtype.names if dataset.dtype[name].kind in "biuf"]
    columns = (
        FileColumn(
            field,
            text_attribute(dataset, *(f"{field.lower()}_{name}" for name in _UNIT_NAMES)),
            numbers_of(path, dataset, field=field),
        )
        for field in fields[:MAX_COLUMNS]
    )
    return FilePart(dataset.name, tuple(columns), dataset.shape[0])


def _matrix(dataset: Any, path: Path) -> FilePart:
    """Return a matrix as a table; its names are an attribute, and so show whether its columns are HDF5's or not."""
    names = _names_of(dataset)
    rows_first = len(names) == dataset.shape[1] if names else dataset.shape[0] >= dataset.shape[1]
    rows, width = dataset.shape if rows_first else dataset.shape[::-1]
    units = _texts(dataset, _UNIT_NAMES)
    stem = dataset.name.rpartition("/")[2]
    columns = (
        FileColumn(
            names[index] if len(names) == width else f"{stem} {index + 1}",
            units[index] if len(units) == width else None,
            numbers_of(path, dataset, *((None, index) if rows_first else (index, None))),
        )
        for index in range(min(width, MAX_COLUMNS))
    )
    return FilePart(dataset.name, tuple(columns), rows)


def _names_of(dataset: Any) -> list[str]:
    names = _texts(dataset, _NAMES)
    return names if len(names) in dataset.shape else []


def _texts(dataset: Any, keys: tuple[str, ...]) -> list[str]:
    """Return the texts of an attribute, kept as an array of texts or as one with commas."""
    present = {key.lower(): key for key in dataset.attrs}
    for key in keys:
        value = dataset.attrs[present[key]] if key in present else None
        if isinstance(value, np.ndarray) and value.ndim == 1 and value.size <= MAX_COLUMNS:
            return [decoded(item) or "" for item in value]
        if text := decoded(value):
            return [part.strip() for part in text.split(",")]
    return []
