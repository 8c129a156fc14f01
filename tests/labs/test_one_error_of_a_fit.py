"""One error everywhere: of the loop's estimator, in percent of the measured stroke; and fits that do not hold."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.labs.loops import LOOPS, SHUNT_OHM, loop, step_with_the_current

from musclewire.errors import CallerError
from musclewire.identify import estimate, fit, known_against
from musclewire.sensing import SensingModel, load_model
from musclewire.signals import Recording


def recorded(columns: dict[str, np.ndarray]) -> Recording:
    kept = {name: columns[name] for name in ("time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m")}
    return Recording(kept, {"shunt_resistance_ohm": SHUNT_OHM})


def stepped(name: str = "grains") -> Recording:
    """A loop whose resistance is lower as soon as more than the idle current measures it."""
    return recorded(dict(step_with_the_current(loop(name), np.random.default_rng(5))))


@pytest.mark.parametrize("name", LOOPS)
def test_the_error_is_that_of_the_loops_estimator_in_percent_of_the_measured_stroke(name: str) -> None:
    recording = recorded(loop(name))
    model = fit(recording, quantity="displacement")
    report = estimate(model, recording)
    moved_m = recording["displacement_m"]
    assert model.measured_stroke == pytest.approx(np.ptp(moved_m), rel=0.01)
    again = estimate(model, recording, estimator="filter").recording
    counted = (again["valid"] > 0.0) & (moved_m >= model.quantity_min)
    off_pct = 100.0 * (again["estimated_displacement_m"] - moved_m)[counted] / model.measured_stroke
    assert report.estimator == "filter"
    assert report.rms_pct == pytest.approx(np.sqrt(np.mean(off_pct**2)), rel=1e-9)
    assert report.max_pct == pytest.approx(np.abs(off_pct).max(), rel=1e-9)
    assert report.wrong_pct == 0.0
    assert model.holds


@pytest.mark.parametrize("name", LOOPS)
def test_a_fit_whose_loop_is_wrong_says_so_and_keeps_it_in_its_file(name: str, tmp_path: Path) -> None:
    model = fit(stepped(name), quantity="displacement")
    assert not model.holds
    said = "of the samples that count in its own loop are more than 5 % of the measured stroke wrong"
    assert said in model.does_not_hold
    assert (model.report()["holds"], "does not hold" in model.summary()) == (False, True)
    path = tmp_path / "model.json"
    model.save(path)
    assert json.loads(path.read_text("utf-8"))["holds"] is False
    assert load_model(path) == model
    assert known_against(model, {}) == {"model_does_not_hold": f"the model does not hold: {model.does_not_hold}"}


@pytest.mark.parametrize(("late", "holds"), [(0.0, True), (0.01, False)])
def test_without_a_current_only_a_loop_with_a_small_gap_is_shown_to_hold(late: float, holds: bool) -> None:
    columns = loop("grains")
    resistance = SHUNT_OHM * columns["wire_voltage_v"] / columns["shunt_voltage_v"]
    time_s, moved_m = columns["time_s"], columns["displacement_m"]
    behind_m = np.interp(time_s - late * np.ptp(time_s), time_s, moved_m)
    model = fit(
        Recording({"time_s": time_s, "wire_resistance_ohm": resistance, "displacement_m": behind_m}),
        quantity="displacement",
    )
    assert model.holds is holds
    assert ("by the estimator polynomial" in model.does_not_hold) is not holds
    assert ("only the average of both branches could be tried" in model.does_not_hold) is not holds


def test_a_file_that_is_said_to_hold_against_its_reason_was_altered(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    fit(stepped(), quantity="displacement").save(path)
    path.write_text(path.read_text("utf-8").replace('"holds": false', '"holds": true'), "utf-8")
    with pytest.raises(CallerError, match="holds contradicts does_not_hold: the file was altered"):
        load_model(path)


def test_a_file_from_before_these_keys_is_read(tmp_path: Path) -> None:
    path = tmp_path / "model.json"
    model = SensingModel(15.0, 17.0, (0.042, -0.04), (0.038, -0.04), 0.0, 1.0)
    model.save(path)
    keys = json.loads(path.read_text("utf-8"))
    for name in ("measured_stroke", "holds", "does_not_hold", "checksum"):
        del keys[name]
    # As it was computed then: over all keys that there were.
    from musclewire.sensing import ModelFile

    keys["checksum"] = ModelFile.model_validate_json(json.dumps(keys)).checksum_of_numbers()
    path.write_text(json.dumps(keys), "utf-8")
    assert load_model(path).holds


def test_a_recording_without_current_takes_the_papers_estimator_and_says_so() -> None:
    columns = loop("grains")
    kept = {name: columns[name] for name in ("time_s", "wire_resistance_ohm", "displacement_m")}
    recording = Recording(kept, {})
    model = fit(recording, quantity="displacement")
    report = estimate(model, recording)
    assert (model.holds, report.estimator) == (True, "polynomial")
    assert report.summary().splitlines()[-1].startswith("estimator polynomial: error ")
