"""Loops of simulated wires, measured as laboratories measure: the test bed of everything that reads recordings.

The wires are built unlike the model that estimators use: ensembles of grains (``tests/grain_wire``), a wire of many
segments. What they do is kept in ``loops/NAME.csv`` in SI; ``python tests/labs/loops.py`` simulates it again.

A defect takes a loop and returns what an instrument or a wire makes of it in a laboratory.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Columns by our names, in SI, all (n_times,).
Loop = Mapping[str, Array]
Defect = Callable[[Loop, Generator], Loop]

FOLDER = Path(__file__).parent / "loops"
SHUNT_OHM = 0.47
PERIOD_S = 0.2


def loop(name: str) -> dict[str, Array]:
    """Return a loop with everything that a laboratory might measure of it."""
    table = np.genfromtxt(FOLDER / f"{name}.csv", delimiter=",", names=True)
    found = {column: np.asarray(table[column], dtype=np.float64) for column in table.dtype.names}
    return with_followers(found)


def with_followers(found: Mapping[str, Array]) -> dict[str, Array]:
    """Return a loop whose resistance and shunt voltage are those of its voltage and current."""
    voltage_v, current_a = found["wire_voltage_v"], found["wire_current_a"]
    return {**found, "shunt_voltage_v": SHUNT_OHM * current_a, "wire_resistance_ohm": voltage_v / current_a}


def _with_resistance(found: Loop, factor: Array) -> dict[str, Array]:
    return with_followers({**found, "wire_voltage_v": found["wire_voltage_v"] * factor})


def noise_of_the_current(found: Loop, random: Generator) -> Loop:
    """2 % of the resistance at the largest current, 18 % at 15 % of it: an idle current hardly measures."""
    share = found["wire_current_a"] / found["wire_current_a"].max()
    spread = np.minimum(0.02 * share**-1.17, 0.18)
    return _with_resistance(found, 1.0 + spread * random.standard_normal(share.size))


def step_with_the_current(found: Loop, random: Generator) -> Loop:
    """Resistance that is 3.4 to 5 % lower as soon as more than the idle current measures it."""
    drop = random.uniform(0.034, 0.05)
    current_a = found["wire_current_a"]
    return _with_resistance(found, np.where(current_a > 1.1 * current_a.min(), 1.0 - drop, 1.0))


def dead_zone(found: Loop, _: Generator) -> Loop:
    """72 % of the stroke within 2 % of the resistance, as in coils."""
    stroke = found["displacement_m"] / found["displacement_m"].max()
    ohm = found["wire_resistance_ohm"]
    flat = ohm[np.argmax(stroke > 0.28)] * (1.0 - 0.02 * (stroke - 0.28) / 0.72)
    return _with_resistance(found, np.where(stroke > 0.28, flat / ohm, 1.0))


def short_of_the_start(found: Loop, _: Generator) -> Loop:
    """Cooling that ends 10 % of the stroke short of where it began."""
    stroke_m = found["displacement_m"]
    peak = int(np.argmax(stroke_m))
    back = np.where(np.arange(stroke_m.size) > peak, 0.1 * (stroke_m.max() - stroke_m), 0.0)
    return {**found, "displacement_m": stroke_m + back}


def late_motion(found: Loop, random: Generator) -> Loop:
    """Motion that is read up to 50 ms early or late: by another instrument, with a clock of its own."""
    late_s = random.uniform(-0.05, 0.05)
    return {**found, "displacement_m": np.interp(found["time_s"] - late_s, found["time_s"], found["displacement_m"])}


def coil(found: Loop, _: Generator) -> Loop:
    """A coil of the wire: a stroke of 10 mm on 15."""
    return {**found, "displacement_m": found["displacement_m"] * (0.01 / found["displacement_m"].max())}


def coarse(found: Loop, random: Generator) -> Loop:
    """20 to 90 points in all, each long after the one before: a staircase of currents."""
    chosen = np.unique(np.linspace(0, found["time_s"].size - 1, int(random.integers(20, 91))).round().astype(int))
    slow = {name: values[chosen] for name, values in found.items()}
    return {**slow, "time_s": 10.0 * np.arange(chosen.size)}


DEFECTS: tuple[Defect, ...] = (noise_of_the_current, step_with_the_current, dead_zone, short_of_the_start, coil, coarse)
LOOPS = ("grains", "grains_under_a_weight", "segments")


def simulated() -> dict[str, dict[str, Array]]:
    """Simulate the loops: 60 s of a slow sine of voltage, or of a source of current."""
    sys.path.insert(0, str(Path(__file__).parents[1]))
    from grain_wire import grain_wire
    from musclewire.extras.studies import SegmentedConfiguration
    from musclewire.parameters import load_alloy, load_bench, load_wire
    from musclewire.rigs import open_rig

    time_s = PERIOD_S * np.arange(301)
    rise = np.sin(np.pi * time_s / time_s[-1]) ** 2
    alloy = load_alloy("flexinol").values()
    steps = round(PERIOD_S / 0.005)
    spring = grain_wire(alloy, load_wire("paper-100um").values(), load_bench("paper").values())
    driven = spring.drive(0.3 + 2.9 * rise, 0.005, steps)
    weight = grain_wire(alloy, load_wire("flexinol-0.15-lt").values(), load_bench("dead-weight").values())
    fed = weight.drive(0.04 + 0.36 * rise, 0.005, steps, regulated_current=True)
    with open_rig(SegmentedConfiguration()) as rig:
        drives = np.repeat(0.3 + 2.9 * rise, round(PERIOD_S / rig.sample_period_s))
        shunt_ohm = rig.shunt_resistance_ohm
        samples = [rig.exchange(float(drive)) for drive in drives][:: round(PERIOD_S / rig.sample_period_s)]
    segments: dict[str, Array] = {
        "wire_voltage_v": np.array([sample.wire_voltage_v for sample in samples]),
        "wire_current_a": np.array([sample.shunt_voltage_v for sample in samples]) / shunt_ohm,
        "displacement_m": np.array([sample.displacement_m for sample in samples]),
        "force_n": np.array([sample.force_n for sample in samples]),
    }
    found = {
        "grains": _columns(driven),
        "grains_under_a_weight": _columns(fed),
        "segments": segments,
    }
    return {name: {"time_s": time_s, **columns} for name, columns in found.items()}


def _columns(path: object) -> dict[str, Array]:
    voltage_v, ohm = path.wire_voltage_v, path.resistance_ohm  # type: ignore[attr-defined]
    return {
        "wire_voltage_v": voltage_v,
        "wire_current_a": voltage_v / ohm,
        "displacement_m": path.displacement_m,  # type: ignore[attr-defined]
        "force_n": path.force_n,  # type: ignore[attr-defined]
    }


def main() -> None:
    """Write the loops."""
    for name, columns in simulated().items():
        rows = np.column_stack(list(columns.values()))
        np.savetxt(FOLDER / f"{name}.csv", rows, fmt="%.7g", delimiter=",", header=",".join(columns), comments="")


if __name__ == "__main__":
    main()
