"""All checks in the paper's order, run and judged."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from musclewire.experiment.reproduce import conclusions, equations, isobars, section2, section3, section4, table1
from musclewire.experiment.reproduce.paper_checks import PaperCheck, ReproductionRow, judged, selected
from musclewire.experiment.reproduce.runs import Runs
from musclewire.parameters.known_failures import known_failures
from musclewire.parameters.seeds import require_seed

__all__ = ["Reproduction", "all_checks", "reproduce"]


@dataclass(frozen=True)
class Reproduction:
    """The selected rows, and the runs they were measured on."""

    rows: tuple[ReproductionRow, ...]
    runs: Runs
    seed: int
    wall_s: float

    @property
    def judged_rows(self) -> list[ReproductionRow]:
        """Rows that hold or fail: all but those that are reported and not judged."""
        return [row for row in self.rows if row.is_judged]

    @property
    def failing(self) -> list[ReproductionRow]:
        """Rows outside their tolerance."""
        return [row for row in self.rows if not row.ok]

    @property
    def new_failures(self) -> list[ReproductionRow]:
        """Failing rows that the committed list does not have."""
        return [row for row in self.failing if not row.known_failure]

    @property
    def repaired(self) -> list[ReproductionRow]:
        """Rows of the committed list that hold."""
        return [row for row in self.rows if row.ok and row.known_failure]


def all_checks() -> list[PaperCheck]:
    """Return every check in the order of the paper, introduction and conclusions together, the isobars last."""
    modules = (table1, equations, section2, section3, section4, conclusions, isobars)
    return [check for module in modules for check in module.checks()]


def reproduce(
    only: str | None = None,
    *,
    seed: int = 1,
    on_row: Callable[[str, int, int], None] | None = None,
    on_run: Callable[[], None] | None = None,
) -> Reproduction:
    """Compare what the paper prints with the shipped parameters on the simulated rig.

    ``only`` keeps the rows whose names begin so; only the recordings they need are made. ``on_row`` receives each name
    with its number and the count before it is measured, ``on_run`` is called after each run on a rig and may raise to
    stop. Raises CallerError if no name begins with ``only``.
    """
    started = time.perf_counter()
    require_seed(seed)
    chosen = selected(all_checks(), only)
    runs, known = Runs(seed, on_run), known_failures()
    rows = []
    for number, check in enumerate(chosen):
        if on_row is not None:
            on_row(check.name, number, len(chosen))
        rows.append(judged(check, runs, known))
    return Reproduction(tuple(rows), runs, seed, time.perf_counter() - started)
