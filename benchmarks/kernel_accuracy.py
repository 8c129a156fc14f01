"""How accurate the kernel is, as bars that can fail: beside the ensemble of grains, beside itself in finer steps.

Prints each bar with what was found and ends with exit code 1 if one is missed; --quick takes fewer random wires and
fewer combinations of friction, --json prints one JSON document. What each bar means is in docs/explanation/numerics.md.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from kernel_courses import (
    COURSES,
    GRAINS,
    GRAINS_OF,
    OUTPUTS,
    SAMPLE_S,
    Array,
    Course,
    distance,
    fixed,
    kernel_run,
    reference,
    reference_run,
    shipped,
    with_bench,
)
from kernel_friction import FRICTIONS_N, PRESLIDINGS_M, STEPS_S, case_of, shown
from kernel_random_wires import outcomes
from kernel_walks import walk_departures

from musclewire.wire import StepControl

UNITS = {"temperature_k": ("mK", 1e3), "resistance_ohm": ("mohm", 1e3), "contraction": ("points", 100.0)}
# What one sample of a slow loop may be off at one step a sample: temperature [K], resistance [ohm], gap [points].
SLOW_BARS = (5e-3, 0.5e-3, 1e-3)
NUDGE_K = 1e-9
NUDGE_MOVES_K = 1e-7
ORDER_STEPS_S = (25e-3, 12.5e-3, 5e-3, 2.5e-3, 1e-3)
FINEST_STEP_S = 5e-5


class Bar(NamedTuple):
    """One bar: what was found, and what it may be at most (at least, where ``least``)."""

    what: str
    found: float
    bar: float
    unit: str
    least: bool = False

    @property
    def holds(self) -> bool:
        """Whether the bar is met; a number that is not finite does not."""
        if not math.isfinite(self.found):
            return False
        return self.found >= self.bar if self.least else self.found <= self.bar


def walks(quick: bool) -> Iterator[Bar]:
    """Fractions along random walks in temperature and stress, beside grains of the same distribution."""
    for table, departure in walk_departures(10 if quick else 40).items():
        yield Bar(f"fractions along random walks, {table}", departure, 1e-12, "1")


def beside_grains(_quick: bool) -> Iterator[Bar]:
    """Courses in steps of 1 ms beside thousands of grains at 0.1 ms: no further from it than its own error."""
    for name, course in COURSES.items():
        wanted = reference(name)
        run, end = kernel_run(course.drive_v, fixed(1e-3))
        off = distance(run, wanted.run)
        for n, output in enumerate(OUTPUTS):
            unit, scale = UNITS[output]
            what = f"{name}, 1 ms, {output} from {GRAINS_OF.get(name, GRAINS)} grains"
            yield Bar(f"{what}, largest", scale * off.largest[n], scale * wanted.largest[n], unit)
            yield Bar(f"{what}, rms", scale * off.rms[n], scale * wanted.rms[n], unit)
        yield Bar(f"{name}, 1 ms, unsolved steps", end.unsolved_steps, 0.0, "1")


def slow_loop_of_long_steps(quick: bool) -> Iterator[Bar]:
    """A slow loop in one step a sample of 50 ms, and in chosen steps, beside converged ones of either kind."""
    drive_v = COURSES["slow loop"].drive_v
    converged = {
        "the kernel at 0.1 ms": kernel_run(drive_v, fixed(1e-4))[0],
        "grains": reference_run(drive_v, 5e-5 if quick else 2e-5, 2560 if quick else 5120),
    }
    for steps, stepping in (("50 ms", fixed(SAMPLE_S)), ("chosen steps", StepControl())):
        run, _ = kernel_run(drive_v, stepping)
        for name, wanted in converged.items():
            off = distance(run, wanted).largest
            gap = abs(run.strain_gap_pct - wanted.strain_gap_pct)
            for found, bar, (unit, scale), output in (
                (off[0], SLOW_BARS[0], UNITS["temperature_k"], "temperature"),
                (off[1], SLOW_BARS[1], UNITS["resistance_ohm"], "resistance"),
                (gap, SLOW_BARS[2], ("points", 1.0), "gap"),
            ):
                yield Bar(f"slow loop, {steps}, {output} from {name}", scale * found, scale * bar, unit)


def nudged(_quick: bool) -> Iterator[Bar]:
    """A nanokelvin in the air: what it moves, at fixed steps and at chosen ones."""
    names = ("slow loop", "staircase", "jumps to 3.6 V")
    warm_k = shipped()[2]["ambient_temperature_k"] + NUDGE_K
    warmer = with_bench(shipped(), ambient_temperature_k=warm_k)
    for name in names:
        drive_v = COURSES[name].drive_v
        for steps, stepping, bar_k in (
            ("1 ms", fixed(1e-3), NUDGE_MOVES_K),
            ("10 ms", fixed(10e-3), NUDGE_MOVES_K),
            ("50 ms", fixed(50e-3), NUDGE_MOVES_K),
            ("chosen steps", StepControl(), StepControl().temperature_k),
        ):
            off = distance(kernel_run(drive_v, stepping, warmer)[0], kernel_run(drive_v, stepping)[0])
            yield Bar(f"{name}, {steps}: 1e-9 K in the air moves a temperature by", off.largest[0], bar_k, "K")


def chosen_steps(_quick: bool) -> Iterator[Bar]:
    """Chosen steps, beside the kernel at 0.1 ms: every sample within twice the tolerances of a step."""
    tolerances = StepControl()
    for name, course in COURSES.items():
        wanted, _ = kernel_run(course.drive_v, fixed(1e-4))
        run, end = kernel_run(course.drive_v, tolerances)
        off = distance(run, wanted).largest
        ohm = float(wanted.columns[1].max())
        steps = end.evaluations / course.drive_v.size
        what = f"{name}, chosen steps ({steps:.1f} evaluations a sample)"
        for found, bar, (unit, scale), output in (
            (off[0], tolerances.temperature_k, UNITS["temperature_k"], "temperature"),
            (off[1], tolerances.resistance * ohm, UNITS["resistance_ohm"], "resistance"),
            (off[2], tolerances.strain, UNITS["contraction"], "contraction"),
        ):
            yield Bar(f"{what}, {output}", scale * found, 2.0 * scale * bar, unit)


def step_distances(course: Course) -> tuple[Array, Array]:
    """Return distances from the finest step over the ladder of steps, (n_steps, 3, n_samples), and the finest run."""
    finest = kernel_run(course.drive_v, fixed(FINEST_STEP_S))[0].columns
    return np.array([np.abs(kernel_run(course.drive_v, fixed(s))[0].columns - finest) for s in ORDER_STEPS_S]), finest


def order_of(found: Array) -> Array:
    """Return the slope of log distance over log step by least squares, for each output."""
    return np.asarray(np.polyfit(np.log(ORDER_STEPS_S), np.log(found), 1)[0])


def orders(_quick: bool) -> Iterator[Bar]:
    """The order of the step where the course is smooth: the median sample, which no kink has just passed."""
    for name in ("slow loop", "jumps to 3.6 V"):
        found, _ = step_distances(COURSES[name])
        for n, output in enumerate(OUTPUTS):
            smooth = float(order_of(np.median(found[:, n], axis=1)))
            yield Bar(f"{name}: order of {output}, median sample", smooth, 1.8, "1", least=True)


def friction(quick: bool) -> Iterator[Bar]:
    """The guide's friction that a loop shows, over all combinations of friction, presliding and step."""
    for friction_n in FRICTIONS_N[::4] if quick else FRICTIONS_N:
        worst, least_stroke = 0.0, math.inf
        for presliding_m in (PRESLIDINGS_M[0], PRESLIDINGS_M[-1]) if quick else PRESLIDINGS_M:
            case = case_of(friction_n, presliding_m)
            for step_s in STEPS_S[1:] if quick else STEPS_S:
                found = shown(case, step_s)
                worst, least_stroke = max(worst, found.worst), min(least_stroke, found.stroke_m)
        yield Bar(f"friction of {friction_n:g} N, worst of all presliding and steps: off by", 100.0 * worst, 2.0, "%")
        yield Bar(f"friction of {friction_n:g} N: least stroke", 1e3 * least_stroke, 1.0, "mm", least=True)


