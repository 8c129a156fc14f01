"""One HDF5 file per recording: a dataset per column, metadata as attributes; MATLAB and any other reader opens it.

Files are written whole.
"""

from __future__ import annotations

import contextlib
import io
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.signals._columns import COLUMNS, declare_column
from musclewire.signals._metadata import RESERVED, MetadataValue, checked_metadata
from musclewire.signals._whole_files import write_whole

FORMAT = "musclewire-recording"
FORMAT_VERSION = 1
_CHUNK_ROWS = 16_384  # 128 KiB of a column, which are read and written at once: little memory, and few accesses


def fill_hdf5(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write columns to ``path`` directly; ``write_columns`` makes sure that the file is complete."""
    with _quiet_file(path, "w") as file:
        for name, values in columns.items():
            _with_unit(file.create_dataset(name, data=np.asarray(values, dtype=np.float64)), name)
        _describe(file, tuple(columns), len(next(iter(columns.values()))), metadata)


def fill_hdf5_blocks(
    names: Sequence[str],
    blocks: Iterable[tuple[FloatArray, ...]],
    metadata: Mapping[str, MetadataValue],
    path: Path,
) -> None:
    """Write blocks of columns to ``path`` directly, for recordings that do not fit in memory."""
    rows = 0
    with _quiet_file(path, "w") as file:
        for name in names:
            _with_unit(file.create_dataset(name, (0,), "f8", maxshape=(None,), chunks=(_CHUNK_ROWS,)), name)
        for block in blocks:
            stop = rows + block[0].size
            for name, values in zip(names, block, strict=True):
                file[name].resize((stop,))
                file[name][rows:stop] = values
            rows = stop
        _describe(file, names, rows, metadata)


def _with_unit(dataset: Any, name: str) -> None:
    dataset.attrs["unit"] = COLUMNS[name].unit


def _describe(file: Any, names: Sequence[str], rows: int, metadata: Mapping[str, MetadataValue]) -> None:
    file.attrs["format"] = FORMAT
    file.attrs["format_version"] = FORMAT_VERSION
    file.attrs["columns"] = ",".join(names)
    file.attrs.create("rows", rows, dtype=np.int64)
    _write_metadata(file, metadata)


def describe_recording(path: str | Path, metadata: Mapping[str, MetadataValue]) -> None:
    """Add metadata to a finished recording in one step, as an analysis found them. Raises CallerError if that fails."""
    added = checked_metadata(metadata)

    def write(part: Path) -> None:
        shutil.copyfile(path, part)
        with _quiet_file(part, "r+") as file:
            _write_metadata(file, added)

    write_whole(Path(path), write)


class _QuietFile(io.FileIO):
    """A file that keeps its errors until it is closed: HDF5 prints pages about a full disk, and may crash then."""

    problem: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all of the data, or keep the error; for HDF5 all is well."""
        rest = memoryview(data).cast("B")
        size = len(rest)
        try:
            while len(rest) and self.problem is None:
                rest = rest[super().write(rest) or 0 :]
        except OSError as problem:
            self.problem = problem
        return size

    def truncate(self, size: int | None = None) -> int:
        """Change the file's length, or keep the error."""
        try:
            return super().truncate(size)
        except OSError as problem:
            self.problem = self.problem or problem
            return size or 0


@contextlib.contextmanager
def _quiet_file(path: Path, mode: str) -> Iterator[Any]:
    """Open a file for HDF5 to write. Raises OSError if the disk did not take all of it."""
    import h5py

    with _QuietFile(path, "w+" if mode == "w" else mode) as raw:
        try:
            with h5py.File(raw, mode) as file:
                yield file
        except Exception:
            # What HDF5 says about a file that does not hold what it has written follows from the error before.
            if raw.problem is None:
                raise
        if raw.problem is not None:
            raise raw.problem


def read_hdf5_columns(path: Path) -> tuple[dict[str, FloatArray], dict[str, MetadataValue]]:
    """Return columns and metadata; of a file cut off in a run, its complete rows and ``ended`` "cut off".

    Raises RecordingError if the file is missing, damaged, still being written, or not a musclewire recording.
    """
    with _open_file(path) as file, _damage_reported(path):
        _check_format(file, path)
        named = [name for name in str(file.attrs.get("columns", "")).split(",") if declare_column(name)]
        names = named or [name for name in sorted(file) if name in COLUMNS]
        columns = {name: _values(file, name, path) for name in names}
        metadata = {key: _from_attribute(file.attrs[key]) for key in file.attrs if key not in RESERVED}
        rows = min([int(file.attrs.get("rows", 2**62)), *(len(values) for values in columns.values())])
    if metadata.get("ended") == "running":
        metadata["ended"] = "cut off"
    return {name: values[:rows] for name, values in columns.items()}, metadata


def is_recording(path: Path) -> bool:
    """Return whether an HDF5 file is a recording of musclewire. Raises RecordingError if it cannot be opened."""
    with _open_file(path) as file, _damage_reported(path):
        return bool(file.attrs.get("format") == FORMAT)


def _write_metadata(file: Any, metadata: Mapping[str, MetadataValue]) -> None:
    import h5py

    for key, value in metadata.items():
        file.attrs[key] = h5py.Empty("f8") if value is None else value


def _open_file(path: Path) -> Any:
    import h5py

    if not path.is_file():
        raise RecordingError(f"{path}: {'is a folder' if path.is_dir() else 'no such file'}; give a recording file")
    try:
        return h5py.File(path, "r")
    except BlockingIOError:
        raise RecordingError(f"{path}: is still being written by another process; wait until it ends") from None
    except PermissionError:
        raise RecordingError(f"{path}: may not be read; check its permissions") from None
    except OSError as problem:
        if not h5py.is_hdf5(path):
            raise RecordingError(f"{path}: is not an HDF5 file; export it as CSV with units in the header") from None
        raise RecordingError(f"{path}: is a damaged HDF5 file ({_first_line(problem)}); use another copy") from None


@contextlib.contextmanager
def _damage_reported(path: Path) -> Any:
    """Turn errors of h5py about damaged contents into one line."""
    try:
        yield
    except RecordingError:
        raise
    except (OSError, KeyError, RuntimeError, ValueError, TypeError) as problem:
        raise RecordingError(f"{path}: is a damaged recording ({_first_line(problem)}); use another copy") from None


def _check_format(file: Any, path: Path) -> None:
    if file.attrs.get("format") != FORMAT:
        raise RecordingError(
            f"{path}: is HDF5 but no musclewire recording (no attribute format='{FORMAT}'); "
            "export it as CSV with units in the header"
        )
    version = int(file.attrs.get("format_version", 0))
    if version != FORMAT_VERSION:
        raise RecordingError(
            f"{path}: has format_version {version}, this musclewire reads {FORMAT_VERSION}; update musclewire"
        )


def _values(file: Any, name: str, path: Path) -> FloatArray:
    if name not in file:
        raise RecordingError(f"{path}: the column '{name}' is listed but missing; use another copy")
    values: FloatArray = np.asarray(file[name][()], dtype=np.float64)
    if values.ndim != 1:
        raise RecordingError(f"{path}: column '{name}' has shape {values.shape}; it must have one value per row")
    return values


def _from_attribute(value: object) -> MetadataValue:
    import h5py

    if isinstance(value, h5py.Empty):
        return None
    plain = value.item() if isinstance(value, (np.generic, np.ndarray)) and value.size == 1 else value
    return plain if isinstance(plain, (str, int, float, bool)) else str(plain)


def _first_line(problem: BaseException) -> str:
    return (str(problem).splitlines() or [type(problem).__name__])[0].strip()
