"""What the command line shows: results on stdout (or one JSON document), progress and problems on stderr."""

from __future__ import annotations

import json
import logging
import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from typing import TYPE_CHECKING, Any, Literal

from musclewire.app._live_numbers import LiveNumbers
from musclewire.app._options import as_option
from musclewire.app._stopping import stop_if_asked
from musclewire.errors import Message, MusclewireError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

    from musclewire.rigs import GuardedRig

Advance = Callable[..., None]
OnStage = Callable[[str, int, int, float], None]
OnRuns = Callable[[int, int], None]
# Characters in a line that no terminal breaks: more than a row of any table has.
PIPE_WIDTH = 10_000


def console() -> Console:
    """Return the console for people: stderr, so that stdout stays for programs."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


def in_options(text: str) -> str:
    """Return a text with the options of the command line for the arguments that it advises."""
    return text.spelled(as_option) if isinstance(text, Message) else text


def say(text: str) -> None:
    """Print progress, a warning or an error: stderr."""
    print(in_options(text), file=sys.stderr)


def warn(warnings: Iterable[str]) -> list[str]:
    """Print warnings on stderr, a line each, and return them for a JSON document."""
    listed = list(warnings)
    for text in listed:
        say("warning: " + text)
    return listed


def show(text: str) -> None:
    """Print a result for people: stdout. With --json, :func:`emit_json` takes its place."""
    print(in_options(text))


def emit_json(document: Any) -> None:
    """Print exactly one JSON document on stdout; numbers that are not finite are a bug and raise."""
    if not isinstance(document, Mapping):
        from pydantic import TypeAdapter

        document = TypeAdapter(type(document)).dump_python(document, mode="json", by_alias=True)
    sys.stdout.write(json.dumps(document, indent=2, allow_nan=False, default=plain) + "\n")


def plain(value: Any) -> Any:
    """Return a NumPy scalar or a path as what JSON knows."""
    return value.item() if hasattr(value, "item") else str(value)


@dataclass(frozen=True)
class Result:
    """What a command found: the answer for programs, and the same in words for people."""

    answer: Any
    text: str
    holds: bool = True  # exit code 1 if it does not
    error: MusclewireError | None = None  # raised when the answer has been printed


class _Shown:
    """Whether the command that runs shows its progress: not with --json."""

    progress = True


def run_command(command: Callable[..., Result | None], with_json: bool, /, **arguments: Any) -> None:
    """Run a command and print its result, if it returns one and has not printed it itself."""
    _Shown.progress = not with_json
    try:
        with compilation_shown():
            found = command(**arguments)
        if found is None:
            return
        emit_json(found.answer) if with_json else show(found.text)
    finally:
        _Shown.progress = True
    if found.error is not None:
        raise found.error
    if not found.holds:
        raise SystemExit(1)


class _AsProgress(logging.Handler):
    """Shows what is logged, as progress."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print it on stderr, unless only the answer is wanted."""
        tell(record.getMessage())


@contextmanager
def compilation_shown() -> Iterator[None]:
    """Say that kernels are compiled when that begins, and at a good end for how long. Numba is not loaded for it."""
    logger, handler = logging.getLogger("musclewire.compiled"), _AsProgress()
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    before_s, began_s = seconds_compiling(), time.perf_counter()
    try:
        yield
    finally:
        logger.removeHandler(handler)
    if (compiling_s := seconds_compiling() - before_s) > 0.0:
        tell(f"compiling took {compiling_s:.1f} s of {time.perf_counter() - began_s:.1f} s")


def seconds_compiling() -> float:
    """Return how long this process has compiled; 0 where nothing compiled has been loaded."""
    compiled = sys.modules.get("musclewire.compiled")
    return 0.0 if compiled is None else float(compiled.COMPILATION.total_s)


def tell(text: str) -> None:
    """Print what happens meanwhile, unless only the answer is wanted: stderr."""
    if _Shown.progress:
        say(text)


