"""What it would change if the work that a wire does on its load were part of its heat balance.

A contracting wire does work: its heat pays for it, and on stretching it gets most of that back. The simulated wire
leaves it out, as latent heats are no better known than that. Here the ensemble of grains of tests/grain_wire runs the
same courses with and without the work: prints how much work there is beside the latent heat, and by how much
temperature, resistance, contraction and the strain gap move. Prints a table, or JSON with --json.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import find_segments, hysteresis_gap

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from grain_wire import GrainPath, GrainWire, grain_wire

Array = NDArray[np.float64]

SAMPLE_S, STEP_S, GRAINS = 0.05, 2e-4, 640
SENSE_V = 0.3


def slow_sine_v(amplitude_v: float) -> Array:
    """Return the paper's slow cycle of 90 s."""
    middles = np.arange(0.5, round(90.0 / SAMPLE_S)) * SAMPLE_S
    return SENSE_V + (amplitude_v - SENSE_V) * 0.5 * (1.0 - np.cos(2.0 * np.pi * middles / 90.0))


COURSES = {
    "slow loop, 3.2 V": slow_sine_v(3.2),
    "slow loop, 2.75 V": slow_sine_v(2.75),
    "jumps to 3.6 V": np.repeat((SENSE_V, 3.6, SENSE_V, 2.6, 1.8, 3.6, 0.0), 40),
}


def wire_of(*, work: bool) -> GrainWire:
    """Return the shipped wire on the paper's bench."""
    numbers = (load_alloy("flexinol").values(), load_wire("paper-100um").values(), load_bench("paper").values())
    return grain_wire(*numbers, grains=GRAINS, work=work)


def gap_pct(path: GrainPath, wire: GrainWire) -> float | None:
    """Return the strain gap of a loop [%], None of a course that is no loop."""
    ohm = path.wire_voltage_v / path.shunt_voltage_v * wire.value("shunt_resistance_ohm")
    found = find_segments(ohm, path.displacement_m / wire.value("leg_length_m"))
    return 100.0 * float(hysteresis_gap(found.heating, found.cooling))


def row_of(name: str) -> dict[str, float | str | None]:
    """Return what a course shows with the work, less what it shows without."""
    wires = {work: wire_of(work=work) for work in (False, True)}
    paths = {work: wire.drive(COURSES[name], STEP_S, round(SAMPLE_S / STEP_S)) for work, wire in wires.items()}
    without, with_work = paths[False], paths[True]
    top = int(without.displacement_m.argmax()) + 1
    work_j = float(np.trapezoid(without.force_n[:top], without.displacement_m[:top]))
    freed = without.martensite_fraction[0] - without.martensite_fraction[:top].min()
    leg_m = wires[False].value("leg_length_m")
    loop = name.startswith("slow")
    gaps = [gap_pct(paths[work], wires[work]) for work in (False, True)] if loop else [0.0, 0.0]
    return {
        "course": name,
        "work_mj": 1e3 * work_j,
        "latent_heat_mj": 1e3 * wires[False].value("latent_heat_j") * float(freed),
        "temperature_k": float(np.abs(with_work.temperature_k - without.temperature_k).max()),
        "resistance_mohm": 1e3 * float(np.abs(with_work.resistance_ohm - without.resistance_ohm).max()),
        "contraction_points": 100.0 * float(np.abs(with_work.displacement_m - without.displacement_m).max()) / leg_m,
        "gap_points": gaps[1] - gaps[0] if loop else None,
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON document instead of a table")
    arguments = parser.parse_args()
    rows = [row_of(name) for name in COURSES]
    if arguments.json:
        print(json.dumps({"rows": rows}, indent=2))
        return
    print(f"{'largest change by the work':28}{'work mJ':>9}{'latent mJ':>11}{'T [K]':>9}{'R [mohm]':>10}", end="")
    print(f"{'contraction [points]':>22}{'gap [points]':>14}")
    for row in rows:
        gap = "" if row["gap_points"] is None else f"{row['gap_points']:+.4f}"
        print(
            f"{row['course']:28}{row['work_mj']:9.2f}{row['latent_heat_mj']:11.1f}{row['temperature_k']:9.3f}"
            f"{row['resistance_mohm']:10.1f}{row['contraction_points']:22.4f}{gap:>14}"
        )


if __name__ == "__main__":
    main()
