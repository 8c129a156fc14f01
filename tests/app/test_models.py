"""Models from the command line: one error of one file, ways to fit that parts add, and relative resistance."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import numpy as np
import pytest
import typer
from tests.command_line import CommandLine
from tests.labs.loops import SHUNT_OHM, loop, step_with_the_current

import musclewire as mw
from musclewire.experiment import characterize
from musclewire.manifest import Manifest, manifests
from musclewire.rigs import open_rig
from musclewire.signals import Recording

# `fit`, `estimate` and `control` of one file: one error, and a model that does not hold.


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
    musclewire: CommandLine, recording: Path, tmp_path: Path
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
    musclewire: CommandLine, tmp_path: Path
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


# A way to fit that a part offers by its manifest: its options are those of ``fit``, what it says is in the answer.


@dataclass(frozen=True)
class ByGuess:
    """Takes the motion of the recording, and says that its stroke may be off by a tenth."""

    guess: Annotated[str | None, typer.Option("--guess")] = None

    def asked_for(self, *, relative_resistance: bool) -> bool:
        return self.guess is not None and not relative_resistance

    def fit(self, recording: Recording, order: int | str, quantity: str) -> Any:
        model = mw.fit(recording, order=order, quantity=quantity)
        return SimpleNamespace(model=model, stroke=0.04, stroke_std=0.004, misfit=float(self.guess or 0.0))


@pytest.fixture
def short_loop(tmp_path: Path) -> Path:
    with mw.open_rig("simulated") as rig:
        mw.characterize(rig, cycles=1, period_s=20.0, path=tmp_path / "loop.h5")
    return tmp_path / "loop.h5"


def test_a_part_adds_a_way_to_fit_with_options_of_its_own(
    short_loop: Path, musclewire: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = (*manifests(), Manifest("own", fits={"by guess": f"{__name__}:ByGuess"}))
    monkeypatch.setattr("musclewire.manifest.manifests", lambda: parts)
    guessed = musclewire("fit", short_loop, "--guess", "3", "--json").json
    assert guessed["misfit"] == 3.0
    assert guessed["stroke_std_pct"] == pytest.approx(10.0)
    assert "misfit" not in musclewire("fit", short_loop, "--json").json


def test_an_option_of_a_part_that_is_not_there_is_answered_by_the_part(
    musclewire: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    others = tuple(one for one in manifests() if one.name != "calibration")
    monkeypatch.setattr("musclewire.manifest.manifests", lambda: others)
    answer = musclewire("fit", "loop.h5", "--wire", "flexinol-0.10-lt")
    assert answer.code == 2
    assert "'fit --wire' belongs to the part 'calibration'" in answer.err


# ``fit --relative-resistance``: what it makes reads the recordings of another wire of the kind, and moves none.


def test_a_relative_model_is_fitted_estimates_another_wire_and_is_refused_by_a_rig(
    musclewire: CommandLine, tmp_path: Path
) -> None:
    loop_file, other_file, model_file = (tmp_path / name for name in ("loop.h5", "other.h5", "model.json"))
    with mw.open_rig("simulated") as rig:
        loop = mw.characterize(rig, period_s=20.0)
    loop.save(loop_file)
    columns = {name: values for name, values in loop.columns.items() if name != "drive_voltage_v"}
    Recording({**columns, "wire_voltage_v": 1.2 * loop["wire_voltage_v"]}, loop.metadata).save(other_file)
    made = musclewire("fit", loop_file, "--relative-resistance", "-o", model_file, "--json")
    assert made.code == 0
    assert made.json["resistance_max_ohm"] < 1.1
    own, other = (musclewire("estimate", model_file, file, "--json").json for file in (loop_file, other_file))
    assert abs(other["rms_pct"] - own["rms_pct"]) < 0.05
    refused = musclewire("control", "simulated", model_file)
    assert refused.code == 2
    assert "--relative-resistance" in refused.err