def table(head: Sequence[str], rows: Iterable[Sequence[object]], *, left: Collection[int] = (0,)) -> str:
    """Return a table without lines, whose columns stand to the right but for those that are named.

    In a terminal long cells of the last column are folded; elsewhere, and where words do not fit, a row is one line.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    drawn = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), show_header=any(head))
    for number, name in enumerate(head):
        side: Literal["left", "right"] = "left" if number in left else "right"
        drawn.add_column(Text(name), justify=side, no_wrap=number < len(head) - 1, overflow="fold")
    for row in rows:
        drawn.add_row(*(Text(in_options(str(cell))) for cell in row))
    terminal, text = sys.stdout.isatty(), StringIO()
    shown = Console(file=text, force_terminal=terminal)
    least = shown.measure(drawn, options=shown.options.update(max_width=PIPE_WIDTH)).minimum
    if not terminal or least > shown.width:
        shown.width = PIPE_WIDTH
    shown.print(drawn)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


@contextmanager
def progress_bar(task: str, total_s: float | None, rig: GuardedRig | None = None) -> Iterator[Advance]:
    """Show a bar over simulated or real seconds, and a rig's numbers below it; yields what to call after each sample.

    Without a total only the numbers are shown. Nothing is shown before the first sample, so that wrong input stays one
    line. On a pipe there is no bar, only the line that names the task.
    """
    if not _Shown.progress:
        yield stop_if_asked
        return
    bar = ProgressBar(task, total_s, rig)
    try:
        yield bar.advance
    finally:
        bar.stop()


@contextmanager
def step_bar() -> Iterator[OnStage]:
    """Show a bar, or lines on a pipe; yields what takes a search's stage, steps done, total steps and best cost."""
    shown = console()
    if not _Shown.progress:
        yield lambda *_: None
    elif not shown.is_terminal:
        yield lambda stage, done, total, cost: say(f"{stage}: {done} of {total} descents, sum of squares {cost:.4g}")
    else:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

        text = TextColumn("{task.description:<46}")
        columns = (text, BarColumn(bar_width=32), MofNCompleteColumn(), TimeElapsedColumn())
        with Progress(*columns, console=shown, refresh_per_second=4, transient=True) as progress:
            task = progress.add_task("global search, descents", total=None)
            yield lambda stage, done, total, cost: progress.update(
                task, description=f"{stage}, sum of squares {cost:.4g}", completed=done, total=total
            )


@contextmanager
def run_bar(unit: str) -> Iterator[OnRuns]:
    """Show a bar, on a pipe lines of every tenth run; yields what takes the number of finished runs and of all."""
    shown = console()
    if not _Shown.progress:
        yield lambda _done, _total: None
    elif not shown.is_terminal:
        tenths: set[int] = set()

        def line(done: int, total: int) -> None:
            tenth = 10 * done // max(total, 1)
            if tenth not in tenths:
                tenths.add(tenth)
                say(f"{done} of {total} {unit}")

        yield line
    else:
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        columns = (TextColumn(unit), BarColumn(bar_width=40), MofNCompleteColumn(), TimeElapsedColumn(),
                   TextColumn("left"), TimeRemainingColumn())  # fmt: skip
        with Progress(*columns, console=shown, refresh_per_second=4) as progress:
            task = progress.add_task(unit, total=None)
            yield lambda done, total: progress.update(task, completed=done, total=total)


class ProgressBar:
    """A progress bar that appears with its first sample."""

    def __init__(self, task: str, total_s: float | None, rig: GuardedRig | None) -> None:
        """Remember the task, how many seconds it has, and whose numbers are shown."""
        self._task = task
        self._numbers = None if rig is None else LiveNumbers(rig)
        self._last_s: float | None = None
        self._before_s = 0.0
        # Built before the first sample: importing and drawing for the first time takes a good part of a second on a
        # busy machine, and a board whose next command is so late switches the heater off.
        self._progress = progress_for(task, total_s, self._numbers)

    def advance(self, row: Mapping[str, float]) -> None:
        """Move the bar to a sample's time; a signal that waited for the sample stops the run here."""
        stop_if_asked()
        if self._last_s is None:
            if self._progress is None:
                say(self._task)
            else:
                self._progress.start()
        elif row["time_s"] < self._last_s:  # a new recording, whose clock begins again
            self._before_s += self._last_s
        self._last_s = row["time_s"]
        if self._numbers is not None:
            self._numbers.keep_row(row)
        if self._progress is not None:
            self._progress.update(self._progress.task_ids[0], completed=self._before_s + self._last_s)

    def stop(self) -> None:
        """Leave the bar as it stands."""
        if self._progress is not None:
            self._progress.stop()


def progress_for(task: str, total_s: float | None, numbers: LiveNumbers | None) -> Progress | None:
    """Return a bar that has been drawn once into nothing, so that its first sample need not wait; None on a pipe."""
    shown = console()
    if not shown.is_terminal:
        return None
    from rich.console import Console
    from rich.progress import BarColumn, ProgressColumn, TextColumn, TimeElapsedColumn

    from musclewire.app._numbers_below import ProgressWithNumbers

    seconds = "{task.completed:>6.0f} s" if total_s is None else "{task.completed:>6.0f}/{task.total:.0f} s"
    bar: list[ProgressColumn] = [] if total_s is None else [BarColumn(bar_width=32)]
    progress = ProgressWithNumbers(
        TextColumn("{task.description:<34}"),
        *bar,
        TextColumn(f"{seconds} of wire time"),
        TimeElapsedColumn(),
        numbers=numbers,
        console=shown,
        refresh_per_second=8,
    )
    progress.add_task(task, total=total_s)
    Console(file=StringIO(), force_terminal=True).print(progress.get_renderable())
    return progress
