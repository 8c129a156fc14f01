"""A fixed workload in plain Python, beside which times of the host are printed: a ratio outlives the machine.

    python benchmarks/fixed_work.py

It does what a sample of a loop does in Python, calls, attributes, small tuples and arithmetic, and never changes.
"""

from __future__ import annotations

import statistics
import time
from typing import NamedTuple

ROUNDS = 40
RUNS = 2001


class Pair(NamedTuple):
    """Two numbers."""

    first: float
    second: float


def turned(pair: Pair, factor: float) -> Pair:
    """Return the next pair."""
    if pair.first > pair.second:
        return Pair(pair.second * factor, pair.first - 1.0)
    return Pair(pair.first + 1.0, pair.second * factor)


def fixed_work() -> float:
    """Do the work once: 40 calls that each read a pair and return another."""
    pair = Pair(0.0, 1.0)
    for _ in range(ROUNDS):
        pair = turned(pair, 0.9)
    return pair.first


def fixed_work_us(runs: int = RUNS) -> float:
    """Return the median time of the work [us]."""
    times_ns = []
    for _ in range(runs):
        began_ns = time.perf_counter_ns()
        fixed_work()
        times_ns.append(time.perf_counter_ns() - began_ns)
    return statistics.median(times_ns) / 1e3


if __name__ == "__main__":
    print(f"{fixed_work_us():.2f} us")
