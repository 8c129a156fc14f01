"""Two programs compared: in turns, so that what else the machine does falls on both, and as medians."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter, thread_time
from typing import Any

__all__ = ["Comparison", "PreparedComparison", "TimedProgram", "comparison", "measured", "paired_us"]

TURNS, QUICK_TURNS = 15, 5


def nothing() -> None:
    """Prepare nothing."""


@dataclass(frozen=True)
class TimedProgram:
    """One of two programs: what runs, how many units of the comparison a run is, and what is made before, untimed.

    ``repeats`` is how often it runs in a turn: a run of less than a millisecond would mostly find the caches as the
    other program has left them.
    """

    run: Callable[[Any], object]
    units: float
    prepare: Callable[[], Any] = nothing
    repeats: int = 1

    def time_us(self, clock: Callable[[], float] = perf_counter) -> float:
        """Run once; return the time of a unit by a clock in seconds."""
        prepared = self.prepare()
        began_s = clock()
        for _ in range(self.repeats):
            self.run(prepared)
        return 1e6 * (clock() - began_s) / (self.units * self.repeats)


@dataclass(frozen=True)
class PreparedComparison:
    """One comparison before it is measured.

    ``sides`` makes ours and theirs, quick or not; ``needs`` is the extra without which theirs cannot run, "" if it can.
    ``clock`` is the processor time of the thread, which other programs do not lengthen, or the wall clock for what runs
    in several threads or processes.
    """

    name: str
    work: str
    theirs: str
    sides: Callable[[bool], tuple[TimedProgram, TimedProgram]]
    needs: str = ""
    clock: Callable[[], float] = thread_time


@dataclass(frozen=True)
class Comparison:
    """A row of the benchmark: our time and another program's, for the same amount of work.

    Parameters
    ----------
    name
        Name of the row; it begins with what is measured.
    work
        The work whose time is given, the same for both, and in what they differ.
    theirs
        The other program.
    ours_us
        Our time [us], median of the turns.
    theirs_us
        The other program's time [us], median of the turns.
    ratio
        Their time over ours, median of the turns' ratios: how many times faster ours is.
    ratio_low
        Smallest ratio of the turns.
    ratio_high
        Largest ratio of the turns.
    turns
        How often each has run, after one run that is not counted.
    """

    name: str
    work: str
    theirs: str
    ours_us: float
    theirs_us: float
    ratio: float
    ratio_low: float
    ratio_high: float
    turns: int


def paired_us(
    ours: TimedProgram, theirs: TimedProgram, turns: int, clock: Callable[[], float] = perf_counter
) -> list[tuple[float, float]]:
    """Return our time and theirs of so many turns, in each of which both run, after one run that is not counted.

    Who is first changes from turn to turn: neither always finds the caches as the other left them.
    """
    ours.time_us(clock)
    theirs.time_us(clock)
    pairs = []
    for turn in range(turns):
        if turn % 2:
            their_us, our_us = theirs.time_us(clock), ours.time_us(clock)
        else:
            our_us, their_us = ours.time_us(clock), theirs.time_us(clock)
        pairs.append((our_us, their_us))
    return pairs


def comparison(name: str, work: str, theirs: str, pairs: Sequence[tuple[float, float]]) -> Comparison:
    """Return the row of measured turns: medians of both times and of the turns' ratios."""
    ratios = [their_us / our_us for our_us, their_us in pairs]
    our_us, their_us = (statistics.median(times) for times in zip(*pairs, strict=True))
    ratio = statistics.median(ratios)
    return Comparison(name, work, theirs, our_us, their_us, ratio, min(ratios), max(ratios), len(pairs))


def measured(case: PreparedComparison, quick: bool) -> Comparison:
    """Return the row of a case."""
    pairs = paired_us(*case.sides(quick), QUICK_TURNS if quick else TURNS, case.clock)
    return comparison(case.name, case.work, case.theirs, pairs)
