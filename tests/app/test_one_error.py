"""`fit`, `estimate` and `control` of one file: one error, and a model that does not hold."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.labs.loops import SHUNT_OHM, loop, step_with_the_current

from musclewire.experiment import characterize
from musclewire.rigs import open_rig
from musclewire.signals import Recording


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "loop.h5"
    with open_rig("simulated") as rig:
        characterize(rig, cycles=1, path=path)
    return path


def stepped(folder: Path) -> Path:
    """Record a loop whose resistance is lower as soon as more than the idle current measures it."""
    columns = step_with_the_current(loop("segments"), np.random.default_rng(5))
    kept = {name: columns[name] for name in ("time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m")}
    path = folder / "stepped.h5"
    Recording(kept, {"shunt_resistance_ohm": SHUNT_OHM, "leg_length_m": 0.07}).save(path)
    return path


def test_fit_and_estimate_of_one_file_say_the_same_error(
    musclewire: Callable[..., Any], recording: Path, tmp_path: Path
) -> None:
    model = tmp_path / "model.json"
    fitted = musclewire("fit", recording, "-o", model)
    estimated = musclewire("estimate", model, recording)
    assert fitted.code == estimated.code == 0
    last = fitted.out.splitlines()[-1]
    assert last == estimated.out.splitlines()[-1]
    assert last.startswith("estimator filter: error ")
    assert "of the measured stroke; 0.00 % of the samples that count are more than 5 % wrong" in last
    answers = [musclewire(*line, "--json").json for line in (("fit", recording), ("estimate", model, recording))]
    assert len({tuple(one[key] for key in ("rms_pct", "max_pct", "wrong_pct", "valid_share")) for one in answers}) == 1


def test_a_fit_that_does_not_hold_ends_with_1_and_so_does_a_loop_with_it(
    musclewire: Callable[..., Any], tmp_path: Path
) -> None:
    model = tmp_path / "model.json"
    fitted = musclewire("fit", stepped(tmp_path), "-o", model)
    assert (fitted.code, "this model does not hold: by the estimator filter" in fitted.err) == (1, True)
    assert model.exists()
    steps = ("--reference", "1.5 % to 2 % by 0.5 %")
    for more in ((), ("--runs", 1)):
        run = musclewire("control", "simulated", model, *steps, *more)
        assert run.code == 1
        assert "warning: the model does not hold: by the estimator filter" in run.err.splitlines()[0]
