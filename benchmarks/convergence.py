"""How far the simulated wire moves with the time step and with the number of grains, and at which order.

Two parts. The orders: distances of temperature, contraction and resistance from a much finer run, over a ladder of
steps and of grains, along a slow loop and along a fast step, for an alloy of round numbers that no fit moves
(tests/unit/wire/wire_makers.py). The default loop: strain gap (Eq. 2), smallest and largest resistance from B to C
of the wire as shipped, on the paper's bench without instrument noise, and their distance from the finest run.
Prints tables, or one JSON document with --json; --quick leaves the finest runs out.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import find_segments
from musclewire.sensing.gaps import hysteresis_gap
from musclewire.simulate.paths import drive_path
from musclewire.wire.building import constants_from

sys.path.insert(0, str(Path(__file__).parents[1] / "tests/unit/wire"))

from wire_makers import constants

Array = NDArray[np.float64]

PERIOD_S, SAMPLE_S = 90.0, 0.04
SENSE_V, AMPLITUDE_V = 0.3, 3.2
DEFAULT_STEP_S, DEFAULT_GRAINS = 1e-3, 160
# Every step divides a sample.
STEPS_S = (20e-3, 10e-3, 5e-3, 2e-3, 1e-3, 5e-4)
GRAINS = (20, 40, 80, 160, 320, 640)
FINEST_STEP_S, FINEST_GRAINS = 5e-5, 2560
OUTPUTS = ("temperature_k", "contraction", "resistance_ohm")
# Within steep transformation a nanokelvin decides which way a step's prediction overshoots, and moves a distance by
# half. It stands for every other rounding too, so distances are pooled over air that differs by so much.
NANOKELVINS = 4


def slow_sine_v() -> Array:
    """Return the paper's slow cycle, held over each sample."""
    middles = np.arange(0.5, round(PERIOD_S / SAMPLE_S)) * SAMPLE_S
    return SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - np.cos(2.0 * math.pi * middles / PERIOD_S))


def fast_step_v() -> Array:
    """Return 1 s cold, 3 s at the full drive, 6 s of cooling: both ways through the transformation within a second."""
    return np.repeat((SENSE_V, AMPLITUDE_V, SENSE_V), (25, 75, 150))


class Course(NamedTuple):
    """A drive through a wire: what is refined."""

    name: str
    alloy: str
    drive_v: Array


COURSES = (
    Course("slow loop", "round", slow_sine_v()),
    Course("fast step", "round", fast_step_v()),
    # The R-phase temperatures of its grains spread by half a kelvin only.
    Course("sudden start", "narrow", fast_step_v()),
)


class Distances(NamedTuple):
    """Distances from the finest run, (n_cases, 3): root mean square over the course, and the largest."""

    rms: Array
    largest: Array


def outputs(course: Course, dt_s: float, grains: int, warmer_k: float) -> Array:
    """Return temperature and resistance after each sample and the contraction's mean over it, (3, n_samples)."""
    air_k = load_bench("paper").values()["ambient_temperature_k"] + warmer_k
    wire = constants(course.alloy, bench_values={"grains": float(grains), "ambient_temperature_k": air_k})
    path, _ = drive_path(wire, course.drive_v, dt_s=dt_s, steps=round(SAMPLE_S / dt_s))
    return np.array([path.temperature_k, path.displacement_m / wire.leg_length_m, path.resistance_ohm])


def distances(
    course: Course, cases: list[tuple[float, int]], finest: tuple[float, int], nanokelvins: int = NANOKELVINS
) -> Distances:
    """Return how far the cases, each a step and a number of grains, are from the finest one."""
    squares, largest = [], []
    for warmer_k in 1e-9 * np.arange(nanokelvins):
        wanted = outputs(course, *finest, warmer_k)
        off = np.array([outputs(course, *case, warmer_k) - wanted for case in cases])
        squares.append((off**2).mean(axis=2))
        largest.append(np.abs(off).max(axis=2))
    return Distances(np.sqrt(np.mean(squares, axis=0)), np.max(largest, axis=0))


def observed_order(finer: Array, found: Array) -> Array:
    """Return the slope of log distance over log fineness by least squares, for each output, (3,)."""
    return np.asarray(-np.polyfit(np.log(finer), np.log(found), 1)[0])


def step_distances(course: Course, nanokelvins: int = NANOKELVINS) -> Distances:
    """Return the distances over the ladder of steps."""
    cases = [(dt_s, DEFAULT_GRAINS) for dt_s in STEPS_S]
    return distances(course, cases, (FINEST_STEP_S, DEFAULT_GRAINS), nanokelvins)


def grain_distances(course: Course, nanokelvins: int = 1) -> Distances:
    """Return the distances over the ladder of grains, at the finest step: at a coarse one they drown in its error."""
    cases = [(FINEST_STEP_S, grains) for grains in GRAINS]
    return distances(course, cases, (FINEST_STEP_S, FINEST_GRAINS), nanokelvins)


