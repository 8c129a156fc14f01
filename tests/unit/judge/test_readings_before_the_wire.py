"""Readings that are no measurements are found, named and left out; sound ones are left alone."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pytest
from numpy.random import Generator

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.identify import estimate, fit
from musclewire.judge import JudgedRecording, judge_readings, resistance_reading
from musclewire.rigs import open_rig
from musclewire.signals import Recording

SHUNT_OHM = 1.0


@pytest.fixture(scope="module")
def staircase() -> Recording:
    """A drive that is held: a staircase up and down, and a ramp to a level that is held."""
    time_s = np.arange(0.0, 90.0, 0.05)
    steps = 0.3 + 2.7 * np.floor(10.0 * np.minimum(time_s / 45.0, 2.0 - time_s / 45.0)) / 10.0
    hold = 0.3 + 2.7 * np.clip(time_s / 40.0, 0.0, 1.0) * np.clip((90.0 - time_s) / 30.0, 0.0, 1.0)
    with open_rig("simulated") as rig:
        samples = [rig.exchange(float(drive)) for drive in (*steps, *hold)]
    names = ("time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m")
    columns = {name: np.array([getattr(sample, name) for sample in samples]) for name in names}
    return Recording({**columns, "drive_voltage_v": np.concatenate([steps, hold])}, {"shunt_resistance_ohm": SHUNT_OHM})


class Measured(NamedTuple):
    """A recording as another laboratory would have it, and the column that is at the end of its range, "" for none."""

    columns: Mapping[str, FloatArray]
    metadata: Mapping[str, float]
    cut: str = ""


SOURCES = {
    "shunt": ("wire_voltage_v", "shunt_voltage_v"),
    "current": ("wire_voltage_v", "wire_current_a"),
    "resistance": ("wire_resistance_ohm",),
}


def measured(recording: Recording, random: Generator, cut: bool) -> Measured:
    """Return a recording through drawn instruments: noise, converter, rate, source, and a range that is too small."""
    rows = np.arange(0, len(recording), int(random.choice([1, 2, 4])))
    volts = recording["wire_voltage_v"][rows]
    amperes = recording["shunt_voltage_v"][rows] / SHUNT_OHM
    noise = float(random.choice([0.0, 1e-4, 1e-3, 5e-3]))
    volts = volts + noise * volts.max() * random.standard_normal(rows.size)
    amperes = amperes + noise * amperes.max() * random.standard_normal(rows.size)
    found = {"wire_voltage_v": volts, "wire_current_a": amperes, "shunt_voltage_v": SHUNT_OHM * amperes}
    found["wire_resistance_ohm"] = volts / np.maximum(amperes, 1e-3)
    source = str(random.choice(list(SOURCES)))
    bits, room = int(random.choice([10, 11, 12, 16])), random.uniform(1.0, 4.0)
    end = str(random.choice(SOURCES[source])) if cut else ""
    if end:
        high = float(found[end].max())
        # A resistance turns at B and rests near it: its range ends well below that, and its meter has many steps.
        low = float(np.quantile(found[end], 0.02)) if end == "wire_resistance_ohm" else 0.0
        level = low + random.uniform(0.4, 0.8) * (float(np.quantile(found[end], 0.98)) - low)
        bits = max(bits, 12) if end == "wire_resistance_ohm" else bits
        found[end] = np.minimum(found[end], level if high > level else high)
    columns = {name: in_steps(found[name], room * float(found[name].max()) / 2**bits) for name in SOURCES[source]}
    columns |= {"time_s": recording["time_s"][rows], "displacement_m": recording["displacement_m"][rows]}
    if random.random() < 0.5:
        columns["drive_voltage_v"] = recording["drive_voltage_v"][rows]
    return Measured(columns, {"shunt_resistance_ohm": SHUNT_OHM} if source == "shunt" else {}, end)


def in_steps(values: FloatArray, step: float) -> FloatArray:
    return np.asarray(np.round(values / step) * step)


def longest_at_the_top(values: FloatArray) -> int:
    """Return how many rows in a row have the largest value, at most."""
    return max(len(list(rows)) for equal, rows in itertools.groupby(values == values.max()) if equal)


def test_500_recordings_at_the_end_of_a_range_are_never_used_without_a_word(loop: Recording) -> None:
    missed, drawn = [], 0
    for seed in itertools.count():
        recording = measured(loop, np.random.default_rng(seed), cut=True)
        if longest_at_the_top(recording.columns[recording.cut]) < 5:
            continue  # noise left it no plateau
        drawn += 1
        if drawn > 500:
            break
        judged = judge_readings(recording.columns, recording.metadata)
        if not any(recording.cut in text and "the end of a range" in text for text in judged.findings):
            missed.append((seed, recording.cut))
    assert missed == []


def test_500_recordings_with_an_overload_mark_are_never_used_without_a_word(loop: Recording) -> None:
    for seed in range(500):
        random = np.random.default_rng(seed)
        recording = measured(loop, random, cut=False)
        name = str(random.choice([name for name in recording.columns if name not in ("time_s", "displacement_m")]))
        name = "wire_voltage_v" if name == "drive_voltage_v" and "wire_voltage_v" in recording.columns else name
        name = "wire_resistance_ohm" if name == "drive_voltage_v" else name
        rows = random.choice(recording.columns[name].size, int(random.integers(1, 6)), replace=False)
        values = recording.columns[name].copy()
        values[rows] = random.choice([9.9e37, -9.9e37, 9.91e37, 1e38, 3.4e38])
        judged = judge_readings({**recording.columns, name: values}, recording.metadata)
        assert not judged.usable[rows].any()
        assert "mark of an overload" in judged.findings[0]
        assert judged.contradiction == ""


def test_at_most_one_in_1000_sound_recordings_is_called_anything_else(loop: Recording, staircase: Recording) -> None:
    called = []
    for seed in range(3000):
        recording = measured(loop if seed % 3 else staircase, np.random.default_rng(seed), cut=False)
        judged = judge_readings(recording.columns, recording.metadata)
        if judged.findings or judged.contradiction:
            called.append((seed, judged.findings, judged.contradiction))
    assert len(called) <= 3, called


def by_current(loop: Recording, **changed: FloatArray) -> Recording:
    """Return the loop as volts and current, with a column in another one's place."""
    columns = {name: loop[name] for name in ("time_s", "wire_voltage_v", "displacement_m")}
    current = {"wire_current_a": loop["shunt_voltage_v"] / SHUNT_OHM}
    return Recording({**columns, **current, **changed}, {"leg_length_m": 0.07})


