"""Which fits end with 0: of 40 drawn recordings with defects none whose loop is wrong, of 40 sound ones all but one.

A loop is wrong if more than 0.5 % of its valid samples are more than 5 % of the measured stroke off.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.random import Generator
from tests.labs.loops import DEFECTS, LOOPS, SHUNT_OHM, Array, Loop, loop

from musclewire.identify import estimate
from musclewire.sensing import SensingModel, load_model
from musclewire.signals import Recording

Command = Callable[..., Any]
COLUMNS = ("time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m")
# What a usual card adds to each voltage, and a usual sensor to the displacement, of their largest values.
VOLTAGE_NOISE, DISPLACEMENT_NOISE = 2e-4, 5e-4


def recorded(columns: Loop, random: Generator) -> Recording:
    """Return a loop with the noise of sound instruments."""

    def noisy(name: str) -> Array:
        size = 0.0 if name == "time_s" else DISPLACEMENT_NOISE if name == "displacement_m" else VOLTAGE_NOISE
        values = columns[name]
        return values + size * np.abs(values).max() * random.standard_normal(values.size)

    return Recording({name: noisy(name) for name in COLUMNS}, {"shunt_resistance_ohm": SHUNT_OHM})


def damaged(number: int) -> Recording:
    """Return a drawn loop with one defect or more."""
    random = np.random.default_rng([48, number])
    columns: Loop = loop(str(random.choice(LOOPS)))
    count = int(random.integers(1, 4))
    for place in np.sort(random.choice(len(DEFECTS), count, replace=False)).tolist():
        columns = DEFECTS[place](columns, random)
    return recorded(columns, random)


def sound(number: int) -> Recording:
    """Return a drawn loop as its wire made it, of 100 samples or more: the most that a coarse one has is 90."""
    random = np.random.default_rng([49, number])
    every = int(random.integers(1, 4))
    columns = {name: values[::every] for name, values in loop(str(random.choice(LOOPS))).items()}
    return recorded(columns, random)


def wrong_pct(model: SensingModel, recording: Recording) -> float:
    """Return the share of valid samples that are more than 5 % of the measured stroke wrong, from the columns alone."""
    moved_m = recording["displacement_m"]
    found = estimate(model, recording).recording
    off = np.abs(found["estimated_displacement_m"] - moved_m) / np.ptp(moved_m)
    counted = (found["valid"] > 0.0) & (moved_m >= model.quantity_min)
    return 100.0 * float(np.mean(off[counted] > 0.05)) if counted.any() else 100.0


def fitted(command: Command, folder: Path, recordings: list[Recording]) -> tuple[int, list[int]]:
    """Return how many fits end with 0, and which of those are wrong; both are printed."""
    ended_with_0, wrong = 0, []
    for number, recording in enumerate(recordings):
        loop_file, model_file = folder / f"{number}.h5", folder / f"{number}.json"
        recording.save(loop_file)
        if command("fit", loop_file, "--quantity", "displacement", "-o", model_file).code == 0:
            ended_with_0 += 1
            if wrong_pct(load_model(model_file), recording) > 0.5:
                wrong.append(number)
    print(f"{ended_with_0} of {len(recordings)} end with 0, of which wrong: {wrong}")
    return ended_with_0, wrong


@pytest.mark.parametrize("count", [4, pytest.param(40, marks=pytest.mark.slow)])
def test_no_fit_with_defects_ends_with_0_and_is_wrong(count: int, musclewire: Command, tmp_path: Path) -> None:
    ended_with_0, wrong = fitted(musclewire, tmp_path, [damaged(number) for number in range(count)])
    assert not wrong
    assert 0 < ended_with_0 < count


def test_sound_fits_end_with_0(musclewire: Command, tmp_path: Path) -> None:
    assert fitted(musclewire, tmp_path, [sound(number) for number in range(4)]) == (4, [])


@pytest.mark.slow
def test_all_but_one_of_40_sound_fits_end_with_0(musclewire: Command, tmp_path: Path) -> None:
    ended_with_0, _ = fitted(musclewire, tmp_path, [sound(number) for number in range(40)])
    assert ended_with_0 >= 39
