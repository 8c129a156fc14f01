"""What the machine that prints the figures reaches at most: arithmetic and memory, measured in the same process."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter

import numpy as np
from benchmarks.speed.uncached import compiled

from musclewire.app import MachinePeaks, processor_name, usable_cores
from musclewire.arrays import FloatArray

__all__ = ["measured_machine"]

TURNS = 7
# Numbers that one core keeps in its registers and nearest cache.
NEAR_NUMBERS = 256
NEAR_ROUNDS = 100_000
CHAIN_LENGTH = 2_000_000
# Three arrays of 32 MB each, more than most caches hold.
FAR_NUMBERS = 4_000_000


@compiled
def vector_rounds(values: FloatArray, rounds: int, factor: float, added: float) -> None:
    """Multiply and add over a short array so many times."""
    for _ in range(rounds):
        for place in range(values.shape[0]):
            values[place] = values[place] * factor + added


@compiled
def chained_rounds(rounds: int, factor: float, added: float) -> float:
    """Multiply and add so many times, each with the result of the one before."""
    value = 1.0
    for _ in range(rounds):
        value = value * factor + added
    return value


@compiled
def triad(target: FloatArray, first: FloatArray, second: FloatArray, factor: float) -> None:
    """Read two arrays and write a third (STREAM's triad)."""
    for place in range(target.shape[0]):
        target[place] = first[place] + factor * second[place]


def median_s(run: Callable[[], object]) -> float:
    """Return the median time of a few runs after one that is not counted."""
    times = []
    for _ in range(TURNS + 1):
        began_s = perf_counter()
        run()
        times.append(perf_counter() - began_s)
    return median(times[1:])


def measured_machine() -> MachinePeaks:
    """Return the peaks of this machine, measured now.

    References
    ----------
    McCalpin, STREAM: sustainable memory bandwidth in high performance computers, www.cs.virginia.edu/stream.
    """
    near = np.ones(NEAR_NUMBERS)
    target, first, second = (np.ones(FAR_NUMBERS) for _ in range(3))
    vector_s = median_s(lambda: vector_rounds(near, NEAR_ROUNDS, 0.999, 1e-3))
    chained_s = median_s(lambda: chained_rounds(CHAIN_LENGTH, 0.999, 1e-3))
    triad_s = median_s(lambda: triad(target, first, second, 0.5))
    return MachinePeaks(
        processor=processor_name(),
        cores=usable_cores(),
        vector_flops_per_s=2.0 * NEAR_NUMBERS * NEAR_ROUNDS / vector_s,
        chained_flops_per_s=2.0 * CHAIN_LENGTH / chained_s,
        bandwidth_bytes_per_s=3.0 * target.nbytes / triad_s,
    )
