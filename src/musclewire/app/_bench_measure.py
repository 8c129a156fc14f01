"""Two programs compared: in turns, so that what else the machine does falls on both, and as medians.

One of the two may be fixed work, whose lines never change.
"""

from __future__ import annotations

import math
import os
import platform
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any

import numba
import numpy as np

from musclewire.arrays import FloatArray

ARITHMETIC_ROUNDS, PYTHON_ROUNDS = 100_000, 2_000


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


def arithmetic(rounds: int, table: FloatArray) -> float:
    """Do what a step consists of, so many times: products, quotients, roots, exponentials, a table, comparisons.

    These lines must not change: every ratio on record is to them.
    """
    value, other = 0.3, 1.7
    for number in range(rounds):
        place = 10.0 * value
        index = min(int(place), table.shape[0] - 2)
        found = table[index] + (place - index) * (table[index + 1] - table[index])
        other = 0.5 * (other + (2.0 + found) / (1.0 + other * other))
        other += 1e-3 * math.exp(-value * found) + 1e-4 * math.sqrt(1.0 + found * found)
        if other > 1.2 + 1e-6 * (number % 7):
            value = min(value + 0.37 * other, 9.0 - value)
        else:
            value = max(value - 0.11, 0.05)
        value = abs(value - 5.0 * math.floor(0.2 * value))
    return value + other


# Without a cache: an edit of this file would be a reason to compile every kernel again.
fixed_arithmetic: Any = numba.njit(error_model="numpy")(arithmetic)


class Fixed:
    """State of the fixed work in Python."""

    __slots__ = ("numbers", "total")

    def __init__(self) -> None:
        """Start at nothing."""
        self.numbers = np.zeros(64)
        self.total = 0.0


def fixed_python(rounds: int) -> None:
    """Do what a call from Python consists of, so many times: objects, attributes, tuples, copies of small arrays.

    These lines must not change: every ratio on record is to them.
    """
    state = Fixed()
    for number in range(rounds):
        after = Fixed()
        after.numbers = state.numbers.copy()
        after.numbers[number % 64] = 0.5 * number
        values = (state.total, float(after.numbers[3]), number)
        after.total = round(min(max(values[0] + 1e-3 * values[1], -1.0), 1.0), 9)
        state = after


def arithmetic_side(rounds_of_a_unit: int = 1) -> TimedProgram:
    """Return the fixed compiled work in units of so many rounds."""
    table = np.linspace(0.0, 1.0, 101) ** 2
    return TimedProgram(lambda _: fixed_arithmetic(ARITHMETIC_ROUNDS, table), ARITHMETIC_ROUNDS / rounds_of_a_unit)


def python_side(rounds_of_a_unit: int = 1) -> TimedProgram:
    """Return the fixed work in Python in units of so many rounds."""
    return TimedProgram(lambda _: fixed_python(PYTHON_ROUNDS), PYTHON_ROUNDS / rounds_of_a_unit)


@dataclass(frozen=True)
class MachinePeaks:
    """The machine of a benchmark, with measured peaks of one thread in doubles with nothing fused.

    The peaks are None if they were not measured: only a checkout measures them.

    Parameters
    ----------
    processor
        Name of the processor.
    cores
        Number of processor cores that this process may use.
    vector_flops_per_s
        Multiplications and additions per second [1/s] over a short array, in vector registers.
    chained_flops_per_s
        The same where each waits for the one before, as within one step of one wire [1/s].
    bandwidth_bytes_per_s
        Bytes read and written per second [1/s] over arrays larger than the caches.
    """

    processor: str
    cores: int
    vector_flops_per_s: float | None = None
    chained_flops_per_s: float | None = None
    bandwidth_bytes_per_s: float | None = None


def usable_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def processor_name() -> str:
    """Return the processor's name as the system states it."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, "") or platform.processor() or platform.machine()