def test_a_current_at_the_end_of_its_range_is_no_reading_and_the_rest_is_used(loop: Recording) -> None:
    model = fit(by_current(loop))
    current = np.minimum(loop["shunt_voltage_v"] / SHUNT_OHM, 0.12)
    report = estimate(model, by_current(loop, wire_current_a=current))
    at_end = current == current.max()
    assert not report.recording["valid"][at_end].any()
    assert report.recording["valid"][~at_end].any()
    said = f"{int(at_end.sum())} of {len(loop)} rows are no measurements: wire_current_a stays at 0.12 A"
    assert said in report.warnings[0]
    assert said in str(report.recording.metadata["unusable_readings"])
    assert report.not_counted["that are no measurements"] == pytest.approx(at_end.mean(), abs=0.01)
    assert JudgedRecording(by_current(loop, wire_current_a=current)).circuit.shunt_v[at_end].max() == 0.0


def test_stated_ends_of_range_and_those_of_a_stated_chip_are_no_readings() -> None:
    time_s = np.arange(20.0)
    current = np.where(time_s < 10, 0.4, 0.1)
    columns = {"time_s": time_s, "wire_voltage_v": 10.0 * current, "wire_current_a": current}
    assert judge_readings(columns, {}).usable.all(), "a drive that is held looks like this"
    for stated in ({"chip": "INA219"}, {"wire_current_range_a": 0.4}):
        judged = judge_readings(columns, stated)
        assert judged.usable.tolist() == [False] * 10 + [True] * 10
        assert "10 of 20 rows are no measurements: wire_current_a stays at 0.4 A" in judged.findings[0]


