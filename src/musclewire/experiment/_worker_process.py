"""Processes of our own on the cores of this machine: a module of ours that answers on its standard output.

No process runs the caller's own script, so that nothing needs an ``if __name__`` around it.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

__all__ = ["cores", "end_worker", "start_worker"]

# A worker computes on one core; the numerical libraries' own threads would only compete.
ONE_THREAD = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def start_worker(module: str) -> subprocess.Popen[bytes]:
    """Return a new process that runs a module with this process's import path, with pipes to and from it.

    The current folder is not on that path, unless this process has it by name: no file of the folder where the user
    works takes the place of a module. A study's own kind of run is found by the folder of its file, which
    ``studies.plan`` adds.
    """
    import_path = [str(Path(entry).absolute()) for entry in sys.path if entry not in ("", os.curdir)]
    return subprocess.Popen(
        [sys.executable, "-P", "-m", module],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, **ONE_THREAD, "PYTHONPATH": os.pathsep.join(import_path)},
        start_new_session=True,  # Ctrl-C is for the parent, which ends its workers itself
    )


def end_worker(process: subprocess.Popen[bytes]) -> None:
    """End a process, whatever it does, and close its pipes."""
    process.kill()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            try:
                pipe.close()
            except OSError:
                continue  # what was still to be sent has nobody to read it
    process.wait()
