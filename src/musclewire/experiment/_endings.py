"""How a run ended, in words, and what is saved of a recording whose file was lost."""

from __future__ import annotations

import tempfile
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path

from musclewire.errors import MusclewireError
from musclewire.signals import Recording


@cache
def software_version() -> str:
    """Return the version that recordings state; asking for it takes as long as a run in compiled code."""
    return version("musclewire")


def cause_of(error: BaseException | None) -> str:
    """Return how a run ended, in one line for its recording."""
    if error is None:
        return "done"
    if isinstance(error, (KeyboardInterrupt, SystemExit)):
        return "interrupted"
    return f"{type(error).__name__}: {error}".splitlines()[0]


def first_line(problem: BaseException) -> str:
    """Return the first line of an error's message."""
    return (str(problem).splitlines() or [type(problem).__name__])[0]


def rescued(recording: Recording, name: str) -> Path | None:
    """Save a recording whose own file failed into the temporary folder; None if that fails too."""
    place = Path(tempfile.gettempdir()) / f"{name}-rescued-{datetime.now(UTC):%Y%m%dT%H%M%S}.csv"
    try:
        recording.save(place)
    except (OSError, RuntimeError, MusclewireError):
        return None
    return place