def test_a_current_that_is_negative_throughout_is_said_to_be(loop: Recording) -> None:
    negative = by_current(loop, wire_current_a=-loop["shunt_voltage_v"] / SHUNT_OHM)
    with pytest.raises(RecordingError, match="wire_current_a is negative throughout: exchange the two leads"):
        resistance_reading(negative)


def test_pulses_that_are_off_are_left_out_and_what_is_on_is_fitted(loop: Recording) -> None:
    random = np.random.default_rng(3)
    on = random.random(len(loop)) < 0.4
    current = np.where(on, loop["shunt_voltage_v"] / SHUNT_OHM, 0.7e-3 * random.standard_normal(len(loop)))
    volts = np.where(on, loop["wire_voltage_v"], 0.7e-3 * random.standard_normal(len(loop)))
    pulsed = by_current(loop, wire_current_a=current, wire_voltage_v=volts)
    assert (resistance_reading(pulsed).valid == on).all()
    model = fit(pulsed)
    assert model.resistance_min_ohm == pytest.approx(fit(by_current(loop)).resistance_min_ohm, rel=0.002)
    assert any("the drive is off" in text for text in model.warnings)


def test_no_message_asks_for_more_drive_while_readings_are_missing(loop: Recording) -> None:
    current = (loop["shunt_voltage_v"] / SHUNT_OHM).copy()
    current[::50] = 9.9e37
    straight = by_current(loop, wire_current_a=current, wire_voltage_v=17.0 * loop["shunt_voltage_v"] / SHUNT_OHM)
    with pytest.raises(RecordingError, match="72 of 3600 samples cannot be used, mend the readings first") as raised:
        fit(straight)
    assert "raise the drive" not in str(raised.value)


def test_two_sources_of_one_quantity_that_contradict_each_other_are_refused_with_what_would_be_right(
    loop: Recording,
) -> None:
    both = loop.with_columns(wire_current_a=loop["shunt_voltage_v"] / SHUNT_OHM)
    assert resistance_reading(both).valid.all()
    with pytest.raises(RecordingError, match=r"is 0\.213 times wire_current_a: by the current the shunt has 1 ohm"):
        fit(both.with_metadata(shunt_resistance_ohm=4.7))
    ohm = loop["wire_voltage_v"] / loop["shunt_voltage_v"]
    with pytest.raises(RecordingError, match=r"is 0\.001 times wire_resistance_ohm: correct a unit"):
        fit(both.with_columns(wire_resistance_ohm=1e3 * ohm))


def test_a_drive_that_wire_and_shunt_do_not_have_is_said_and_the_readings_are_used(loop: Recording) -> None:
    model = fit(loop.with_columns(drive_voltage_v=1e-3 * loop["drive_voltage_v"]))
    assert any("times drive_voltage_v: check units and channels" in text for text in model.warnings)


def test_all_that_a_fit_lacks_is_named_at_once(loop: Recording) -> None:
    bare = Recording({name: loop[name] for name in ("time_s", "wire_voltage_v", "displacement_m")}, {})
    with pytest.raises(RecordingError, match=r"it lacks shunt_voltage_v.*; besides, .*give metadata=.'leg_length_m"):
        fit(bare)


@pytest.mark.parametrize("estimator", ["polynomial", "filter"])
def test_volts_and_current_or_resistance_and_current_serve_as_both_voltages_do(loop: Recording, estimator: str) -> None:
    model = fit(loop)
    expected = estimate(model, loop, estimator=estimator).recording["estimated_strain"]
    current = loop["shunt_voltage_v"] / SHUNT_OHM
    for columns in (
        {"wire_voltage_v": loop["wire_voltage_v"], "wire_current_a": current},
        {"wire_resistance_ohm": loop["wire_voltage_v"] / current, "wire_current_a": current},
    ):
        recording = Recording({"time_s": loop["time_s"], "displacement_m": loop["displacement_m"], **columns}, {})
        found = estimate(model, recording.with_metadata(leg_length_m=0.07), estimator=estimator)
        both = (found.recording["valid"] > 0.0) & np.isfinite(expected)
        assert np.abs(found.recording["estimated_strain"] - expected)[both].max() < 1e-3