def order_tables() -> list[dict[str, Any]]:
    """Return a table for each course and ladder."""
    step_fineness, grain_fineness = 1.0 / np.array(STEPS_S), np.array(GRAINS, dtype=np.float64)
    tables = []
    for course in COURSES:
        for ladder, fineness, found in (
            ("dt_s", step_fineness, step_distances(course)),
            ("grains", grain_fineness, grain_distances(course)),
        ):
            tables.append(
                {
                    "course": course.name,
                    "alloy": course.alloy,
                    ladder: list(STEPS_S if ladder == "dt_s" else GRAINS),
                    "rms": {name: found.rms[:, n].tolist() for n, name in enumerate(OUTPUTS)},
                    "largest": {name: found.largest[:, n].tolist() for n, name in enumerate(OUTPUTS)},
                    "order_of_rms": dict(zip(OUTPUTS, observed_order(fineness, found.rms).tolist(), strict=True)),
                    "order_of_largest": dict(
                        zip(OUTPUTS, observed_order(fineness, found.largest).tolist(), strict=True)
                    ),
                }
            )
    return tables


def print_orders(tables: list[dict[str, Any]]) -> None:
    for table in tables:
        ladder = "dt_s" if "dt_s" in table else "grains"
        refined = "steps" if ladder == "dt_s" else "grains"
        print(f"{table['course']}, alloy '{table['alloy']}', {refined}: distance from the finest run, rms and largest")
        print(f"{'dt ms' if ladder == 'dt_s' else 'grains':>8}{'T [K]':>20}{'contraction':>22}{'R [ohm]':>22}")
        for n, fineness in enumerate(table[ladder]):
            numbers = "".join(f"{table['rms'][name][n]:12.2e}{table['largest'][name][n]:10.1e}" for name in OUTPUTS)
            print(f"{1e3 * fineness if ladder == 'dt_s' else fineness:8g}{numbers}")
        orders = "".join(
            f"{table['order_of_rms'][name]:12.2f}{table['order_of_largest'][name]:10.2f}" for name in OUTPUTS
        )
        print(f"{'order':>8}{orders}\n")


def loop_numbers(dt_s: float, grains: int) -> dict[str, float]:
    """Return strain gap and resistances of the second cycle of the wire as shipped."""
    bench = load_bench("paper")
    bench = bench.model_copy(update={"grains": bench.grains.model_copy(update={"value": float(grains)})})
    wire = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), bench)
    one = slow_sine_v()
    path, _ = drive_path(wire, np.tile(one, 2), dt_s=dt_s, steps=round(SAMPLE_S / dt_s))
    resistance = path.wire_voltage_v / path.shunt_voltage_v * wire.shunt_resistance_ohm
    segments = find_segments(resistance[one.size :], path.displacement_m[one.size :] / wire.leg_length_m)
    both = np.concatenate((segments.heating[0], segments.cooling[0]))
    return {
        "strain_gap_pct": 100.0 * hysteresis_gap(segments.heating, segments.cooling),
        "resistance_min_ohm": float(both.min()),
        "resistance_max_ohm": float(both.max()),
    }


def study(cases: list[tuple[float, int]]) -> list[dict[str, Any]]:
    """Return one row a case, each with its distance from the last."""
    found = [loop_numbers(*case) for case in cases]
    return [
        {
            "dt_s": dt,
            "grains": grains,
            **numbers,
            "from_finest": {key: value - found[-1][key] for key, value in numbers.items()},
        }
        for (dt, grains), numbers in zip(cases, found, strict=True)
    ]


def print_study(title: str, rows: list[dict[str, Any]]) -> None:
    print(
        f"{title:>10}{'dt ms':>8}{'grains':>8}{'gap %':>10}{'R_min':>11}{'R_max':>11}"
        "   from the finest: gap, R_min, R_max"
    )
    for row in rows:
        off = row["from_finest"]
        print(
            f"{'':10}{1e3 * row['dt_s']:8.2f}{row['grains']:8d}{row['strain_gap_pct']:10.4f}"
            f"{row['resistance_min_ohm']:11.5f}{row['resistance_max_ohm']:11.5f}"
            f"   {off['strain_gap_pct']:+.4f} {off['resistance_min_ohm']:+.5f} {off['resistance_max_ohm']:+.5f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="the default loop only, without its finest runs")
    parser.add_argument("--json", action="store_true", help="one JSON document instead of tables")
    arguments = parser.parse_args()
    last = -1 if arguments.quick else None
    studies = {
        "time step": study([(dt, DEFAULT_GRAINS) for dt in STEPS_S[:last]]),
        "grains": study([(DEFAULT_STEP_S, grains) for grains in GRAINS[:last]]),
    }
    orders = [] if arguments.quick else order_tables()
    if arguments.json:
        print(json.dumps({"orders": orders, "default loop": studies}, indent=2))
        return
    print_orders(orders)
    print("the default loop of the wire as shipped")
    for title, rows in studies.items():
        print_study(title, rows)


if __name__ == "__main__":
    main()
