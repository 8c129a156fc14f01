"""A recording's file written by another process, for loops too fast to wait for a disk.

A block of rows takes HDF5 longer to write than a period of 1 ms lasts, and a busy disk longer still. So rows go through
a pipe to a process that writes them. It survives if the host is killed, and writes the rows that were sent before. A
thread fills the pipe: to the loop a row costs a copy of its numbers, and a disk that stalls costs memory and no time.
"""

from __future__ import annotations

import contextlib
import json
import os
import struct
import subprocess
import sys
import threading
from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

from musclewire.errors import CallerError, MusclewireError
from musclewire.signals.hdf5 import RecordingWriter
from musclewire.signals.metadata import MetadataValue, checked_metadata

__all__ = ["WriterProcess"]

# The head of a message: its kind, and how many bytes follow.
HEAD = struct.Struct("<BI")
START, ROWS, CLOSE = 1, 2, 3
# Rows are sent together this often [s]: a killed host loses no more, and the other process is not woken for each.
SENT_EVERY_S = 0.1
# The largest pipe that Linux allows ordinary users: at 1 kHz and 15 columns it bridges stalls of eight seconds, in
# which a killed host still loses no more.
PIPE_BYTES = 1 << 20
READY = b"ready\n"
MAX_CLOSING_S = 60.0


class WriterProcess:
    """Has the methods of ``RecordingWriter`` that a recorder calls, and sends the rows to another process."""

    def __init__(
        self,
        path: str | Path,
        columns: Sequence[str],
        metadata: Mapping[str, MetadataValue],
        block_rows: int,
        overwrite: bool,
    ) -> None:
        """Start the process and wait until it has created the file. Raises CallerError as ``RecordingWriter`` does."""
        self._path = Path(path)
        # Appended to by the loop, emptied by the thread; never replaced, so that neither needs a lock.
        self._waiting = array("d")
        self._failure = ""
        self._closed = False
        # A session of its own: Ctrl-C is for the host, which then closes the file.
        self._process = subprocess.Popen(
            # -P: no file in the folder where the user works takes the place of a module.
            [sys.executable, "-P", "-m", "musclewire.signals.hdf5_process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        widen_pipe(self._input)
        start = {
            "path": str(self._path.absolute()),
            "columns": list(columns),
            "metadata": dict(checked_metadata(metadata)),
            "block_rows": block_rows,
            "overwrite": overwrite,
        }
        self._send(START, json.dumps(start).encode())
        assert self._process.stdout is not None
        if self._process.stdout.readline() != READY:
            raise CallerError(self._failure_message())
        self._ending = threading.Event()
        self._sender = threading.Thread(target=self._send_until_the_end, name="musclewire recording", daemon=True)
        self._sender.start()

    @property
    def path(self) -> Path:
        """The file being written."""
        return self._path

    @property
    def _input(self) -> IO[bytes]:
        assert self._process.stdin is not None
        return self._process.stdin

    def append_values(self, values: list[float]) -> None:
        """Add one row; rows are sent every tenth of a second. Raises OSError if the process has ended."""
        if self._failure:
            raise OSError(self._failure)
        self._waiting.fromlist(values)

    def close(self, ended: str, metadata: Mapping[str, MetadataValue]) -> None:
        """Send the remaining rows, and wait until the file is closed. Raises OSError if that fails."""
        if self._closed:
            return
        self._closed = True
        self._ending.set()
        self._sender.join(MAX_CLOSING_S)
        if self._failure:
            raise OSError(self._failure)
        if self._sender.is_alive():
            raise OSError(self._stalled())
        self._send(CLOSE, json.dumps({"ended": ended, "metadata": dict(checked_metadata(metadata))}).encode())
        self._input.close()
        try:
            code = self._process.wait(MAX_CLOSING_S)
        except subprocess.TimeoutExpired:
            raise OSError(self._stalled()) from None
        if code != 0:
            raise OSError(self._failure_message())
        self._close_pipes()

    def _close_pipes(self) -> None:
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            assert pipe is not None
            # Rows that could not be sent, since the process has ended, are lost here; the recorder still has them.
            with contextlib.suppress(OSError):
                pipe.close()

    def _stalled(self) -> str:
        return f"{self._path}: the disk has accepted nothing for {MAX_CLOSING_S:g} s"

    def _send_until_the_end(self) -> None:
        """Send what waits every tenth of a second, and the rest at the end."""
        try:
            while not self._ending.wait(SENT_EVERY_S):
                self._send_rows()
            self._send_rows()
        except OSError as problem:
            self._failure = str(problem)

    def _send_rows(self) -> None:
        """Send what waits; a row that the loop appends meanwhile is there whole or not at all, and waits on."""
        rows = self._waiting[:]
        if rows:
            del self._waiting[: len(rows)]
            self._send(ROWS, rows.tobytes())

    def _send(self, kind: int, body: bytes) -> None:
        try:
            self._input.write(HEAD.pack(kind, len(body)) + body)
            self._input.flush()
        except BrokenPipeError:
            raise OSError(self._failure_message()) from None

    def _failure_message(self) -> str:
        """Return the last line that the process printed before it ended."""
        self._process.wait(MAX_CLOSING_S)
        assert self._process.stderr is not None
        said = self._process.stderr.read().decode("utf-8", "replace").strip().splitlines()
        self._close_pipes()
        return said[-1] if said else f"{self._path}: the process that writes it has ended"


def widen_pipe(pipe: IO[bytes]) -> None:
    """Enlarge a pipe on Linux, so that it holds the rows that arrive while a disk stalls."""
    if sys.platform == "linux":
        import fcntl

        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, PIPE_BYTES)


def message(source: IO[bytes]) -> tuple[int, bytes] | None:
    """Return the next whole message; None if the host has ended."""
    head = source.read(HEAD.size)
    if len(head) < HEAD.size:
        return None
    kind, size = HEAD.unpack(head)
    body = source.read(size)
    return (kind, body) if len(body) == size else None


def write_messages(source: IO[bytes]) -> None:
    """Write a file from messages; if the host ends without closing it, it stays marked as cut off."""
    first = message(source)
    if first is None:
        return
    start = json.loads(first[1])
    columns = start["columns"]
    writer = RecordingWriter(start["path"], columns, start["metadata"], start["block_rows"], start["overwrite"])
    os.write(1, READY)
    while (got := message(source)) is not None:
        kind, body = got
        if kind == CLOSE:
            writer.close(**json.loads(body))
            return
        values = array("d")
        values.frombytes(body)
        for row in range(0, len(values), len(columns)):
            writer.append_values(values[row : row + len(columns)].tolist())
    writer.close_unfinished()


def main() -> int:
    """Write the file at ordinary priority and on any core, even if the host has reserved a core for itself."""
    if sys.platform == "linux":
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        write_messages(sys.stdin.buffer)
    except (OSError, RuntimeError, MusclewireError) as problem:
        print(str(problem).splitlines()[0], file=sys.stderr, flush=True)
        # HDF5 may crash a process that closes a file it could not write: end without closing it.
        os._exit(1)
    return 0


if __name__ == "__main__":
    sys.exit(main())
