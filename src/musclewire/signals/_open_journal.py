"""A journal that is being written: created before the run, grown by it, and replaced by plain HDF5 at its end.

All rows of the run stay in memory. A thread of their own takes them to the file, and one brings the file to the disk: a
loop that adds rows makes no call to the system, and a disk that stalls costs memory and no time.
"""

from __future__ import annotations

import contextlib
import os
import sys
from array import array
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from threading import Event, Thread

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingNotWrittenError, argument
from musclewire.signals._journal import BLOCK_BYTES, encoded_end, encoded_rows, encoded_start, journal_of
from musclewire.signals._locking import lock, locked_by_another
from musclewire.signals._metadata import MetadataValue, checked_metadata, one_line
from musclewire.signals._whole_files import folder_to_disk, remove_parts
from musclewire.signals._writing import write_columns

# Rows are taken this often [s]: with what a busy machine adds, none that is older than 0.1 s is lost by a kill.
TAKEN_EVERY_S = 0.02
# A power cut costs no more [s] than this and what one fsync takes. Once a second is what an SD card bears.
SYNCED_EVERY_S = 1.0
MAX_CLOSING_S = 60.0  # a busy disk needs seconds for the rest; one that takes no more must not hold up the run's end


def refuse_unfinished(path: str | Path, overwrite: bool) -> None:
    """Raise CallerError if a recording, or the journal of one that was cut off, would be replaced unasked."""
    replace = "give another name, or allow replacing it (" + argument("overwrite", True) + ")"
    if overwrite:
        return
    if Path(path).exists():
        raise CallerError(f"{path} exists: " + replace)
    if journal_of(path).exists():
        raise CallerError(
            f"{path}: {journal_of(path)} holds the rows of a run that goes on or was cut off: "
            f"'musclewire recover {path}' finishes it; else " + replace
        )


