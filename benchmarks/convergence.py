"""How far the simulated wire moves with the time step, at which order, and how many grains lead to its fronts.

Three parts. The order of the step: distances of temperature, contraction and resistance from a much finer run, over a
ladder of steps, along a slow loop and along a fast step, for alloys of round numbers that no fit moves
(tests/unit/wire/wire_makers.py). The fronts as the limit of many grains: distances of the ensemble of grains of
tests/grain_wire from the fronts, over a ladder of grains. The default loop: strain gap (Eq. 2), smallest and largest
resistance from B to C of the wire as shipped, on the paper's bench without instrument noise, and their distance from
the finest run. Prints tables, or one JSON document with --json; --quick leaves all but the default loop out.
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
from musclewire.sensing import find_segments, hysteresis_gap
from musclewire.wire import StepControl, constants_from, drive_path, fixed_steps

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests/unit/wire"))

from wire_makers import alloy, bench, constants, wire_100um

from grain_wire import grain_wire

Array = NDArray[np.float64]

PERIOD_S, SAMPLE_S = 90.0, 0.04
SENSE_V, AMPLITUDE_V = 0.3, 3.2
# Every step divides a sample.
STEPS_S = (40e-3, 20e-3, 10e-3, 5e-3, 2e-3, 1e-3)
GRAINS = (20, 40, 80, 160, 320, 640)
FINEST_STEP_S, GRAINS_STEP_S = 5e-5, 2e-5
OUTPUTS = ("temperature_k", "contraction", "resistance_ohm")
# Below this step a slow loop is as exact as its equations are solved: the order is that of the longer steps.
ORDER_FROM_S = 5e-3


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


def outputs(course: Course, step_s: float) -> Array:
    """Return temperature and resistance after each sample and the contraction's mean over it, (3, n_samples)."""
    wire = constants(course.alloy)
    path, _ = drive_path(wire, course.drive_v, sample_s=SAMPLE_S, stepping=fixed_steps(step_s))
    return np.array([path.temperature_k, path.displacement_m / wire.leg_length_m, path.resistance_ohm])


def outputs_of_grains(course: Course, grains: int) -> Array:
    """Return the same of an ensemble of so many grains."""
    wire = grain_wire(alloy(course.alloy).values(), wire_100um().values(), bench().values(), grains=grains)
    path = wire.drive(course.drive_v, GRAINS_STEP_S, round(SAMPLE_S / GRAINS_STEP_S))
    return np.array([path.temperature_k, path.displacement_m / wire.value("leg_length_m"), path.resistance_ohm])


def distances(found: list[Array], wanted: Array) -> Distances:
    """Return how far courses are from another, each (3, n_samples)."""
    off = np.array([each - wanted for each in found])
    return Distances(np.sqrt((off**2).mean(axis=2)), np.abs(off).max(axis=2))


def observed_order(finer: Array, found: Array) -> Array:
    """Return the slope of log distance over log fineness by least squares, for each output, (3,)."""
    return np.asarray(-np.polyfit(np.log(finer), np.log(found), 1)[0])


def observed_order_of_steps(found: Array) -> Array:
    """Return the order of distances over the ladder of steps, for each output, (3,)."""
    counted = sum(step_s >= ORDER_FROM_S for step_s in STEPS_S)
    return observed_order(1.0 / np.array(STEPS_S[:counted]), found[:counted])


def observed_order_of_grains(found: Array) -> Array:
    """Return the order of distances over the ladder of grains, for each output, (3,)."""
    return observed_order(np.array(GRAINS, dtype=np.float64), found)


def step_distances(course: Course) -> Distances:
    """Return the distances over the ladder of steps from the finest step."""
    return distances([outputs(course, step_s) for step_s in STEPS_S], outputs(course, FINEST_STEP_S))


def grain_distances(course: Course) -> Distances:
    """Return the distances of ever more grains from the fronts, both in steps so fine that those do not count."""
    return distances([outputs_of_grains(course, grains) for grains in GRAINS], outputs(course, FINEST_STEP_S))


