"""What the command line shows: JSON on stdout, everything for people on stderr."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["console", "emit_json", "progress_bar", "say"]

Advance = Callable[..., None]


def console() -> Console:
    """Return the console for people: stderr, so that stdout stays for programs."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


def say(text: str) -> None:
    """Print one line for people."""
    print(text, file=sys.stderr)


def emit_json(document: Mapping[str, Any]) -> None:
    """Print exactly one JSON document on stdout; numbers that are not finite are a bug and raise."""
    json.dump(document, sys.stdout, indent=2, allow_nan=False, default=plain)
    sys.stdout.write("\n")


def plain(value: Any) -> Any:
    """Return a NumPy scalar or a path as what JSON knows."""
    return value.item() if hasattr(value, "item") else str(value)


@contextmanager
def progress_bar(task: str, total_s: float, quiet: bool = False) -> Iterator[Advance]:
    """Show a bar over simulated or real seconds; yields the function to call after each sample.

    On a pipe there is no bar, only the line that names the task.
    """
    if quiet:
        yield lambda *_: None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description:<34}"),
        BarColumn(bar_width=32),
        TextColumn("{task.completed:>6.0f}/{task.total:.0f} s of wire time"),
        TimeElapsedColumn(),
    )
    shown = console()
    if not shown.is_terminal:
        say(task)
        yield lambda *_: None
        return
    with Progress(*columns, console=shown, refresh_per_second=8) as progress:
        bar = progress.add_task(task, total=total_s)
        start: list[float] = []

        def advance(row: Mapping[str, float]) -> None:
            if not start:
                start.append(row["time_s"])
            progress.update(bar, completed=row["time_s"] - start[0])

        yield advance
        progress.update(bar, completed=total_s)