class OpenJournal:
    """The journal of a run, locked as long as this process lives."""

    def __init__(
        self,
        path: str | Path,
        columns: Sequence[str],
        metadata: Mapping[str, MetadataValue],
        overwrite: bool = False,
        in_background: bool = False,
    ) -> None:
        """Create the file, to which a thread may take rows. Raises CallerError if it cannot, or would replace one."""
        # What the end writes with is loaded before the wire is heated: nothing is slower on a machine that has no time.
        import h5py  # noqa: F401

        refuse_unfinished(path, overwrite)
        self.path, self.journal = Path(path), journal_of(path)
        self.values = array("d")  # the rows, one after the other, to which the run adds
        self.failure: OSError | None = None  # of a disk that takes no more
        self._columns, self._metadata = tuple(columns), checked_metadata(metadata)
        # Bytes of whole records in the file, and rows in them: changed together, in one statement.
        self._written = (0, 0)
        self._whole = False
        try:
            self._descriptor = _created(self.journal)
            self._append(encoded_start(columns, self._metadata), 0)
            os.fsync(self._descriptor)
            folder_to_disk(self.journal)
            # Only now, when the new one has a place. There are no rows yet: the HDF5 file always is the newer one.
            self.path.unlink(missing_ok=True)
        except OSError as problem:
            raise CallerError(f"{path}: cannot be written: {problem.strerror or problem}; check the folder") from None
        self._synced, self._ending, self._threads = self._written, Event(), list[Thread]()
        self._start(self._sync, SYNCED_EVERY_S)
        if in_background:
            self._start(self.write_rows, TAKEN_EVERY_S)

    @property
    def rows_written(self) -> int:
        """Rows that are in the file, where they survive a kill."""
        return self._written[1]

    def write_rows(self) -> None:
        """Write the rows that are not in the file yet. Raises OSError if the disk takes no more."""
        if self.failure is not None:
            raise self.failure
        width = len(self._columns)
        # A row that the loop adds meanwhile is there whole or not at all, and waits on.
        while missing := len(self.values) // width - self.rows_written:
            first, rows = self.rows_written, min(missing, max(1, BLOCK_BYTES // (8 * width)))
            self._append(encoded_rows(self.values[first * width : (first + rows) * width].tobytes()), rows)

    def close(self, ended: str, metadata: Mapping[str, MetadataValue]) -> None:
        """Write the rest and how the run ended, then plain HDF5 in the journal's place, and remove the journal.

        Raises OSError if rows could not be written, RecordingNotWrittenError if all are in the journal and HDF5 could
        not be made of it; then call ``leave``.
        """
        added = checked_metadata(metadata)
        self._end_threads()
        self.write_rows()
        self._whole = True
        table = np.frombuffer(self.values, dtype=np.float64).reshape(-1, len(self._columns))
        columns = {name: table[:, place] for place, name in enumerate(self._columns)}
        try:
            self._append(encoded_end(one_line(ended), added), 0)
            os.fsync(self._descriptor)
            replace_journal(self.path, columns, {**self._metadata, **added, "ended": one_line(ended)})
        except (CallerError, OSError) as problem:
            why = str(problem) if isinstance(problem, CallerError) else f"cannot write {self.path}: {problem.strerror}"
            kept = f"every row is in {self.journal}: make room, then 'musclewire recover {self.path}'"
            raise RecordingNotWrittenError(f"{why}; {kept}") from None
        finally:
            os.close(self._descriptor)

    def leave(self, ended: str) -> int:
        """Leave the journal as the recording after ``close`` failed; return its rows, 0 if not known. Never raises."""
        if self._whole:
            return self.rows_written
        if not self._ending.is_set():
            with contextlib.suppress(OSError):
                self._end_threads()
        if any(thread.is_alive() for thread in self._threads):
            return 0
        with contextlib.suppress(OSError):
            os.ftruncate(self._descriptor, self._written[0])  # a record that was torn
            self._append(encoded_end(one_line(ended), {}), 0)
            os.fsync(self._descriptor)
        with contextlib.suppress(OSError):
            os.close(self._descriptor)
        return self.rows_written

    def _append(self, record: bytes, rows: int) -> None:
        """Write a record after the whole ones: once more, if a Ctrl-C came before it was noted."""
        end, written = self._written
        os.lseek(self._descriptor, end, os.SEEK_SET)
        write_all(self._descriptor, record)
        self._written = (end + len(record), written + rows)

    def _sync(self) -> None:
        if self._synced != (written := self._written):
            os.fsync(self._descriptor)
            self._synced = written

    def _start(self, work: Callable[[], None], period_s: float) -> None:
        """Let a thread do some work again and again."""
        thread = Thread(target=self._repeat, args=(work, period_s), name="musclewire recording", daemon=True)
        thread.start()
        self._threads.append(thread)

    def _repeat(self, work: Callable[[], None], period_s: float) -> None:
        """Do some work again and again, and once more at the end."""
        _leave_the_loops_core()
        try:
            while not self._ending.wait(period_s):
                work()
            work()
        except OSError as problem:
            self.failure = problem

    def _end_threads(self) -> None:
        self._ending.set()
        for thread in self._threads:
            thread.join(MAX_CLOSING_S)
            if thread.is_alive():  # and may still write at any time
                raise OSError(f"the disk has accepted nothing for {MAX_CLOSING_S:g} s")


def write_all(descriptor: int, data: bytes) -> None:
    """Write all of the bytes. Raises OSError if the disk takes no more; a part of them may then be in the file."""
    rest = memoryview(data)
    while len(rest):
        rest = rest[os.write(descriptor, rest) :]


def _leave_the_loops_core() -> None:
    """Let this thread run on any core, even if the loop is pinned to one, which an fsync keeps busy for a while."""
    # At the loop's priority: it would wait for an interpreter lock that a thread of lower priority holds.
    if sys.platform == "linux":
        os.sched_setaffinity(0, range(os.cpu_count() or 1))


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
    descriptor = os.open(journal, os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    lock(descriptor)
    return descriptor
