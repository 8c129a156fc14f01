"""A journal that is being written: created before the run, grown by it, and replaced by plain HDF5 at its end."""

from __future__ import annotations

import contextlib
import os
from array import array
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from pathlib import Path

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingNotWrittenError
from musclewire.signals._journal import BLOCK_BYTES, encoded_end, encoded_rows, encoded_start, journal_of
from musclewire.signals._locking import lock, locked_by_another
from musclewire.signals._metadata import MetadataValue
from musclewire.signals._whole_files import folder_to_disk, remove_parts
from musclewire.signals._writing import write_columns

__all__ = ["OpenJournal", "refuse_unfinished"]


def refuse_unfinished(path: str | Path, overwrite: bool) -> None:
    """Raise CallerError if a recording, or the journal of one that was cut off, would be replaced unasked."""
    replace = "give another name, or allow replacing it (--overwrite, overwrite=True)"
    if overwrite:
        return
    if Path(path).exists():
        raise CallerError(f"{path} exists: {replace}")
    if journal_of(path).exists():
        raise CallerError(
            f"{path}: {journal_of(path)} holds the rows of a run that goes on or was cut off: "
            f"'musclewire recover {path}' finishes it; else {replace}"
        )


class OpenJournal:
    """The journal of a run, locked as long as this process or the one that appends for it lives."""

    def __init__(
        self, path: Path, columns: Sequence[str], metadata: Mapping[str, MetadataValue], overwrite: bool
    ) -> None:
        """Create the file, on disk with its name. Raises CallerError if it cannot be, or would replace one unasked."""
        refuse_unfinished(path, overwrite)
        self.path, self.journal = path, journal_of(path)
        self._metadata = dict(metadata)
        self._row_bytes = 8 * len(columns)
        # Where each record ends and how many rows are there up to its end; the first is the beginning, without rows.
        self._record_ends, self._rows_at_end = array("q"), array("q")
        start = encoded_start(columns, metadata)
        try:
            self.descriptor = _created(self.journal)
            self._write_to_disk(start)
            folder_to_disk(self.journal)
            # Only now, when the new one has a place. There are no rows yet: the HDF5 file always is the newer one.
            path.unlink(missing_ok=True)
        except OSError as problem:
            raise CallerError(f"{path}: cannot be written: {problem.strerror or problem}; check the folder") from None
        self._noted(len(start), 0)

    @property
    def rows_noted(self) -> int:
        """Rows up to the end of the last record that was given out."""
        return self._rows_at_end[-1]

    def next_record(self, values: array[float], first_row: int) -> bytes:
        """Return a record of the rows from one on, as many as a block holds, and note where it will end."""
        width = self._row_bytes // 8
        start, step = first_row * width, max(1, BLOCK_BYTES // self._row_bytes) * width
        block = values[start : start + step]
        whole = block[: len(block) // width * width]
        record = encoded_rows(whole.tobytes())
        self._noted(len(record), len(whole) // width)
        return record

    def _noted(self, size: int, rows: int) -> None:
        self._record_ends.append(size + (self._record_ends[-1] if self._record_ends else 0))
        self._rows_at_end.append(rows + (self._rows_at_end[-1] if self._rows_at_end else 0))

    def cut_to_whole_records(self) -> int:
        """Cut a record that was torn off the file, and return how many rows are in it."""
        whole = bisect_right(self._record_ends, os.fstat(self.descriptor).st_size)
        del self._record_ends[whole:], self._rows_at_end[whole:]
        os.ftruncate(self.descriptor, self._record_ends[-1])
        return self._rows_at_end[-1]

    def finish(self, columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], ended: str) -> None:
        """Say how the run ended, write plain HDF5 of it in the journal's place, and remove the journal.

        Raises RecordingNotWrittenError if that fails; then the journal, which has all rows, is the recording.
        """
        try:
            self._write_to_disk(encoded_end(ended, metadata))
            replace_journal(self.path, columns, {**self._metadata, **metadata, "ended": ended})
        except (CallerError, OSError) as problem:
            why = str(problem) if isinstance(problem, CallerError) else f"cannot write {self.path}: {problem.strerror}"
            kept = f"every row is in {self.journal}: make room, then 'musclewire recover {self.path}'"
            raise RecordingNotWrittenError(f"{why}; {kept}") from None
        finally:
            os.close(self.descriptor)

    def _write_to_disk(self, data: bytes) -> None:
        rest = memoryview(data)
        while len(rest):
            rest = rest[os.write(self.descriptor, rest) :]
        os.fsync(self.descriptor)

    def leave(self, ended: str) -> int:
        """Leave the journal as the recording, with its end if the disk still takes that.

        Return how many rows are in it, 0 if that cannot be known; nothing is raised.
        """
        rows = 0
        with contextlib.suppress(OSError):
            rows = self.cut_to_whole_records()
            self._write_to_disk(encoded_end(ended, {}))
        with contextlib.suppress(OSError):
            os.close(self.descriptor)
        return rows


def replace_journal(path: Path, columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue]) -> None:
    """Write plain HDF5 whole, and remove the journal once it is on disk. Raises CallerError if that fails."""
    remove_parts(path)
    write_columns(columns, metadata, path)
    folder_to_disk(path)
    journal_of(path).unlink(missing_ok=True)


def _created(journal: Path) -> int:
    """Create and lock a journal in the place of one that nobody writes any more. Raises CallerError if one does."""
    if journal.exists():
        if locked_by_another(journal):
            raise CallerError(f"{journal}: is still being written by another process; wait until it ends")
        journal.unlink()
    descriptor = os.open(journal, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_APPEND | getattr(os, "O_BINARY", 0), 0o666)
    lock(descriptor)
    return descriptor
