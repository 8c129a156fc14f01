"""Bytes appended to an open file, and brought to the disk once a second by a thread; also as a process of its own.

As a program it appends what comes from its standard input to its standard output, which is a file. It needs nothing but
the standard library, so that it starts in some hundredths of a second.
"""

from __future__ import annotations

import os
import sys
import threading

__all__ = ["MAX_CLOSING_S", "READY", "StalledError", "SyncedFile"]

# A power cut costs no more [s] than this and what one fsync takes. Once a second is what an SD card bears.
SYNCED_EVERY_S = 1.0
MAX_CLOSING_S = 60.0
READ_BYTES = 1 << 16
# What the process says on its standard error once it waits for bytes; anything after it is an error.
READY = b"ready\n"


class StalledError(OSError):
    """A disk does nothing; whoever writes to it may still do so at any time."""

    def __init__(self) -> None:
        """Say for how long."""
        super().__init__(f"the disk has accepted nothing for {MAX_CLOSING_S:g} s")


class SyncedFile:
    """An open file that only grows. What was appended survives the death of the process, after an fsync a power cut."""

    def __init__(self, descriptor: int) -> None:
        """Take a file opened for appending, by its descriptor; it stays open when this is closed."""
        self._descriptor = descriptor
        self._changed, self._ending = False, threading.Event()
        self._failure: OSError | None = None
        self._syncer = threading.Thread(target=self._sync_until_the_end, name="musclewire fsync", daemon=True)
        self._syncer.start()

    def append(self, data: bytes) -> None:
        """Append bytes, all of them. Raises OSError if the disk takes no more, or did not take what came before."""
        if self._failure is not None:
            raise self._failure
        rest = memoryview(data)
        while len(rest):
            rest = rest[os.write(self._descriptor, rest) :]
        self._changed = True

    def close(self) -> None:
        """Wait until everything is on the disk. Raises OSError if it is not, or the disk does nothing for a minute."""
        self._ending.set()
        self._syncer.join(MAX_CLOSING_S)
        if self._syncer.is_alive():
            raise StalledError
        if self._failure is not None:
            raise self._failure

    def _sync_until_the_end(self) -> None:
        # A thread of its own: some disks take a second for an fsync, and rows must not wait for it.
        try:
            while not self._ending.wait(SYNCED_EVERY_S):
                self._sync()
            self._sync()
        except OSError as problem:
            self._failure = problem

    def _sync(self) -> None:
        if self._changed:
            self._changed = False
            os.fsync(self._descriptor)


def append_input(source: int, target: int) -> None:
    """Say that this is ready, then append what comes from one descriptor to the file behind another, to its end."""
    file = SyncedFile(target)
    os.write(2, READY)
    while data := os.read(source, READ_BYTES):
        file.append(data)
    file.close()


def main() -> int:
    """Append at ordinary priority and on any core, even if the host has reserved a core for itself."""
    if sys.platform == "linux":
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        append_input(0, 1)
    except OSError as problem:
        print(problem.strerror or problem, file=sys.stderr, flush=True)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
