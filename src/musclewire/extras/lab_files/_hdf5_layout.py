"""What may be read in an HDF5 file of another program: data in the file itself, compressed by HDF5's own filters.

Soft and external links are never followed, virtual and external data sets are refused: they would open other files.
A filter that HDF5 does not bring itself is refused, because HDF5 would load a library for it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import damage_reported, one_line

__all__ = ["check_readable", "decoded", "opened", "rows_reader", "text_attribute"]

_OWN_FILTERS = {1: "gzip", 2: "shuffle", 3: "fletcher32", 4: "szip", 5: "nbit", 6: "scaleoffset", 32000: "lzf"}
MAX_CHUNK_BYTES = 2**28
# Deflate shrinks by 1032 at most; a file that states far more numbers than its bytes can hold is damaged or hostile.
MAX_RATIO = 1100
_NEVER_SUSPICIOUS = 2**26


def opened(path: Path, what: str = "HDF5") -> Any:
    """Return an HDF5 file opened for reading. Raises RecordingError if it is none, or damaged."""
    import h5py

    with damage_reported(path, what):
        try:
            return h5py.File(path, "r")
        except BlockingIOError:
            raise RecordingError(f"{path}: is still being written by another process; wait until it ends") from None


def check_readable(dataset: Any, path: Path) -> None:
    """Raise RecordingError for a data set whose numbers are not in this file, or cannot be as many as it states."""
    where = f"{path}: data set '{one_line(str(dataset.name))}'"
    if dataset.is_virtual or dataset.external:
        raise RecordingError(f"{where} keeps its numbers in other files; copy them into one file (h5repack)")
    plist = dataset.id.get_create_plist()
    for index in range(plist.get_nfilters()):
        number = plist.get_filter(index)[0]
        if number not in _OWN_FILTERS:
            raise RecordingError(f"{where} is compressed by filter {number}; save it with gzip (h5repack -f GZIP=4)")
    size = dataset.size * dataset.dtype.itemsize
    if dataset.chunks and int(np.prod(dataset.chunks, dtype=object)) * dataset.dtype.itemsize > MAX_CHUNK_BYTES:
        raise RecordingError(f"{where} has chunks of more than 256 MiB; save it with smaller ones (h5repack)")
    if size > _NEVER_SUSPICIOUS and size > MAX_RATIO * dataset.id.get_storage_size():
        held = dataset.id.get_storage_size()
        raise RecordingError(f"{where} states {size} bytes and holds {held}; it is damaged, use another copy")


def rows_reader(path: Path, name: str, pick: Callable[[Any, int, int], Any]) -> Callable[[int, int], FloatArray]:
    """Return a function that opens the file and reads rows of a data set: no file stays open between reads."""

    def read(start: int, stop: int) -> FloatArray:
        with opened(path) as file:
            return np.asarray(pick(file[name], start, stop), dtype=np.float64).reshape(-1)

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
