"""Many different wires in one call: the time of a step and wire, over threads and sizes of the batch, and over time.

    python benchmarks/batch.py [--quick]

Wires on springs whose every number differs by up to 2 %, one tabulated distribution, fixed steps of 10 ms, each under
its own staircase of the drive. Times are medians of several calls; with two threads the clock of the wall counts, so
run it on a quiet machine. The same digits alone, in any batch and with any number of threads are held by
tests/unit/wire/in_time/test_batch.py.
"""

from __future__ import annotations

import argparse
import json
from statistics import median
from time import perf_counter

import numpy as np

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire import WireBatch, WireConstants, constants_of, fixed_steps

STEP_S, SAMPLE_S = 0.01, 0.05
SPREAD = 0.02
# One distribution, whole numbers, and what the correlation of the air is tabulated for stay the same.
SAME = ("grain_skew", "grain_tail", "early_fraction", "early_width", "legs", "ambient_temperature_k", "diameter_m")
SIZES = (100, 1_000, 10_000, 100_000)
CALLS = 7


def different_wires(count: int) -> list[WireConstants]:
    """Return wires on springs of which every number differs."""
    random = np.random.default_rng(1)
    groups = [load_alloy("flexinol").values(), load_wire("paper-100um").values(), load_bench("paper").values()]
    found = []
    for _ in range(count):
        own = [
            {
                name: value * (1.0 + (0.0 if name in SAME else SPREAD * random.uniform(-1.0, 1.0)))
                for name, value in group.items()
            }
            for group in groups
        ]
        found.append(constants_of(*own))
    return found


def ns_a_step_and_wire(wires: list[WireConstants], threads: int, samples: int) -> tuple[float, float, float]:
    """Return the median time of a step and wire [ns], and those of the first and the last call."""
    batch = WireBatch(wires, stepping=fixed_steps(STEP_S), threads=threads)
    random = np.random.default_rng(2)
    steps = len(wires) * samples * round(SAMPLE_S / STEP_S)
    times = []
    for _ in range(CALLS + 1):
        drive_v = np.repeat(random.uniform(0.5, 3.2, (len(wires), 1)), samples, axis=1)
        began = perf_counter()
        batch.drive(drive_v, SAMPLE_S, ())
        times.append(1e9 * (perf_counter() - began) / steps)
    batch.require_resolved(SAMPLE_S)
    return median(times[1:]), times[1], times[-1]


def main() -> None:
    """Print a row for each size, with one thread and with two."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="up to 1,000 wires")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    sizes = SIZES[:2] if asked.quick else SIZES
    different = different_wires(min(sizes[-1], 10_000))
    rows = []
    for size in sizes:
        wires = different[:size] if size <= len(different) else different * (size // len(different))
        samples = max(10, min(400, 400_000 // size))
        one, first, last = ns_a_step_and_wire(wires, 1, samples)
        two, _, _ = ns_a_step_and_wire(wires, 2, samples)
        rows.append(
            {"wires": size, "one_ns": one, "first_ns": first, "last_ns": last, "two_ns": two, "ratio": one / two}
        )
    if asked.json:
        print(json.dumps(rows))
        return
    print(f"{'wires':>8}{'one thread ns':>15}{'first call':>12}{'last call':>11}{'two threads ns':>16}{'ratio':>7}")
    for row in rows:
        print(
            f"{row['wires']:8d}{row['one_ns']:15.1f}{row['first_ns']:12.1f}{row['last_ns']:11.1f}"
            f"{row['two_ns']:16.1f}{row['ratio']:7.2f}"
        )


if __name__ == "__main__":
    main()
