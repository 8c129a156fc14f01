"""The FMU of a wire beside Python: the largest difference of any output, and what a communication step costs.

Runs a slow loop of 90 s and a staircase of voltages with jumps to the largest drive, samples of 50 ms, on the paper's
bench, the finger (a load with tables and friction), a guide with friction, a wire that goes slack, and a new one
(shakedown), with fixed steps of 1 and 10 ms and with steps by tolerance. Prints JSON. A difference is relative to the
output's largest value in the run; a step's cost is the median of five runs, that of the FMU with FMPy's calls to set
the drive and step. Exit code 1 if a difference is above 1e-9. ``--quick`` takes 10 s of each course.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

import musclewire as mw
from musclewire.rigs import RigConfiguration, open_simulated, rig_configuration
from musclewire.wire import OneWire, StepControl, WireConstants, advance, resting_state

SAMPLE_S = 0.05
BAR = 1e-9
STEPS_S = (0.001, 0.01, 0.0)
RUNS = 5
RIGS: dict[str, str | RigConfiguration] = {
    "paper's bench": "simulated",
    "finger": "finger",
    "friction": RigConfiguration(settings={"guide_friction_n": 0.3}),
    "goes slack": RigConfiguration(settings={"guide_friction_n": 0.4, "pretension_n": 0.05}),
    "new wire": RigConfiguration(new_wire=True),
}
OUTPUTS = ("temperature_k", "resistance_ohm", "displacement_m", "force_n", "martensite_fraction", "mean_displacement_m")


def courses(amplitude_v: float, highest_v: float) -> dict[str, np.ndarray[Any, Any]]:
    """Return the drives of both courses [V], one number a sample."""
    loop = amplitude_v * np.sin(np.pi * SAMPLE_S * np.arange(1800) / 90.0)
    levels = np.repeat(amplitude_v * np.array([0.2, 0.6, 0.8, 0.9, 1.0, 0.9, 0.75, 0.85, 0.5, 0.0]), 60)
    levels[240:244] = highest_v
    return {"slow loop of 90 s": loop, "staircase": levels}


def python_rows(constants: WireConstants, drive: np.ndarray[Any, Any], step_s: float) -> list[tuple[float, ...]]:
    """Return Python's outputs after each sample."""
    state, rows = resting_state(constants), []
    section_m2 = constants.legs * constants.area_m2
    for voltage in drive:
        state, means = advance(state, constants, voltage, SAMPLE_S, StepControl(fixed_s=step_s))
        moved_m = state.connector_contraction * constants.leg_length_m
        force_n = state.stress_pa * section_m2
        found = (state.temperature_k, state.resistance_ohm, moved_m, force_n, state.martensite_fraction)
        rows.append((*found, means.displacement_m))
    return rows


def fmu_rows(folder: str, drive: np.ndarray[Any, Any], step_s: float) -> tuple[list[list[float]], float]:
    """Return the FMU's outputs after each sample, and what a step costs [us]."""
    description = fmpy.read_model_description(folder)
    place = {variable.name: variable.valueReference for variable in description.modelVariables}
    slave = fmpy.instantiate_fmu(folder, description, fmi_type="CoSimulation")
    slave.setupExperiment(startTime=0.0)
    slave.setReal([place["step_s"]], [step_s])
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    rows, spent_s = [], 0.0
    drive_place, output_places = [place["drive_voltage_v"]], [place[name] for name in OUTPUTS]
    for index, voltage in enumerate(drive):
        began_s = time.perf_counter()
        slave.setReal(drive_place, [voltage])
        slave.doStep(SAMPLE_S * index, SAMPLE_S)
        spent_s += time.perf_counter() - began_s
        rows.append(slave.getReal(output_places))
    slave.terminate()
    slave.freeInstance()
    return rows, 1e6 * spent_s / len(drive)


def cost_us(run: Callable[[], object], samples: int) -> float:
    """Return what a sample of a run costs [us], the median of some runs."""
    spent = []
    for _ in range(RUNS):
        began_s = time.perf_counter()
        run()
        spent.append(1e6 * (time.perf_counter() - began_s) / samples)
    return statistics.median(spent)


def compared(rig: str, folder: Path, quick: bool) -> list[dict[str, object]]:
    """Return a row for each course and length of step."""
    configuration, where = rig_configuration(RIGS[rig])
    assert isinstance(configuration, RigConfiguration)
    device = open_simulated(configuration, where)
    wires = device.wires
    assert isinstance(wires, OneWire)
    constants = wires.constants
    unpacked = fmpy.extract(str(mw.export_fmu(configuration, folder, overwrite=True).path))
    rows: list[dict[str, object]] = []
    for course, whole in courses(device.facts.drive_amplitude_v, device.facts.limits.maximum_voltage_v).items():
        drive = whole[:200] if quick else whole
        for step_s in STEPS_S:
            python = np.array(python_rows(constants, drive, step_s))
            ours = [fmu_rows(unpacked, drive, step_s) for _ in range(RUNS)]
            difference = np.abs(np.array(ours[0][0]) - python).max(axis=0) / np.abs(python).max(axis=0)
            rows.append(
                {
                    "rig": rig,
                    "course": course,
                    "steps": f"{1e3 * step_s:g} ms" if step_s else "by tolerance",
                    "largest_relative_difference": float(difference.max()),
                    "fmu_us_a_sample": round(statistics.median(cost for _, cost in ours), 2),
                    "python_us_a_sample": round(
                        cost_us(lambda at=step_s, of=drive: python_rows(constants, of, at), len(drive)), 2
                    ),
                }
            )
    return rows


def main() -> int:
    """Compare, print, and judge the differences."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="10 s of each course")
    quick = parser.parse_args().quick
    with tempfile.TemporaryDirectory() as folder:
        rows = [row for rig in RIGS for row in compared(rig, Path(folder), quick)]
    print(json.dumps({"bar": BAR, "runs": rows}, indent=2))
    return 0 if max(float(str(row["largest_relative_difference"])) for row in rows) <= BAR else 1


if __name__ == "__main__":
    sys.exit(main())
