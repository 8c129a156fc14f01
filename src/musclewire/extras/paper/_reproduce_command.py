"""The command that puts the paper's numbers next to ours: reproduce."""

from __future__ import annotations

import json as json_text
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app import (
    ONLY,
    OUTPUT,
    SEED,
    WORKERS,
    Json,
    StoppedCommand,
    emit_json,
    run_bar,
    say,
    show,
    stop_if_asked,
    stops_between_samples,
)
from musclewire.errors import CallerError
from musclewire.extras.paper._options import FIRST_SEED, SEEDS
from musclewire.extras.paper._paper_text import print_rows, print_summary

if TYPE_CHECKING:
    from musclewire.extras.paper._reproduce import Reproduction, ReproductionRow


@dataclass(frozen=True)
class SeedOptions:
    """The seeds over which medians are taken, or a single one, and the processes that measure."""

    seed: Annotated[int | None, SEED] = None
    seeds: Annotated[int | None, SEEDS] = None
    first_seed: Annotated[int | None, FIRST_SEED] = None
    workers: Annotated[int | None, WORKERS] = None

    def chosen(self) -> range:
        """Return the seeds. Raises CallerError for a single seed together with a set of them."""
        from musclewire.extras.paper._reproduce import DEFAULT_SEEDS

        if self.seed is not None:
            if self.seeds is not None or self.first_seed is not None:
                raise CallerError("--seed runs a single seed, --seeds and --first-seed choose many: give one or the "
                                  "others")  # fmt: skip
            return range(self.seed, self.seed + 1)
        first = 1 if self.first_seed is None else self.first_seed
        return range(first, first + (DEFAULT_SEEDS if self.seeds is None else self.seeds))


def reproduce(
    which: SeedOptions,
    only: Annotated[str | None, ONLY] = None,
    output: Annotated[Path, OUTPUT] = Path("musclewire-reproduce"),
    json: Json = False,
) -> None:
    """Compare every printed number and figure of the paper with ours, in a folder; exit code 1 if a row fails.

    Each row is judged by the median over many seeds, on all cores; --seed runs a single one.
    """
    started = time.perf_counter()
    from musclewire.experiment import file_in
    from musclewire.extras.paper._reproduce import all_checks, selected

    seeds = which.chosen()
    selected(all_checks(), only)
    page, data = file_in(output, "reproduce.html"), output / "reproduce.json"
    for old in (page, data):
        old.unlink(missing_ok=True)  # an interrupted run must not leave an old answer
    try:
        result = reproduced(only, seeds, which.workers, page, quiet=json)
    except SystemExit as stop:
        raise StoppedCommand(stop.code if isinstance(stop.code, int) else 1, "no page was written") from None
    document = as_document(result, page, time.perf_counter() - started)
    write_document(document, data)
    if json:
        emit_json(document)
    else:
        print_rows(result)
        print_summary(result)
        show(f"{document['wall_s']:.1f} s; open {page}")
    if result.failing:
        raise typer.Exit(1)


def reproduced(only: str | None, seeds: range, workers: int | None, page: Path, quiet: bool) -> Reproduction:
    """Measure on all seeds and write the page, with a bar or lines of progress; a signal ends both."""
    from musclewire.extras.paper._page.paper_page import write_paper_page
    from musclewire.extras.paper._reproduce import reproduce as run_reproduce

    with stops_between_samples():
        with run_bar("seeds", quiet) as on_seed:
            result = run_reproduce(only, seeds=seeds, workers=workers, on_seed=on_seed, on_run=stop_if_asked)
        if not quiet:
            say("drawing")
        selection = "all rows" if only is None else f"rows that begin with {only}"
        write_paper_page(result, page, selection, lambda _: stop_if_asked())
    return result


def as_document(result: Reproduction, page: Path, wall_s: float) -> dict[str, Any]:
    """Return the answer under the keys of the interface; ``seed`` is that of a single one, null for medians."""
    from musclewire.extras.paper._reproduce import counts_by_origin

    return {
        "rows": [row_document(row) for row in result.rows],
        "failing": [row.name for row in result.failing],
        "new_failures": [row.name for row in result.new_failures],
        "repaired": [row.name for row in result.repaired],
        "origins": {
            one.origin: {"holds": one.holds, "at_the_bar": one.at_the_bar, "fails": one.fails}
            for one in counts_by_origin(result.rows)
        },
        "seeds": list(result.seeds),
        "seed": result.single_seed,
        "wall_s": wall_s,
        "report": str(page),
    }


def row_document(row: ReproductionRow) -> dict[str, Any]:
    """Return a row as plain data."""
    keys = (
        *("name", "paper", "ours", "low", "high", "median_low", "median_high", "seeds", "unit", "tolerance", "compare"),
        *("ok", "verdict", "known_failure", "known_reason", "why", "kind", "origin", "problem"),
    )
    return {key: getattr(row, key) for key in keys}


def write_document(document: dict[str, Any], path: Path) -> None:
    """Write the answer next to the page, whole or not at all."""
    from musclewire.signals import write_text_whole

    write_text_whole(path, json_text.dumps(document, indent=2, allow_nan=False) + "\n")
