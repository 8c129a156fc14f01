"""Keeps the rows of a run in memory and, on request, on disk as they come."""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from math import nan
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from musclewire.errors import MusclewireError, RecordingNotWrittenError
from musclewire.signals.hdf5 import RecordingWriter
from musclewire.signals.hdf5_process import WriterProcess
from musclewire.signals.recording import MetadataValue, Recording

__all__ = ["Recorder", "cause_of"]


def cause_of(error: BaseException | None) -> str:
    """Return the one line that a recording says about how its run ended."""
    if error is None:
        return "done"
    if isinstance(error, (KeyboardInterrupt, SystemExit)):
        return "interrupted"
    return f"{type(error).__name__}: {error}".splitlines()[0]


# Files HDF5 has lost hold of: closing one, or letting it be collected, fails again and may crash the process.
_NEVER_LET_GO: list[object] = []


def first_line(problem: BaseException) -> str:
    """Return the first line of what an error says."""
    return (str(problem).splitlines() or [type(problem).__name__])[0]


def rescued(recording: Recording, name: str) -> Path | None:
    """Save a recording whose own file failed into the temporary folder; None where that does not work either."""
    place = Path(tempfile.gettempdir()) / f"{name}-rescued-{datetime.now(UTC):%Y%m%dT%H%M%S}.csv"
    try:
        recording.save(place)
    except (OSError, RuntimeError, MusclewireError):
        return None
    return place


class Recorder:
    """Collects rows; with a path every block also goes to disk, where it survives whatever happens next."""

    def __init__(
        self,
        columns: Sequence[str],
        metadata: Mapping[str, MetadataValue],
        path: str | Path | None = None,
        *,
        overwrite: bool = False,
        block_rows: int = 20,
        apart_period_s: float | None = None,
    ) -> None:
        """Start an empty recording; ``block_rows`` rows go to disk together.

        With ``apart_period_s``, the sample period of a loop too fast to wait for a disk, another process writes.
        Raises CallerError where ``path`` exists and may not be replaced.
        """
        self._columns = tuple(columns)
        start_time = datetime.now(UTC).isoformat(timespec="seconds")
        self._metadata = {**metadata, "software_version": version("musclewire"), "start_time": start_time}
        # Plain numbers in one block: a million rows make no objects for the garbage collector to walk through.
        self._values = array("d")
        self._writer: RecordingWriter | WriterProcess | None = None
        if path is not None and apart_period_s is not None:
            self._writer = WriterProcess(path, columns, self._metadata, block_rows, overwrite, apart_period_s)
        elif path is not None:
            self._writer = RecordingWriter(path, columns, self._metadata, block_rows, overwrite)
        self._ended = "running"
        self._lost: Path | None = None

    def append(self, row: Mapping[str, float | None]) -> None:
        """Keep one row; it gives every column, None where an instrument gave nothing."""
        kept = [nan if (value := row[name]) is None else value for name in self._columns]
        self._values.fromlist(kept)
        if self._writer is None:
            return
        try:
            self._writer.append_values(kept)
        except (OSError, RuntimeError) as problem:
            raise self._lose_file(problem) from None

    def describe(self, metadata: Mapping[str, MetadataValue]) -> None:
        """Add what is known only at the end; it stands in the file once that is closed."""
        self._metadata.update(metadata)

    def __len__(self) -> int:
        """Return the number of rows so far."""
        return len(self._values) // len(self._columns)

    def recording(self) -> Recording:
        """Return what has been recorded so far."""
        table = np.array(self._values, dtype=np.float64).reshape(len(self), len(self._columns))
        columns = {name: table[:, place] for place, name in enumerate(self._columns)}
        return Recording(columns, {**self._metadata, "ended": self._ended})

    def __enter__(self) -> Self:
        """Return the recorder itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write what is left and say why the run ended; an exception takes the partial recording along."""
        self._ended = cause_of(error)
        problem = self._close_file()
        if error is None and problem is not None:
            error = problem
            self._take_along(error)
            raise error
        if error is not None:
            self._take_along(error)

    def _close_file(self) -> RecordingNotWrittenError | None:
        if self._writer is None:
            return None
        try:
            self._writer.close(self._ended, self._metadata)
        except (OSError, RuntimeError, ValueError) as problem:
            return self._lose_file(problem)
        return None

    def _take_along(self, error: BaseException) -> None:
        """Put the recording on an exception, with a note that says where it is."""
        recording = self.recording()
        error.recording = recording  # type: ignore[attr-defined]
        where = f" and in {self._writer.path}" if self._writer else ""
        if self._lost is not None:
            # Only now: by the time a recorder ends, the rig is safe, and a slow disk cannot keep a wire hot.
            where = f" and in {saved}" if (saved := rescued(recording, self._lost.stem)) else ""
        error.add_note(f"{len(self)} samples were recorded; they are in error.recording{where}")

    def _lose_file(self, problem: Exception) -> RecordingNotWrittenError:
        """Give up a file that cannot be written any more and return the error that says so."""
        path = self._writer.path if self._writer else Path("recording.h5")
        _NEVER_LET_GO.append(self._writer)
        self._writer, self._lost = None, path
        return RecordingNotWrittenError(f"cannot write {path}: {first_line(problem)}")
