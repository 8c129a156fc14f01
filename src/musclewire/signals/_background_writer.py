"""A run's rows on their way to its journal: the loop keeps them in memory, a thread takes them from there.

In loops too fast to share their core with a disk another process writes. Neither costs the loop more than a copy of its
numbers; a disk that stalls costs memory and no time. If the other process is killed, the thread writes itself, from the
first row that is not in the file.
"""

from __future__ import annotations

import contextlib
import inspect
import subprocess
import sys
import threading
from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

import numpy as np

from musclewire.signals._metadata import MetadataValue, checked_metadata, one_line
from musclewire.signals._open_journal import OpenJournal
from musclewire.signals._synced_file import MAX_CLOSING_S, READY, StalledError, SyncedFile

__all__ = ["BackgroundWriter"]

# Rows are taken this often [s]: with what a busy machine adds, none that is older than 0.1 s is lost by a kill.
TAKEN_EVERY_S = 0.02
# The largest pipe that Linux allows ordinary users: at 1 kHz and 15 columns it bridges stalls of eight seconds, in
# which a killed host still loses no more.
PIPE_BYTES = 1 << 20
APPENDING = Path(str(inspect.getsourcefile(SyncedFile)))


class BackgroundWriter:
    """Keeps the rows of a run in ``values``, where they are added, and brings them to the disk.

    ``failure`` is the error that ended this, None while all is well.
    """

    def __init__(
        self,
        path: str | Path,
        columns: Sequence[str],
        metadata: Mapping[str, MetadataValue],
        overwrite: bool = False,
        apart: bool = False,
    ) -> None:
        """Create the journal; with ``apart`` another process appends to it. Raises CallerError if it cannot be."""
        self.path, self.values = Path(path), array("d")
        self._columns, self._taken = tuple(columns), 0
        self._journal = OpenJournal(self.path, columns, checked_metadata(metadata), overwrite)
        self._target: SyncedFile | AppendingProcess = (
            AppendingProcess(self._journal.descriptor) if apart else SyncedFile(self._journal.descriptor)
        )
        self.failure: OSError | None = None
        self._finishing, self._rows_left = False, 0
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._take_until_the_end, name="musclewire recording", daemon=True)
        self._thread.start()

    def close(self, ended: str, metadata: Mapping[str, MetadataValue]) -> None:
        """Write the rest, and plain HDF5 in place of the journal.

        Raises OSError if rows could not be written (then call ``leave``), RecordingNotWrittenError if all are in the
        journal and HDF5 could not be made of it.
        """
        self._ending.set()
        self._thread.join(MAX_CLOSING_S)
        if self._thread.is_alive():
            raise StalledError
        if self.failure is not None:
            raise self.failure
        self._finishing, self._rows_left = True, len(self.values) // len(self._columns)
        table = np.frombuffer(self.values, dtype=np.float64).reshape(-1, len(self._columns))
        columns = {name: table[:, place] for place, name in enumerate(self._columns)}
        self._journal.finish(columns, checked_metadata(metadata), one_line(ended))

    def leave(self, ended: str) -> tuple[Path, int]:
        """Leave the journal as the recording, after ``close`` failed. Return it and how many rows it surely has."""
        if not self._finishing and not self._thread.is_alive() and not isinstance(self.failure, StalledError):
            self._rows_left = self._journal.leave(one_line(ended))
        return self._journal.journal, self._rows_left

    def _take_until_the_end(self) -> None:
        try:
            while not self._ending.wait(TAKEN_EVERY_S):
                self._take()
            self._take()
            self._close_target()
        except OSError as problem:
            with contextlib.suppress(OSError):
                self._target.close()
            self.failure = problem

    def _take(self) -> None:
        """Append what waits; a row that the loop adds meanwhile is there whole or not at all, and waits on."""
        rows = len(self.values) // len(self._columns)
        try:
            while self._taken < rows:
                record = self._journal.next_record(self.values, self._taken)
                self._taken = self._journal.rows_noted
                self._target.append(record)
        except BrokenPipeError:
            self._go_on_without_process()

    def _close_target(self) -> None:
        try:
            self._target.close()
        except BrokenPipeError:
            self._go_on_without_process()
            self._target.close()

    def _go_on_without_process(self) -> None:
        self._taken = self._journal.cut_to_whole_records()
        self._target = SyncedFile(self._journal.descriptor)
        self._take()


class AppendingProcess:
    """A process that appends to a file what comes through a pipe, and survives the death of this one."""

    def __init__(self, descriptor: int) -> None:
        """Start it, and wait until it reads. It shares the open file, and with it the lock."""
        self._process = subprocess.Popen(
            # Isolated: nothing of the user's folder or environment takes the place of a module.
            [sys.executable, "-I", "-S", str(APPENDING)],
            stdin=subprocess.PIPE,
            stdout=descriptor,
            stderr=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C is for the host, which then closes the file
        )
        widen_pipe(self._input)
        assert self._process.stderr is not None
        # What is in the pipe before it reads would be lost if both were killed.
        self._ready = self._process.stderr.readline() == READY
        if not self._ready:
            self._process.kill()

    @property
    def _input(self) -> IO[bytes]:
        assert self._process.stdin is not None
        return self._process.stdin

    def append(self, data: bytes) -> None:
        """Send a record. Raises BrokenPipeError if the process was killed, another OSError if its disk failed."""
        try:
            self._input.write(data)
            self._input.flush()
        except BrokenPipeError:
            self._raise_why_it_ended()

    def close(self) -> None:
        """Wait until it has written all. Raises as ``append``, and StalledError if it takes too long."""
        if self._input.closed:
            return
        with contextlib.suppress(BrokenPipeError):
            self._input.close()
        try:
            code = self._process.wait(MAX_CLOSING_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._close_pipes()
            raise StalledError from None
        if code != 0:
            self._raise_why_it_ended()
        self._close_pipes()

    def _raise_why_it_ended(self) -> None:
        code = self._process.wait(MAX_CLOSING_S)
        assert self._process.stderr is not None
        said = self._process.stderr.read().decode("utf-8", "replace").strip().splitlines()
        self._close_pipes()
        if code < 0 or not said or not self._ready:
            raise BrokenPipeError("the process that writes has ended")
        raise OSError(said[-1])

    def _close_pipes(self) -> None:
        for pipe in (self._process.stdin, self._process.stderr):
            assert pipe is not None
            with contextlib.suppress(OSError):
                pipe.close()


def widen_pipe(pipe: IO[bytes]) -> None:
    """Enlarge a pipe on Linux, so that it holds the rows that arrive while a disk stalls."""
    if sys.platform == "linux":
        import fcntl

        with contextlib.suppress(OSError):
            fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
