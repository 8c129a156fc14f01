"""What each seed gives for each row: this process and others measure, a seed at a time.

The numbers depend neither on the number of processes nor on which of them had which seed.
"""

from __future__ import annotations

import json
import queue
import subprocess
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

from musclewire.errors import NumericsError
from musclewire.experiment import end_worker, start_worker
from musclewire.extras.paper._reproduce.paper_checks import PaperCheck, SeedResult, measured
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.extras.paper._reproduce.seedless_runs import NeedsSeedError, SeedlessRuns

__all__ = ["OnSeed", "SeedNumbers", "SeedCallbacks", "numbers_of_seeds"]

OnSeed = Callable[[int, int], None]
# How often this process looks whether it has been asked to stop, while others measure.
LOOK_S = 0.2


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
        The checks. With more than one worker they must be of ``all_checks``, which other processes find by name.
    seeds
        The seeds, at least one, all different.
    workers
        Number of processes, this one included. No more are started than there are seeds.
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
    pool = SeedPool(varying, seeds, first_runs, watching)
    return SeedNumbers(seeds, fixed, pool.measure(min(workers, len(seeds)) - 1), first_runs)


def measured_without_seed(check: PaperCheck, seedless: SeedlessRuns) -> SeedResult | None:
    """Return what a check gives for every seed; None if it depends on the seed."""
    try:
        return measured(check, cast(RunCache, seedless))
    except NeedsSeedError:
        return None


class SeedPool:
    """Seeds that wait, processes that take them, and what they have given."""

    def __init__(
        self, checks: Sequence[PaperCheck], seeds: tuple[int, ...], first_runs: RunCache, watching: SeedCallbacks
    ) -> None:
        """Queue the seeds but the first, which this process measures."""
        self._checks, self._seeds, self._watching = checks, seeds, watching
        self._first_runs = first_runs
        self._todo: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._done: queue.SimpleQueue[tuple[int, list[SeedResult]] | BaseException] = queue.SimpleQueue()
        self._found: dict[int, dict[str, SeedResult]] = {}
        self._processes: list[subprocess.Popen[bytes]] = []
        for seed in seeds[1:]:
            self._todo.put(seed)

    def measure(self, helpers: int) -> dict[int, dict[str, SeedResult]]:
        """Return what each seed gives; so many other processes help, and are ended whatever happens."""
        threads = []
        try:
            for _ in range(helpers):
                self._processes.append(start_worker("musclewire.extras.paper._reproduce.seed_worker"))
                threads.append(threading.Thread(target=self._serve, args=(self._processes[-1],), daemon=True))
                threads[-1].start()
            self._measure_here()
            while len(self._found) < len(self._seeds):
                self._watching.on_run()
                self._take(LOOK_S)
        finally:
            for process in self._processes:
                process.kill()  # its thread then reads the end of its answers
            for thread in threads:
                thread.join()
            for process in self._processes:
                end_worker(process)
        return self._found

    def _measure_here(self) -> None:
        seed: int | None = self._seeds[0]
        while seed is not None:
            self._watching.on_run()
            first = seed == self._seeds[0]
            runs = self._first_runs if first else self._first_runs.for_seed(seed)
            self._keep(seed, [measured(check, runs) for check in self._checks])
            while self._take(0.0):
                pass
            seed = next_in(self._todo)

    def _take(self, timeout_s: float) -> bool:
        """Keep an answer of another process, if there is one in time; raise what has ended one."""
        try:
            answer = self._done.get(timeout=timeout_s) if timeout_s else self._done.get_nowait()
        except queue.Empty:
            return False
        if isinstance(answer, BaseException):
            raise answer
        self._keep(*answer)
        return True

    def _keep(self, seed: int, numbers: Sequence[SeedResult]) -> None:
        self._found[seed] = {check.name: one for check, one in zip(self._checks, numbers, strict=True)}
        self._watching.on_seed(len(self._found), len(self._seeds))

    def _serve(self, process: subprocess.Popen[bytes]) -> None:
        """Keep one process busy until no seed is left; the body of a thread."""
        seed: int | None = None
        try:
            asked(process, json.dumps([check.name for check in self._checks]))
            while (seed := next_in(self._todo)) is not None:
                asked(process, str(seed))
                self._done.put((seed, answered(process, seed)))
        except (OSError, ValueError):
            self._done.put(
                NumericsError(
                    f"the process that measured seed {seed} has died: is there enough memory? try fewer workers"
                )
            )
        except BaseException as problem:
            self._done.put(problem)


def next_in(seeds: queue.SimpleQueue[int]) -> int | None:
    """Return the next seed that waits, None if there is none."""
    try:
        return seeds.get_nowait()
    except queue.Empty:
        return None


def asked(process: subprocess.Popen[bytes], line: str) -> None:
    """Send a line to a worker. Raises OSError if it has died."""
    assert process.stdin is not None
    process.stdin.write(line.encode() + b"\n")
    process.stdin.flush()


def answered(process: subprocess.Popen[bytes], seed: int) -> list[SeedResult]:
    """Return a worker's answer. Raises OSError if it has died, NumericsError for an error in the code."""
    assert process.stdout is not None
    line = process.stdout.readline()
    if not line:
        raise OSError("no answer")
    answer = json.loads(line)
    if isinstance(answer, str):
        raise NumericsError(f"seed {seed}: {answer}")
    return [SeedResult(*one) for one in answer]
