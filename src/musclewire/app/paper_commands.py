"""The command that puts the paper's numbers next to ours: reproduce."""

from __future__ import annotations

import json as json_text
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app.commands import add_command
from musclewire.app.options import ONLY, OUTPUT, SEED, Json
from musclewire.app.output import console, emit_json, say, show
from musclewire.app.stopping import stop_if_asked, stops_between_samples

if TYPE_CHECKING:
    from musclewire.experiment.reproduce import Reproduction, ReproductionRow

__all__ = ["add_paper_commands"]

TABLE_WIDTH = 118


def add_paper_commands(app: typer.Typer) -> None:
    """Add the commands of this file."""
    add_command(app, reproduce)


def reproduce(
    only: Annotated[str | None, ONLY] = None,
    output: Annotated[Path, OUTPUT] = Path("musclewire-reproduce"),
    seed: Annotated[int, SEED] = 1,
    json: Json = False,
) -> None:
    """Compare every printed number and figure of the paper with ours, in a folder; exit code 1 if a row fails."""
    started = time.perf_counter()
    from musclewire.app.report.paper_page import write_paper_page
    from musclewire.experiment.reproduce import all_checks, selected
    from musclewire.experiment.reproduce import reproduce as run_reproduce
    from musclewire.experiment.run import file_in

    chosen = selected(all_checks(), only)
    page, data = file_in(output, "reproduce.html"), output / "reproduce.json"
    for old in (page, data):
        old.unlink(missing_ok=True)  # an interrupted run must not leave an old answer
    with stops_between_samples(), rows_shown(quiet=json) as on_row:
        result = run_reproduce(only, seed=seed, on_row=on_row, on_run=stop_if_asked)

        def on_figure(subject: str) -> None:
            stop_if_asked()
            on_row(f"drawing.{subject}", len(chosen), len(chosen))

        write_paper_page(result, page, "all rows" if only is None else f"rows that begin with {only}", on_figure)
    document = as_document(result, page, time.perf_counter() - started)
    write_document(document, data)
    if json:
        emit_json(document)
    else:
        print_table(result)
        print_summary(result)
        show(f"{document['wall_s']:.1f} s; open {page}")
    if result.failing:
        raise typer.Exit(1)


@contextmanager
def rows_shown(quiet: bool) -> Iterator[Any]:
    """Yield what shows the row that is worked on: a bar on a terminal, a line for each subject on a pipe."""
    if quiet:
        yield lambda *_: None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    shown = console()
    if not shown.is_terminal:
        yield SubjectLines()
        return
    columns = (TextColumn("{task.description:<46}"), BarColumn(bar_width=32), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=shown, refresh_per_second=8, transient=True) as progress:
        task = progress.add_task("starting", total=None)
        yield lambda name, number, total: progress.update(task, description=name, completed=number, total=total)


class SubjectLines:
    """Says each figure, table or equation once, for a log."""

    def __init__(self) -> None:
        """Have said nothing."""
        self._said = ""

    def __call__(self, name: str, _number: int, _total: int) -> None:
        """Say the subject of a row where it is a new one."""
        subject = name.partition(".")[0]
        if subject != self._said:
            self._said = subject
            say(subject)


def as_document(result: Reproduction, page: Path, wall_s: float) -> dict[str, Any]:
    """Return the answer under the keys of the interface."""
    return {
        "rows": [row_document(row) for row in result.rows],
        "failing": [row.name for row in result.failing],
        "new_failures": [row.name for row in result.new_failures],
        "repaired": [row.name for row in result.repaired],
        "seed": result.seed,
        "wall_s": wall_s,
        "report": str(page),
    }


def row_document(row: ReproductionRow) -> dict[str, Any]:
    """Return a row as plain data."""
    keys = (
        *("name", "paper", "ours", "unit", "tolerance", "compare", "ok", "known_failure", "known_reason"),
        *("why", "kind", "origin", "problem"),
    )
    return {key: getattr(row, key) for key in keys}


def write_document(document: dict[str, Any], path: Path) -> None:
    """Write the answer next to the page, whole or not at all."""
    from musclewire.signals.whole_files import write_text_whole

    write_text_whole(path, json_text.dumps(document, indent=2, allow_nan=False) + "\n")


def print_table(result: Reproduction) -> None:
    """Print all rows on stdout."""
    from rich.console import Console
    from rich.table import Table

    from musclewire.app.report.row_text import limit_text, ours_text, paper_text, verdict

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("row", overflow="fold")
    for name in ("paper", "ours", "allowed"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    table.add_column("", no_wrap=True)
    for row in result.rows:
        style = None if row.ok and not row.known_failure else "red" if not row.ok else "yellow"
        cells = (row.name, paper_text(row), ours_text(row), limit_text(row), row.unit, verdict(row))
        table.add_row(*map(plain_markup, cells), style=style)
    out = Console(file=sys.stdout, highlight=False)
    out.width = max(out.width, TABLE_WIDTH) if not out.is_terminal else out.width
    out.print(table)


def plain_markup(text: str) -> str:
    """Return text whose brackets rich prints as they are."""
    from rich.markup import escape

    return escape(text)


def print_summary(result: Reproduction) -> None:
    """Print how many rows hold, and name the failures by whether they are known."""
    count, failing = len(result.judged_rows), len(result.failing)
    reported = len(result.rows) - count
    show(
        f"{count - failing} of {count} rows hold" + (f"; {reported} more are reported and not judged" * bool(reported))
    )
    groups = (
        ("known failures", [row for row in result.failing if row.known_failure]),
        ("new failures, not on the committed list", result.new_failures),
        ("repaired: on the committed list, and they hold", result.repaired),
    )
    for title, rows in groups:
        if rows:
            show(f"{title}:")
        for row in rows:
            reason = row.known_reason or row.problem
            show(f"  {row.name}" + (f": {reason}" if reason else ""))
