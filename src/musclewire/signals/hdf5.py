"""One HDF5 file per run: a dataset per column, metadata as attributes, readable even if the run was cut off.

The file is plain HDF5 and not SWMR: after a crash MATLAB's h5read and any other reader opens it as it is.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError, nearest_hint
from musclewire.signals.columns import COLUMNS, known_column, needs_no_clock
from musclewire.signals.metadata import RESERVED, MetadataValue, checked_metadata

__all__ = ["RecordingWriter", "read_hdf5_columns", "fill_hdf5"]

FORMAT = "musclewire-recording"
FORMAT_VERSION = 1

# Larger chunks change the index of a file less often, and what does not change cannot be torn by a kill.
_CHUNK_ROWS = 1024


class RecordingWriter:
    """Writes a recording during the run; if the process is killed at any moment, every flushed row can be read.

    Parameters
    ----------
    path
        The file.
    columns
        Names from ``COLUMNS``; every row gives all of them.
    metadata
        As in ``Recording``; ``ended`` is written here, "running" until :meth:`close`.
    block_rows
        Rows that are buffered, then written and flushed together: 20 are one second at 20 Hz.
    overwrite
        Whether to replace an existing file, which is refused otherwise.

    Raises
    ------
    CallerError
        For an unknown or repeated column, no clock, ``block_rows`` under 1, or a file that exists or cannot be made.
    """

    def __init__(
        self,
        path: str | Path,
        columns: Sequence[str],
        metadata: Mapping[str, MetadataValue] | None = None,
        block_rows: int = 20,
        overwrite: bool = False,
    ) -> None:
        """Create the file, with its columns still empty."""
        if block_rows < 1:
            raise CallerError(f"block_rows is {block_rows}; give 1 or more")
        self._path = Path(path)
        self._names = _checked_names(columns)
        self._block_rows = block_rows
        self._buffer: list[list[float]] = []
        self._rows = 0
        self._ended = "running"
        running = {**(metadata or {}), "ended": "running"}
        self._file = _create_file(self._path, self._names, checked_metadata(running), overwrite)
        self._file.flush()

    @property
    def path(self) -> Path:
        """The file being written."""
        return self._path

    @property
    def rows_written(self) -> int:
        """Rows that are in the file and survive a kill."""
        return self._rows

    @property
    def ended(self) -> str:
        """``"running"`` until closed, then why it ended."""
        return self._ended

    def append(self, row: Mapping[str, float]) -> None:
        """Add one row; every ``block_rows`` rows are written and flushed.

        Parameters
        ----------
        row
            A number for each column, by name, SI.

        Raises
        ------
        CallerError
            For a row that lacks a column, names another or gives no number, or after :meth:`close`.
        """
        if self._ended != "running":
            raise CallerError(f"{self._path}: the recording is closed ('{self._ended}'); start another one")
        self.append_values(_checked_row(row, self._names))

    def append_values(self, values: list[float]) -> None:
        """Add one row as a list, without checks; the caller must not change the list afterwards.

        Parameters
        ----------
        values
            A number for each column, in their order, SI.
        """
        self._buffer.append(values)
        if len(self._buffer) >= self._block_rows:
            self._write_block()

    def close(self, ended: str = "done", metadata: Mapping[str, MetadataValue] | None = None) -> None:
        """Write the remaining rows, and why the recording ended. Closing twice does nothing.

        Parameters
        ----------
        ended
            Why, in one line; "done" for a run that reached its end.
        metadata
            Entries that were not known when the file was created.
        """
        if self._ended != "running":
            return
        self._ended = _one_line(ended) or "done"
        try:
            self._write_block()
            _write_metadata(self._file, checked_metadata(metadata or {}))
            self._file.attrs["ended"] = self._ended
        finally:
            self._file.close()

    def close_unfinished(self) -> None:
        """Write the remaining rows and close the file without a reason, so that it reads as a run that was cut off."""
        self._write_block()
        self._file.close()

    def __enter__(self) -> RecordingWriter:
        """Return the writer itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file, with the reason if an exception was raised; the exception propagates."""
        if kind is None:
            self.close()
        elif issubclass(kind, (KeyboardInterrupt, SystemExit)):
            self.close("interrupted")
        else:
            self.close(f"{kind.__name__}: {problem}")

    def _write_block(self) -> None:
        if not self._buffer:
            return
        block = np.array(self._buffer, dtype=np.float64)
        stop = self._rows + block.shape[0]
        for index, name in enumerate(self._names):
            dataset = self._file[name]
            dataset.resize((stop,))
            dataset[self._rows : stop] = block[:, index]
        self._file.flush()
        # Only now are the rows in the file: the count follows the data, so that a kill between the two costs
        # a block and never leaves rows of fill values.
        self._file.attrs.modify("rows", np.int64(stop))
        self._file.flush()
        # One statement: a Ctrl-C falls before it or after it, and the same rows are written again in place.
        self._rows, self._buffer = stop, []


def fill_hdf5(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write columns to ``path`` directly; ``write_columns`` makes sure that the file is complete."""
    rows = len(next(iter(columns.values())))
    with _create_file(path, tuple(columns), metadata, overwrite=False) as file:
        for name, values in columns.items():
            file[name].resize((rows,))
            file[name][:] = values
        file.attrs.modify("rows", np.int64(rows))


