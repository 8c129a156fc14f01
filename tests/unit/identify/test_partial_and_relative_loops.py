"""Recordings that are no whole loop of this wire: heating or cooling alone, a part; and another wire of its kind."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.errors import CallerError, RecordingError
from musclewire.experiment import characterize, control
from musclewire.identify import estimate, fit, tune
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel
from musclewire.signals import Recording

# Another wire or coil of the kind has so many times the resistance.
OTHER = 1.3


@pytest.fixture(scope="module")
def loop() -> Recording:
    with open_rig("simulated") as rig:
        return characterize(rig, period_s=30.0)


@pytest.fixture(scope="module")
def model(loop: Recording) -> SensingModel:
    return fit(loop)


def part_of(loop: Recording, part: str) -> Recording:
    """The first cycle's heating or cooling, a heating that ends half way, or a cooling that does."""
    stroke = loop["displacement_m"][: len(loop) // 2]
    hot, half = int(np.argmax(stroke)), 0.5 * stroke.max()
    rows = {
        "heating": slice(0, hot + 1),
        "cooling": slice(hot, stroke.size),
        "half of heating": slice(0, int(np.argmax(stroke > half)) + 1),
        "half of cooling": slice(0, hot + int(np.argmax(stroke[hot:] < half))),
    }[part]
    return Recording({name: values[rows] for name, values in loop.columns.items()}, loop.metadata)


@pytest.mark.parametrize(
    ("part", "said"),
    [
        ("heating", "no complete cycle: the recording holds only heating from"),
        ("cooling", "no complete cycle: the recording holds only cooling from"),
        ("half of heating", "no complete cycle: the recording holds only heating from"),
        ("half of cooling", "no complete cycle:"),
    ],
)
def test_a_part_of_a_loop_is_estimated_and_not_fitted(
    loop: Recording, model: SensingModel, part: str, said: str
) -> None:
    recording = part_of(loop, part)
    with pytest.raises(RecordingError, match=said) as refused:
        fit(recording)
    assert "record heating and cooling back to the strain at the start" in str(refused.value)
    assert "\n" not in str(refused.value)
    report = estimate(model, recording)
    assert report.rms_pct is not None
    assert report.rms_pct < 2.0
    assert np.isfinite(report.recording["estimate_std"][report.recording["valid"] > 0.0]).all()


def another(loop: Recording) -> Recording:
    """The loop of a wire with more resistance, driven by less current, so that it moves alike."""
    columns = {name: values for name, values in loop.columns.items() if name != "drive_voltage_v"}
    columns["wire_voltage_v"] = np.sqrt(OTHER) * loop["wire_voltage_v"]
    columns["shunt_voltage_v"] = loop["shunt_voltage_v"] / np.sqrt(OTHER)
    return Recording(columns, loop.metadata)


@pytest.mark.parametrize("estimator", [None, "polynomial"])
def test_a_model_over_the_cold_resistance_reads_another_wire_of_the_kind(
    loop: Recording, model: SensingModel, estimator: str | None
) -> None:
    other = another(loop)
    with pytest.raises(RecordingError, match="is it the same wire"):
        estimate(model, other)
    relative = fit(loop, relative_resistance=True)
    assert any("parts of the" in text and "ohm of the cold wire" in text for text in relative.warnings)
    own, report = (estimate(relative, one, estimator=estimator) for one in (loop, other))
    assert own.rms_pct is not None
    assert report.rms_pct == pytest.approx(own.rms_pct, abs=0.05)
    assert own.rms_pct < 1.5
    # What is written is in ohm again.
    ohm = report.recording["wire_resistance_ohm"]
    assert np.nanmax(ohm) == pytest.approx(OTHER * np.nanmax(own.recording["wire_resistance_ohm"]), rel=1e-3)
    assert np.array_equal(report.recording["wire_voltage_v"], other["wire_voltage_v"])


def test_a_ratio_as_recorded_is_read_by_a_model_over_the_cold_resistance(loop: Recording, model: SensingModel) -> None:
    ohm = loop["wire_voltage_v"] / loop["shunt_voltage_v"]
    columns = {"time_s": loop["time_s"], "wire_resistance_ohm": ohm / ohm[0], "displacement_m": loop["displacement_m"]}
    ratio = Recording(columns, loop.metadata)
    report = estimate(fit(loop, relative_resistance=True), ratio)
    assert report.rms_pct is not None
    assert report.rms_pct < 1.5
    with pytest.raises(RecordingError, match="over the cold resistance: fit with relative_resistance=True"):
        estimate(model, ratio)


def test_no_rig_and_no_tuning_takes_a_model_over_the_cold_resistance(loop: Recording) -> None:
    relative = fit(loop, relative_resistance=True)
    assert not relative.gains
    with open_rig("simulated") as rig, pytest.raises(CallerError, match="resistance over the cold wire's"):
        control(rig, relative)
    with pytest.raises(CallerError, match="resistance over the cold wire's"):
        tune(relative, loop)
    with pytest.raises(CallerError, match="begins with the cold wire"):
        fit(np.ones(30), np.ones(30), relative_resistance=True)


@pytest.mark.parametrize("known", ["power", "contraction"])
@pytest.mark.parametrize("part", ["cooling", "from the middle of heating on"])
def test_a_recording_that_begins_warm_gives_no_ratio(loop: Recording, known: str, part: str) -> None:
    stroke = loop["displacement_m"][: len(loop) // 2]
    middle = int(np.argmax(stroke > 0.5 * stroke.max()))
    rows = slice(middle, None)
    warm = Recording({name: values[rows] for name, values in loop.columns.items()}, loop.metadata)
    if part != "from the middle of heating on":
        warm = part_of(loop, part)
    left_out = {"displacement_m", "force_n"} if known == "power" else {"wire_voltage_v", "drive_voltage_v"}
    columns = {name: values for name, values in warm.columns.items() if name not in left_out}
    if known == "contraction":
        columns["wire_resistance_ohm"] = warm["wire_voltage_v"] / warm["shunt_voltage_v"]
        del columns["shunt_voltage_v"]
    relative = fit(loop, relative_resistance=True)
    with pytest.raises(RecordingError, match=f"does not begin with the cold wire.*its {known}"):
        estimate(relative, Recording(columns, loop.metadata))


@pytest.mark.parametrize("estimator", ["filter", "particle-filter"])
def test_a_recording_of_one_row_is_refused_in_one_line(loop: Recording, model: SensingModel, estimator: str) -> None:
    one = Recording({name: values[300:301] for name, values in loop.columns.items()}, loop.metadata)
    with pytest.raises(RecordingError, match="has fewer than two rows: an estimator takes two") as refused:
        estimate(model, one, estimator=estimator)
    assert "\n" not in str(refused.value)


def test_a_loop_from_cold_that_is_heated_at_once_begins_cold(loop: Recording, model: SensingModel) -> None:
    with open_rig("simulated", seed=2) as rig:
        run = control(rig, model)
    columns = {name: run[name] for name in ("time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m")}
    report = estimate(fit(loop, relative_resistance=True), Recording(columns, loop.metadata))
    assert report.rms_pct is not None
    assert report.rms_pct < 2.5


def test_a_wire_that_is_heated_from_outside_at_one_current_begins_cold(loop: Recording) -> None:
    ohm = loop["wire_voltage_v"] / loop["shunt_voltage_v"]
    one_ma = np.full(ohm.size, 1e-3)
    columns = {"time_s": loop["time_s"], "wire_voltage_v": ohm * one_ma, "wire_current_a": one_ma}
    for moved in ({}, {"displacement_m": np.full(ohm.size, np.nan)}):
        report = estimate(
            fit(loop, relative_resistance=True), Recording(columns | moved, loop.metadata), estimator="polynomial"
        )
        assert report.recording["valid"].any()


def test_a_contraction_that_counts_the_other_way_is_said_to(loop: Recording) -> None:
    inverted = dict(loop.columns) | {"displacement_m": -loop["displacement_m"]}
    with pytest.raises(RecordingError, match="negate a contraction that falls"):
        fit(Recording(inverted, loop.metadata), relative_resistance=True)
