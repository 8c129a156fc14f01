"""All checks run on many seeds and judged by their medians."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import cast

from musclewire.errors import CallerError
from musclewire.experiment import cores, evaluate_in_processes
from musclewire.extras.paper._known_failures import known_failures
from musclewire.extras.paper._reproduce.all_checks import all_checks
from musclewire.extras.paper._reproduce.paper_checks import PaperCheck, SeedResult, left_out, measured, selected
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.extras.paper._reproduce.seedless_runs import NeedsSeedError, SeedlessRuns
from musclewire.extras.paper._reproduce.verdicts import ReproductionRow, row_of_check
from musclewire.parameters import require_seed

OnSeed = Callable[[int, int], None]


@dataclass(frozen=True)
class SeedCallbacks:
    """Callbacks of a measurement on several seeds."""

    on_seed: OnSeed = lambda _done, _total: None  # after each, with how many are done and of how many
    # Between runs, and at least five times a second in waiting; it may raise to stop.
    on_run: Callable[[], None] = lambda: None


@dataclass(frozen=True)
class SeedNumbers:
    """What each seed gave for each check, and the runs of the first seed."""

    seeds: tuple[int, ...]
    fixed: Mapping[str, SeedResult]
    by_seed: Mapping[int, Mapping[str, SeedResult]]
    first_runs: RunCache

    def for_check(self, name: str, seeds: Sequence[int] | None = None) -> list[SeedResult]:
        """Return what each seed gave for a check, all of them or some."""
        wanted = self.seeds if seeds is None else seeds
        if name in self.fixed:
            return [self.fixed[name]] * len(wanted)
        return [self.by_seed[seed][name] for seed in wanted]


def numbers_of_seeds(
    checks: Sequence[PaperCheck], seeds: tuple[int, ...], *, workers: int, watching: SeedCallbacks
) -> SeedNumbers:
    """Measure checks on several seeds, all different, and those that no seed changes once.

    The first seed is measured in this process, as figures are drawn of its runs. Raises NumericsError if another
    process has died, or met an error in the code.
    """
    seedless = SeedlessRuns()
    fixed = {}
    for check in checks:
        watching.on_run()
        found = measured_without_seed(check, seedless)
        if found is not None:
            fixed[check.name] = found
    varying = [check for check in checks if check.name not in fixed]
    first_runs = RunCache(seeds[0], watching.on_run, seedless)
    if not varying:
        return SeedNumbers(seeds, fixed, {seed: {} for seed in seeds}, first_runs)
    by_seed: dict[int, Mapping[str, SeedResult]] = {}

    def keep(seed: int, numbers: Sequence[SeedResult]) -> None:
        by_seed[seed] = {check.name: one for check, one in zip(varying, numbers, strict=True)}
        watching.on_seed(len(by_seed), len(seeds))

    keep(seeds[0], numbers_on(varying, lambda _: first_runs, seeds[0]))
    others = seeds[1:]
    # Runs that are made in this process are watched, and share what no seed changes.
    runs_of = first_runs.for_seed if min(workers, len(others)) == 1 else RunCache
    evaluate_in_processes(
        partial(numbers_on, varying, runs_of),
        others,
        keep,
        workers=workers,
        named=lambda seed: f"seed {seed}",
        look=watching.on_run,
    )
    return SeedNumbers(seeds, fixed, by_seed, first_runs)


def measured_without_seed(check: PaperCheck, seedless: SeedlessRuns) -> SeedResult | None:
    """Return what a check gives for every seed; None if it depends on the seed."""
    try:
        return measured(check, cast(RunCache, seedless))
    except NeedsSeedError:
        return None


def numbers_on(checks: Sequence[PaperCheck], runs_of: Callable[[int], RunCache], seed: int) -> list[SeedResult]:
    """Return what a seed gives for each check."""
    runs = runs_of(seed)
    return [measured(check, runs) for check in checks]


# How many seeds make the verdicts stable: checks/verdicts_over_seeds.py prints what ten such sets agree on.
DEFAULT_SEEDS = 101


@dataclass(frozen=True)
class Reproduction:
    """The selected rows over all seeds."""

    rows: tuple[ReproductionRow, ...]  # the rows in the order of the paper
    runs: RunCache  # recordings of the first seed, from which figures are drawn; what is not there yet is made
    seeds: tuple[int, ...]
    # Rows that are left out because what they are measured by is not installed, each with what is said of that.
    lacking: Mapping[str, str]
    wall_s: float  # time that it took

    @property
    def single_seed(self) -> int | None:
        """The seed if it is one alone, None for medians over several."""
        return self.seeds[0] if len(self.seeds) == 1 else None

    @property
    def judged_rows(self) -> list[ReproductionRow]:
        """Rows that hold or fail: all but those that are reported and not judged."""
        return [row for row in self.rows if row.is_judged]

    @property
    def counted_rows(self) -> list[ReproductionRow]:
        """Rows that are judged and can fail."""
        return [row for row in self.rows if row.is_counted]

    @property
    def holding(self) -> int:
        """Number of counted rows that hold."""
        return sum(row.ok for row in self.counted_rows)

    @property
    def failing(self) -> list[ReproductionRow]:
        """Rows that do not hold: outside their tolerance, or at the bar."""
        return [row for row in self.rows if not row.ok]

    @property
    def new_failures(self) -> list[ReproductionRow]:
        """Failing rows that the committed list does not have."""
        return [row for row in self.failing if not row.known_failure]

    @property
    def repaired(self) -> list[ReproductionRow]:
        """Rows of the committed list that hold."""
        return [row for row in self.rows if row.ok and row.known_failure]


def reproduce(
    only: str | None = None,
    *,
    seeds: Iterable[int] | None = None,
    workers: int | None = None,
    on_seed: OnSeed = lambda _done, _total: None,
    on_run: Callable[[], None] = lambda: None,
) -> Reproduction:
    """Compare what the paper prints with the shipped parameters on the simulated rig, over many seeds.

    Each row is judged by the median over the seeds. What no seed changes (inputs, designed parts, isobars) is computed
    once.

    Parameters
    ----------
    only
        Keeps the rows whose names begin so; only the recordings they need are made. All rows if None.
    seeds
        Seeds of the simulated rigs, all different, each 0 or more; by default 1 to ``DEFAULT_SEEDS``. One seed gives
        the numbers of its own runs.
    workers
        Number of processes, by default one on each core. The numbers do not depend on it.
    on_seed
        Called after each seed with how many are done, and of how many.
    on_run
        Called between runs and at least five times a second while other processes are waited for; may raise to stop.

    Returns
    -------
    The rows in the order of the paper, with the runs of the first seed; those of a package that is not installed are
    left out and named.

    Raises
    ------
    CallerError
        If no name begins with ``only``, or one that does needs a package that is not installed, or a seed is none, or
        twice there.
    NumericsError
        If another process has died.

    References
    ----------
    Lan and Fan 2010.

    Examples
    --------
    >>> from musclewire.extras.paper._reproduce.reproduction import reproduce
    >>> [row.verdict for row in reproduce("eq3", seeds=[1]).rows]
    ['holds', 'holds']
    """
    started = time.perf_counter()
    asked = selected(all_checks(), only)
    lacking = left_out(asked)
    chosen = [check for check in asked if check.name not in lacking]
    wanted = required_seeds(range(1, DEFAULT_SEEDS + 1) if seeds is None else seeds)
    if workers is not None and workers < 1:
        raise CallerError(f"{workers} workers: at least one process measures, give 1 or more")
    found = numbers_of_seeds(
        chosen, wanted, workers=cores() if workers is None else workers, watching=SeedCallbacks(on_seed, on_run)
    )
    known = known_failures()
    rows = tuple(row_of_check(check, found.for_check(check.name), known) for check in chosen)
    return Reproduction(rows, found.first_runs, wanted, lacking, time.perf_counter() - started)


def required_seeds(seeds: Iterable[int]) -> tuple[int, ...]:
    """Return seeds as a tuple. Raises CallerError for none, for what is no seed, and for one that is twice there."""
    wanted = tuple(require_seed(seed) for seed in seeds)
    if not wanted:
        raise CallerError("no seeds: give at least one, such as range(1, 102)")
    twice = next((seed for place, seed in enumerate(wanted) if seed in wanted[:place]), None)
    if twice is not None:
        raise CallerError(f"seed {twice} is there twice: it would count twice in every median, leave one out")
    return wanted