def describe_recording(path: str | Path, metadata: Mapping[str, MetadataValue]) -> None:
    """Add metadata to a finished recording, as an analysis found them. Raises CallerError if the file refuses."""
    import h5py

    try:
        with h5py.File(path, "r+") as file:
            _write_metadata(file, checked_metadata(metadata))
    except OSError as problem:
        raise CallerError(f"cannot add to recording {path}: {_first_line(problem)}") from None


def read_hdf5_columns(path: Path) -> tuple[dict[str, FloatArray], dict[str, MetadataValue]]:
    """Return columns and metadata; of a file cut off in a run, its complete rows and ``ended`` "cut off".

    Raises RecordingError if the file is missing, damaged, still being written, or not a musclewire recording.
    """
    with _open_file(path) as file, _damage_reported(path):
        _check_format(file, path)
        names = [name for name in str(file.attrs.get("columns", "")).split(",") if name] or sorted(file)
        columns = {name: _values(file, name, path) for name in names if name in COLUMNS}
        metadata = {key: _from_attribute(file.attrs[key]) for key in file.attrs if key not in RESERVED}
        rows = min([int(file.attrs.get("rows", 2**62)), *(len(values) for values in columns.values())])
    if metadata.get("ended") == "running":
        metadata["ended"] = "cut off"
    return {name: values[:rows] for name, values in columns.items()}, metadata


def _checked_names(columns: Sequence[str]) -> tuple[str, ...]:
    names = tuple(known_column(name).name for name in columns)
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise CallerError(f"column '{repeated[0]}' is given twice; name each column once")
    if "time_s" not in names and not needs_no_clock(names):
        raise CallerError("a recording needs the column time_s; add it to columns")
    return names


def _checked_row(row: Mapping[str, float], names: tuple[str, ...]) -> list[float]:
    if len(row) != len(names):
        for name in row:
            if name not in names:
                raise CallerError(
                    f"a row gives '{name}', which this recording does not keep{nearest_hint(name, names)}"
                )
    try:
        return [float(row[name]) for name in names]
    except KeyError as missing:
        raise CallerError(f"a row lacks {missing}; every row gives {', '.join(names)}") from None
    except (TypeError, ValueError):
        wrong = next(name for name in names if not _is_number(row[name]))
        raise CallerError(f"a row gives {wrong} = {row[wrong]!r}; give a number") from None


def _is_number(value: object) -> bool:
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return True


def _create_file(path: Path, names: Sequence[str], metadata: Mapping[str, MetadataValue], overwrite: bool) -> Any:
    import h5py

    try:
        file = h5py.File(path, "w" if overwrite else "x")
    except FileExistsError:
        raise CallerError(
            f"{path}: the file exists; give another name, or allow replacing it (--overwrite, overwrite=True)"
        ) from None
    except OSError as problem:
        reason = _first_line(problem)
        raise CallerError(f"{path}: cannot be written: {reason}; check the folder") from None
    for name in names:
        # A row that never arrived is NaN, not a plausible zero.
        dataset = file.create_dataset(name, (0,), dtype="f8", maxshape=(None,), chunks=(_CHUNK_ROWS,), fillvalue=np.nan)
        dataset.attrs["unit"] = COLUMNS[name].unit
    file.attrs["format"] = FORMAT
    file.attrs["format_version"] = FORMAT_VERSION
    file.attrs["columns"] = ",".join(names)
    file.attrs.create("rows", 0, dtype=np.int64)
    _write_metadata(file, metadata)
    return file


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
        if "signature not found" in str(problem):
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


def _one_line(text: str) -> str:
    # An exception's message may hold anything; HDF5 keeps neither NUL nor half a surrogate pair.
    return " ".join(text.replace("\0", " ").encode("utf-8", "replace").decode("utf-8").split())


def _first_line(problem: BaseException) -> str:
    return (str(problem).splitlines() or [type(problem).__name__])[0].strip()
