"""The command that puts the paper's numbers next to ours: reproduce."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from musclewire.app import (
    ONLY,
    SEED,
    WORKERS,
    Result,
    StoppedCommand,
    own_help,
    run_bar,
    stop_if_asked,
    stops_between_samples,
    tell,
)
from musclewire.errors import CallerError
from musclewire.extras.paper._options import FIRST_SEED, SEEDS
from musclewire.extras.paper._paper_text import rows_text, summary_text

if TYPE_CHECKING:
    from musclewire.extras.paper._answers import ReproduceAnswer
    from musclewire.extras.paper._reproduce.reproduction import Reproduction


@dataclass(frozen=True)
class SeedOptions:
    """The seeds over which medians are taken, or a single one, and the processes that measure."""

    seed: Annotated[int | None, SEED] = None
    seeds: Annotated[int | None, SEEDS] = None
    first_seed: Annotated[int | None, FIRST_SEED] = None
    workers: Annotated[int | None, WORKERS] = None

    def chosen(self) -> range:
        """Return the seeds. Raises CallerError for a single seed together with a set of them."""
        from musclewire.extras.paper._reproduce.reproduction import DEFAULT_SEEDS

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
    output: Annotated[Path, own_help("--output", "Folder for page and JSON.")] = Path("musclewire-reproduce"),
) -> Result:
    """Compare every printed number and figure of the paper with ours, in a folder; exit code 1 if a row fails.

    Each row is judged by the median over many seeds, on all cores; --seed runs a single one.
    """
    started = time.perf_counter()
    from musclewire.experiment import file_in
    from musclewire.extras.paper._reproduce.all_checks import all_checks
    from musclewire.extras.paper._reproduce.paper_checks import selected
    from musclewire.signals import write_text_whole

    seeds = which.chosen()
    selected(all_checks(), only)
    page, data = file_in(output, "reproduce.html"), output / "reproduce.json"
    for old in (page, data):
        old.unlink(missing_ok=True)  # an interrupted run must not leave an old answer
    try:
        result = reproduced(only, seeds, which.workers, page)
    except SystemExit as stop:
        raise StoppedCommand(stop.code if isinstance(stop.code, int) else 1, "no page was written") from None
    answer = answer_of(result, page, time.perf_counter() - started)
    write_text_whole(data, json.dumps(answer.model_dump(mode="json"), indent=2, allow_nan=False) + "\n")
    text = f"{rows_text(result)}\n{summary_text(result)}\n{answer.wall_s:.1f} s; open {page}"
    return Result(answer, text, holds=not result.failing)


def reproduced(only: str | None, seeds: range, workers: int | None, page: Path) -> Reproduction:
    """Measure on all seeds and write the page, with a bar or lines of progress; a signal ends both."""
    from musclewire.extras.paper._page.paper_page import write_paper_page
    from musclewire.extras.paper._reproduce.reproduction import reproduce as run_reproduce

    with stops_between_samples():
        with run_bar("seeds") as on_seed:
            result = run_reproduce(only, seeds=seeds, workers=workers, on_seed=on_seed, on_run=stop_if_asked)
        tell("drawing")
        selection = "all rows" if only is None else f"rows that begin with {only}"
        write_paper_page(result, page, selection, lambda _: stop_if_asked())
    return result


def answer_of(result: Reproduction, page: Path, wall_s: float) -> ReproduceAnswer:
    """Return the answer under the keys of the interface."""
    from musclewire.extras.paper._answers import ReproduceAnswer
    from musclewire.extras.paper._reproduce.verdicts import counts_by_origin

    return ReproduceAnswer.read_from(
        result,
        failing=[row.name for row in result.failing],
        new_failures=[row.name for row in result.new_failures],
        repaired=[row.name for row in result.repaired],
        origins={one.origin: one for one in counts_by_origin(result.rows)},
        seed=result.single_seed,
        wall_s=wall_s,
        report=str(page),
    )