def order_tables() -> list[dict[str, Any]]:
    """Return a table for each course and ladder."""
    tables = []
    for course in COURSES:
        for ladder, values, found, order in (
            ("step_s", STEPS_S, step_distances(course), observed_order_of_steps),
            ("grains", GRAINS, grain_distances(course), observed_order_of_grains),
        ):
            tables.append(
                {
                    "course": course.name,
                    "alloy": course.alloy,
                    ladder: list(values),
                    "rms": {name: found.rms[:, n].tolist() for n, name in enumerate(OUTPUTS)},
                    "largest": {name: found.largest[:, n].tolist() for n, name in enumerate(OUTPUTS)},
                    "order_of_rms": dict(zip(OUTPUTS, order(found.rms).tolist(), strict=True)),
                    "order_of_largest": dict(zip(OUTPUTS, order(found.largest).tolist(), strict=True)),
                }
            )
    return tables


def print_orders(tables: list[dict[str, Any]]) -> None:
    for table in tables:
        ladder = "step_s" if "step_s" in table else "grains"
        from_what = "steps: distance from the finest run" if ladder == "step_s" else "grains: distance from the fronts"
        print(f"{table['course']}, alloy '{table['alloy']}', {from_what}, rms and largest")
        print(f"{'ms' if ladder == 'step_s' else 'grains':>8}{'T [K]':>20}{'contraction':>22}{'R [ohm]':>22}")
        for n, fineness in enumerate(table[ladder]):
            numbers = "".join(f"{table['rms'][name][n]:12.2e}{table['largest'][name][n]:10.1e}" for name in OUTPUTS)
            print(f"{1e3 * fineness if ladder == 'step_s' else fineness:8g}{numbers}")
        orders = "".join(
            f"{table['order_of_rms'][name]:12.2f}{table['order_of_largest'][name]:10.2f}" for name in OUTPUTS
        )
        print(f"{'order':>8}{orders}\n")


def loop_numbers(stepping: StepControl) -> dict[str, float]:
    """Return strain gap and resistances of the second cycle of the wire as shipped."""
    wire = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
    one = slow_sine_v()
    path, _ = drive_path(wire, np.tile(one, 2), sample_s=SAMPLE_S, stepping=stepping)
    resistance = path.wire_voltage_v / path.shunt_voltage_v * wire.shunt_resistance_ohm
    segments = find_segments(resistance[one.size :], path.displacement_m[one.size :] / wire.leg_length_m)
    both = np.concatenate((segments.heating[0], segments.cooling[0]))
    return {
        "strain_gap_pct": 100.0 * hysteresis_gap(segments.heating, segments.cooling),
        "resistance_min_ohm": float(both.min()),
        "resistance_max_ohm": float(both.max()),
    }


def study(finest_step_s: float) -> list[dict[str, Any]]:
    """Return one row for chosen steps and one for each fixed step, each with its distance from the finest."""
    finest = loop_numbers(fixed_steps(finest_step_s))
    cases = {"chosen": StepControl(), **{f"{1e3 * step_s:g} ms": fixed_steps(step_s) for step_s in STEPS_S}}
    found = {name: loop_numbers(stepping) for name, stepping in cases.items()}
    found[f"{1e3 * finest_step_s:g} ms"] = finest
    return [
        {"steps": name, **numbers, "from_finest": {key: value - finest[key] for key, value in numbers.items()}}
        for name, numbers in found.items()
    ]


def print_study(rows: list[dict[str, Any]]) -> None:
    print(f"{'steps':>10}{'gap %':>10}{'R_min':>11}{'R_max':>11}   from the finest: gap, R_min, R_max")
    for row in rows:
        off = row["from_finest"]
        print(
            f"{row['steps']:>10}{row['strain_gap_pct']:10.4f}{row['resistance_min_ohm']:11.5f}"
            f"{row['resistance_max_ohm']:11.5f}"
            f"   {off['strain_gap_pct']:+.5f} {off['resistance_min_ohm']:+.6f} {off['resistance_max_ohm']:+.6f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="the default loop only")
    parser.add_argument("--json", action="store_true", help="one JSON document instead of tables")
    arguments = parser.parse_args()
    rows = study(2e-4 if arguments.quick else FINEST_STEP_S)
    orders = [] if arguments.quick else order_tables()
    if arguments.json:
        print(json.dumps({"orders": orders, "default loop": rows}, indent=2))
        return
    print_orders(orders)
    print("the default loop of the wire as shipped")
    print_study(rows)


if __name__ == "__main__":
    main()
