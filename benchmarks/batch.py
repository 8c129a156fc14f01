"""Many different wires in one call: the time of a step and wire, over threads and sizes of the batch, and over time.

Then how much faster the wires are in lanes than in a parallel loop over the step of one wire, with the same drives,
steps and bits, in turns: lanes stay in the package for a ratio of 1.3 or more on 1,000 wires.

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

import numba
import numpy as np

from musclewire.arrays import FloatArray
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire import (
    Rows,
    WireBatch,
    WireConstants,
    advance_rows,
    constants_of,
    fixed_steps,
    plan_of,
    resting_state,
)

STEP_S, SAMPLE_S = 0.01, 0.05
SPREAD = 0.02
# One distribution, whole numbers, and what the correlation of the air is tabulated for stay the same.
SAME = ("grain_skew", "grain_tail", "early_fraction", "early_width", "legs", "ambient_temperature_k", "diameter_m")
SIZES = (100, 1_000, 10_000, 100_000)
CALLS = 7
# Wires, steps [s], and samples for which a drive is held, of the comparison with a loop: a staircase, and a policy.
COMPARED = 1_000
COMPARED_STEPS_S, HELD_SAMPLES = (0.01, 0.025), (20, 1)


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


@numba.njit(parallel=True, error_model="numpy")
def loop_over_one_step(
    states: Rows, derived: Rows, cells: Rows, load: Rows, drive_v: FloatArray, plan: FloatArray
) -> None:
    """Advance wires in place along their drives, (n_wires, n_samples), each by the step of one wire."""
    for wire in numba.prange(drive_v.shape[0]):
        state, constants = states[wire : wire + 1], derived[wire : wire + 1]
        for sample in range(drive_v.shape[1]):
            advance_rows(state, constants, cells, load, drive_v[wire, sample], plan)


def loop_over_lanes(wires: list[WireConstants], threads: int, step_s: float, held: int) -> dict[str, float]:
    """Return medians of the time of a step and wire [ns] in lanes and in a parallel loop, and that of their ratio."""
    batch = WireBatch(wires, stepping=fixed_steps(step_s), threads=threads)
    states = np.concatenate([resting_state(wire).row for wire in wires])
    derived = np.concatenate([wire.derived.row for wire in wires])
    tables, plan = wires[0].step_arrays()[1:], plan_of(fixed_steps(step_s), SAMPLE_S)
    numba.set_num_threads(threads)
    random, lanes, loop = np.random.default_rng(3), [], []
    for _ in range(CALLS + 1):
        drive_v = np.repeat(random.uniform(0.5, 3.2, (len(wires), 100 // held)), held, axis=1)
        steps = drive_v.size * plan[1]
        began = perf_counter()
        batch.drive(drive_v, SAMPLE_S, ())
        between = perf_counter()
        loop_over_one_step(states, derived, *tables, drive_v, plan)
        lanes.append(1e9 * (between - began) / steps)
        loop.append(1e9 * (perf_counter() - between) / steps)
    assert np.array_equal(batch.states["enthalpy_j"], states["enthalpy_j"]), "both are the same wires"
    ratio = median(one / other for one, other in zip(loop[1:], lanes[1:], strict=True))
    return {
        "threads": threads,
        "step_s": step_s,
        "held_samples": held,
        "lanes_ns": median(lanes[1:]),
        "loop_ns": median(loop[1:]),
        "loop_over_lanes": ratio,
    }


def main() -> None:
    """Print a row for each size, with one thread and with two, and the comparison with a loop."""
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
    compared = [
        loop_over_lanes(different[:COMPARED], threads, step_s, held)
        for held in HELD_SAMPLES
        for step_s in COMPARED_STEPS_S
        for threads in (1, 2)
    ]
    if asked.json:
        print(json.dumps({"sizes": rows, "lanes": compared}))
        return
    print(f"{'wires':>8}{'one thread ns':>15}{'first call':>12}{'last call':>11}{'two threads ns':>16}{'ratio':>7}")
    for row in rows:
        print(
            f"{row['wires']:8d}{row['one_ns']:15.1f}{row['first_ns']:12.1f}{row['last_ns']:11.1f}"
            f"{row['two_ns']:16.1f}{row['ratio']:7.2f}"
        )
    print(f"\n{COMPARED} wires:  drive held s{'step ms':>10}{'threads':>10}{'lanes ns':>10}{'loop ns':>10}{'ratio':>7}")
    for found in compared:
        print(
            f"{SAMPLE_S * found['held_samples']:25.2f}{1e3 * found['step_s']:10.0f}{found['threads']:10.0f}"
            f"{found['lanes_ns']:10.1f}{found['loop_ns']:10.1f}{found['loop_over_lanes']:7.2f}"
        )


if __name__ == "__main__":
    main()
