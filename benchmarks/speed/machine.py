"""What the machine that prints the figures reaches at most: arithmetic and memory, measured in the same process."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
from benchmarks.speed.compiled_wires import compiled

from musclewire.arrays import FloatArray

__all__ = ["MachinePeaks", "measured_machine", "processor_name", "usable_cores"]

TURNS = 7
# Numbers that one core keeps in its registers and nearest cache.
NEAR_NUMBERS = 256
NEAR_ROUNDS = 100_000
CHAIN_LENGTH = 2_000_000
# Three arrays of 32 MB each, more than most caches hold.
FAR_NUMBERS = 4_000_000


@dataclass(frozen=True)
class MachinePeaks:
    """The machine of a benchmark, with measured peaks of one thread in doubles with nothing fused.

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
    vector_flops_per_s: float
    chained_flops_per_s: float
    bandwidth_bytes_per_s: float


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
