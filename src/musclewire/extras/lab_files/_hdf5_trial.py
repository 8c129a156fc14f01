"""A trial reading of an HDF5 file in a process of its own.

Changed bytes in a file can send HDF5's own code round in circles or crash it, from which no exception of Python saves
the caller: of 3000 random changes to a small file with texts as attributes, some never come back. A process that is
tried first ends, and the caller refuses the file.
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path

from musclewire.errors import MusclewireError, RecordingError

__all__ = ["check_by_trial"]

# Reading names and attributes takes a second; a network drive may take some more.
MAX_TRIAL_S = 30.0

_CHILD = "import sys; from musclewire.extras.lab_files._hdf5_trial import run; run(sys.argv[1], sys.argv[2])"


def check_by_trial(path: Path, module: str) -> None:
    """Let another process call ``module.try_to_read(path)``; raise RecordingError if it crashes or does not end.

    What the other process refuses as we do is left to the caller, who will refuse it with the same words.
    """
    # -P, and no entry that means the current folder: no other file that lies there takes the place of a module.
    import_path = [str(Path(entry).absolute()) for entry in sys.path if entry not in ("", os.curdir)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(import_path)}
    command = [sys.executable, "-P", "-c", _CHILD, module, str(path)]
    quiet = subprocess.DEVNULL
    try:
        done = subprocess.run(
            command, env=environment, stdin=quiet, stdout=quiet, stderr=quiet, timeout=MAX_TRIAL_S, check=False
        )
    except subprocess.TimeoutExpired:
        raise RecordingError(f"{path}: is damaged, HDF5 does not come back from reading it; use another copy") from None
    if done.returncode < 0:
        raise RecordingError(f"{path}: is damaged, HDF5 crashes when it reads it; use another copy")


def run(module: str, path: str) -> None:
    """Try to read a file, in the other process; our own errors mean that it came back."""
    try:
        importlib.import_module(module).try_to_read(Path(path))
    except MusclewireError:
        return
