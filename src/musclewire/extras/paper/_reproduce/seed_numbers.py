"""What each seed gives for each row: this process measures the first one, and others a seed at a time.

The numbers depend neither on the number of processes nor on which of them had which seed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import cast

from musclewire.experiment import evaluate_in_processes
from musclewire.extras.paper._reproduce.paper_checks import PaperCheck, SeedResult, measured
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.extras.paper._reproduce.seedless_runs import NeedsSeedError, SeedlessRuns

OnSeed = Callable[[int, int], None]


@dataclass(frozen=True)
class SeedCallbacks:
    """Callbacks: ``on_seed`` after each seed, with how many are done and of how many.

    ``on_run`` is called between runs, and at least five times a second while this process waits; it may raise to stop.
    """

    on_seed: OnSeed = lambda _done, _total: None
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
    """Measure checks on several seeds, those that no seed changes once.

    Parameters
    ----------
    checks
        The checks.
    seeds
        The seeds, at least one, all different.
    workers
        Number of processes for all seeds but the first, which is measured here: figures are drawn of its runs.
    watching
        Callbacks for progress, which may stop it.

    Returns
    -------
    Number or problem of each check for each seed.

    Raises
    ------
    NumericsError
        If another process has died, or met an error in the code.
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