def random_wires(quick: bool) -> Iterator[Bar]:
    """Random wires and loads with jumps to the largest drive: unsolved steps, and 10 ms beside 1 ms.

    Where the drive is raised in air that cools more, the bar on the distance is twice that of the wires' own drives.
    """
    count = 100 if quick else 500
    for drive, as_hot, bar_mk in (("own largest drive", False, 50.0), ("drive raised to be as hot", True, 100.0)):
        found, refused = outcomes(count, 12, as_hot=as_hot)
        off_k = np.array([one.distance_k for one in found])
        contract = float(np.mean([one.stroke > 0.01 for one in found]))
        what = f"{count} random wires, {drive}"
        yield Bar(f"{what}: unsolved steps", sum(one.unsolved for one in found), 0.0, "1")
        yield Bar(f"{what}: 10 ms from 1 ms, largest", 1e3 * off_k.max(), bar_mk, "mK")
        yield Bar(f"{what}: 10 ms from 1 ms, median", 1e3 * float(np.median(off_k)), 10.0, "mK")
        yield Bar(f"{what}: contract by more than 1 % ({refused} draws refused)", contract, 0.3, "1", least=True)


PARTS: tuple[Callable[[bool], Iterator[Bar]], ...] = (
    walks,
    beside_grains,
    slow_loop_of_long_steps,
    chosen_steps,
    nudged,
    orders,
    friction,
    random_wires,
)


def print_bar(bar: Bar) -> None:
    """Print one bar on one line."""
    sign = ">=" if bar.least else "<="
    print(
        f"{'    ' if bar.holds else 'MISS'} {bar.what:82}{bar.found:12.4g} {sign} {bar.bar:<9.4g} {bar.unit}",
        flush=True,
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer random wires and combinations of friction")
    parser.add_argument("--only", choices=[part.__name__ for part in PARTS], action="append", help="only this part")
    parser.add_argument("--json", action="store_true", help="one JSON document instead of lines")
    arguments = parser.parse_args()
    found = []
    for part in PARTS:
        if arguments.only and part.__name__ not in arguments.only:
            continue
        for bar in part(arguments.quick):
            found.append(bar)
            if not arguments.json:
                print_bar(bar)
    missed = [bar for bar in found if not bar.holds]
    if arguments.json:
        rows = [{**bar._asdict(), "holds": bar.holds} for bar in found]
        print(json.dumps({"bars": rows, "missed": len(missed)}, indent=2))
    else:
        print(f"{len(missed)} of {len(found)} bars missed")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
