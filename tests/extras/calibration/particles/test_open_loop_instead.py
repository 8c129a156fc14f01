"""A particle filter that is never valid: ``estimate`` simulates the wire file open loop, and says that it did."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.command_line import CommandLine

import musclewire as mw
from musclewire.errors import RecordingError
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.sensing import SensingModel
from musclewire.signals import Recording
from musclewire.wire import constants_from, drive_path

PERIOD_S, LOOP_S, CONTACT_OHM = 0.05, 20.0, 4.0
WIRE = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
FACTS = {
    "wire_length_m": 0.14,
    "leg_length_m": 0.07,
    "shunt_resistance_ohm": 1.0,
    "pretension_n": 1.9,
    "spring_stiffness_n_per_m": 588.6,
}


def swept(contact_ohm: float = 0.0, air_k: float = 0.0, loops: int = 2) -> Recording:
    """A wire that is swept, in other air than that of its wire file, and with a contact between the clamps."""
    time_s = PERIOD_S * np.arange(1, round(loops * LOOP_S / PERIOD_S) + 1)
    drive_v = 0.3 + 1.4 * (1.0 - np.cos(2.0 * np.pi * time_s / LOOP_S))
    wire = WIRE.replace(ambient_temperature_k=float(WIRE.ambient_temperature_k) + air_k)
    path, _ = drive_path(wire, drive_v, sample_s=PERIOD_S)
    columns = {
        "time_s": time_s,
        "drive_voltage_v": drive_v,
        "wire_voltage_v": path.wire_voltage_v + contact_ohm * path.shunt_voltage_v,
        "shunt_voltage_v": path.shunt_voltage_v,
        "displacement_m": path.displacement_m,
        "force_n": path.force_n,
    }
    return Recording(columns, FACTS)


def by(wire_file: Path) -> dict[str, Any]:
    """The particle filter with a wire file."""
    return {"estimator": "particle-filter", "wire_file": wire_file}


@pytest.fixture(scope="module")
def model() -> SensingModel:
    return mw.fit(swept())


@pytest.mark.parametrize("air_k", [-2.0, 0.0, 2.0])
def test_a_contact_leaves_the_simulation_within_the_deviation_that_it_states(
    model: SensingModel, wire_file: Path, air_k: float
) -> None:
    recording = swept(CONTACT_OHM, air_k, loops=1)
    report = mw.estimate(model, recording, **by(wire_file))
    assert report.estimator == "open-loop simulation"
    assert "100.0 % at resistances that this wire never has" in report.fell_back
    found = report.recording
    assert found.metadata["estimate_fell_back"] == report.fell_back
    assert found["valid"].all()
    off = np.abs(found["estimated_strain"] - recording["displacement_m"] / 0.07)
    assert np.mean(off <= 1.96 * found["estimate_std"]) >= 0.95
    assert report.rms_pct is not None
    assert report.rms_pct < (0.5 if air_k == 0.0 else 6.0)


@pytest.mark.parametrize("quantity", ["displacement", "force"])
def test_displacement_and_force_are_simulated_too(wire_file: Path, quantity: str) -> None:
    model = mw.fit(swept(), quantity=quantity)
    report = mw.estimate(model, swept(CONTACT_OHM, loops=1), **by(wire_file))
    assert report.fell_back
    assert report.rms_pct is not None
    assert report.rms_pct < 0.5


def test_a_sample_now_and_then_is_simulated_on_a_finer_clock(model: SensingModel, wire_file: Path) -> None:
    recording = swept(CONTACT_OHM, loops=1)
    seldom = Recording({name: values[::10] for name, values in recording.columns.items()}, FACTS)
    report = mw.estimate(model, seldom, **by(wire_file))
    assert report.fell_back
    assert report.rms_pct is not None
    assert report.rms_pct < 1.0


def test_an_instrument_that_was_silent_for_a_while_is_not_compared_with(model: SensingModel, wire_file: Path) -> None:
    recording = swept(CONTACT_OHM, loops=1)
    moved_m = recording["displacement_m"].copy()
    moved_m[100:110] = np.nan
    report = mw.estimate(model, recording.with_columns({"displacement_m": moved_m}), **by(wire_file))
    assert report.fell_back
    assert report.rms_pct is not None
    assert report.rms_pct < 0.5


def test_a_filter_with_valid_samples_and_an_estimator_without_a_wire_stay_what_they_are(
    model: SensingModel, wire_file: Path
) -> None:
    assert mw.estimate(model, swept(loops=1), **by(wire_file)).fell_back == ""
    with pytest.raises(RecordingError, match="no sample lies in the model's range"):
        mw.estimate(model, swept(CONTACT_OHM, loops=1), estimator="filter")


def test_a_current_that_is_not_known_is_no_simulation(model: SensingModel, wire_file: Path) -> None:
    recording = swept(CONTACT_OHM, loops=1)
    shunt_v = recording["shunt_voltage_v"].copy()
    shunt_v[200:220] = 9.9e37  # what a meter writes that is overloaded
    with pytest.raises(RecordingError, match=r"nor by simulation: .* not known in 20 rows"):
        mw.estimate(model, recording.with_columns({"shunt_voltage_v": shunt_v}), **by(wire_file))


def test_the_command_writes_it_says_so_and_ends_with_1(
    model: SensingModel, wire_file: Path, musclewire: CommandLine, tmp_path: Path
) -> None:
    model_path, recorded, out = tmp_path / "model.json", tmp_path / "contact.h5", tmp_path / "out.h5"
    model.save(model_path)
    swept(CONTACT_OHM, loops=1).save(recorded)
    named = ("--estimator", "particle-filter", "--wire-file", wire_file)
    run = musclewire("estimate", model_path, recorded, *named, "-o", out, "--json")
    assert run.code == 1
    assert run.json["estimator"] == "open-loop simulation"
    assert run.json["fell_back"].startswith("no sample of the particle filter is valid")
    assert "not the estimate that was asked for" in run.err
    assert mw.read_recording(out).metadata["estimate_fell_back"] == run.json["fell_back"]
