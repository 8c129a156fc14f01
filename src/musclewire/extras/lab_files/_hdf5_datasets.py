"""Rows of data sets in HDF5 files of others. No other file is opened: links are not followed, nor data outside."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import check_limits, damage_reported, one_line


def opened(path: Path, what: str = "HDF5") -> Any:
    """Return an HDF5 file opened for reading. Raises RecordingError if it is none, or damaged."""
    import h5py

    with damage_reported(path, what):
        try:
            return h5py.File(path, "r")
        except BlockingIOError:
            raise RecordingError(f"{path}: is still being written by another process; wait until it ends") from None


def checked(dataset: Any, path: Path) -> Any:
    """Return a data set. Raises RecordingError if its numbers are not in this file, or are more than are read."""
    if dataset.is_virtual or dataset.external:
        where = f"{path}: data set '{one_line(str(dataset.name))}'"
        raise RecordingError(f"{where} keeps its numbers in other files; copy them into one file (h5repack)")
    check_limits(path, cells=dataset.size or 0)
    return dataset


def numbers_of(path: Path, dataset: Any, *index: int | None, field: str = "") -> Callable[[int, int], FloatArray]:
    """Return a function that opens the file and reads rows of a data set: no file stays open between reads.

    ``index`` selects a column, None in place of the rows; without it a vector is read. ``field`` is that of a record.
    """
    name = dataset.name

    def read(start: int, stop: int) -> FloatArray:
        with opened(path) as file:
            item = checked(file[name], path)
            place = tuple(slice(start, stop) if each is None else each for each in index or (None,))
            return np.asarray(item.fields(field)[place] if field else item[place], dtype=np.float64).reshape(-1)

    return read


def text_attribute(item: Any, *names: str) -> str | None:
    """Return the first of some attributes that is a text, whatever the case of its name."""
    present = {key.lower(): key for key in item.attrs}
    for name in names:
        if name in present and (text := decoded(item.attrs[present[name]])):
            return text
    return None


def decoded(value: Any) -> str | None:
    """Return text as it may be kept in an attribute (bytes, text, an array of one), or None for anything else."""
    if isinstance(value, np.ndarray):
        value = value.reshape(-1)[0] if value.size == 1 else None
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    return value if isinstance(value, str) else None
