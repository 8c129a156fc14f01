"""Locks on files that end with the processes that hold them, so that who reads knows whether somebody still writes."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def lock(descriptor: int) -> None:
    """Lock an open file for as long as it is open in any process. Does nothing where the system has no such locks."""
    if sys.platform != "win32":
        import fcntl

        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        except OSError:  # a network drive without locks: a run that goes on then reads as one that was cut off
            return


def locked_by_another(path: Path) -> bool:
    """Return whether somebody holds the lock of a file, and False if that cannot be known. Raises OSError."""
    if sys.platform == "win32":
        return False
    import fcntl

    descriptor = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(descriptor)
    return False
