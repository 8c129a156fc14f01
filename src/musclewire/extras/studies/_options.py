"""Options of the commands that run studies, and what they say when they are interrupted."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from musclewire.app import StoppedCommand, option

SCHEDULER = option(
    "--scheduler", help="A Dask cluster's address, as 'tcp://host:8786'; by default this machine's cores."
)
RUNS_PER_CHUNK = option("--runs-per-chunk", help="Runs evaluated together and kept as one file.", min=1, max=100_000)
RETRIES = option("--retries", help="How often a chunk is begun again whose worker has died.", min=0, max=100_000)
PLAN = option("--plan", help="Check the study, say what it would run, and exit.")


@contextmanager
def resumable(folder: Path) -> Iterator[None]:
    """Say to whoever interrupts a study how to continue it."""
    try:
        yield
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 1
        raise StoppedCommand(code, f"finished runs are kept in {folder}, and the same command continues") from None
