"""What a recording shows against itself, on curves drawn by hand."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import musclewire as mw
from musclewire.judge import recording_defects
from musclewire.judge._defects import (
    DEFECTS,
    Defect,
    MeasuredLoop,
    Numbers,
    largest_jump,
    longest_flat,
    scatter_ohm,
    short_cooling,
)
from musclewire.signals import Recording, RunFacts

RISE = np.sin(np.linspace(0.0, np.pi, 201)) ** 2


def recording(moved: np.ndarray, ohm: np.ndarray, current_a: np.ndarray) -> Recording:
    time_s = 0.1 * np.arange(moved.size)
    columns = {"time_s": time_s, "wire_voltage_v": ohm * current_a, "wire_current_a": current_a}
    return Recording({**columns, "displacement_m": moved}, {})


def test_the_jump_beside_a_line_over_the_power_is_found_with_its_size_and_place() -> None:
    power = np.linspace(0.0, 1.0, 60)
    noise = 0.01 * np.random.default_rng(4).standard_normal(60)
    place, jump, std = largest_jump(power, 3.0 + 2.0 * power - 0.5 * (np.arange(60) >= 22) + noise)
    assert place == 22
    assert jump == pytest.approx(-0.5, abs=3.0 * std)
    assert 0.0 < std < 0.01


def test_what_a_line_over_the_power_could_be_as_well_is_no_jump() -> None:
    power = np.repeat([1.0, 4.0], 20)
    assert largest_jump(power, 3.0 - 0.1 * power)[1] == pytest.approx(0.0, abs=1e-12)


def test_a_flat_stretch_begins_beyond_the_maximum() -> None:
    part = np.linspace(0.0, 1.0, 41)
    # Flat before 0.4, where nothing is read, and from 0.6 on.
    ohm = np.interp(part, [0.0, 0.4, 0.6, 1.0], [10.0, 10.01, 9.0, 8.95])
    first, last, change = longest_flat(part, ohm)
    assert (first, last) == pytest.approx((0.6, 1.0), abs=0.03)
    assert change == pytest.approx(0.05 / 9.0, rel=0.1)
    assert longest_flat(part, 10.0 - 2.0 * part)[:2] == (0.0, 0.0)


def test_scatter_is_that_of_single_readings_and_not_of_a_curve() -> None:
    noise = 0.02 * np.random.default_rng(5).standard_normal(2000)
    curve = 10.0 + np.sin(np.linspace(0.0, 6.0, 2000))
    assert scatter_ohm(curve + noise, np.arange(2000)) == pytest.approx(0.02, rel=0.1)
    assert scatter_ohm(curve, np.arange(2000)) < 1e-4


@pytest.mark.parametrize(
    ("current_a", "named"), [(None, True), (0.1 + 0.2 * RISE, True), (0.1 + 0.001 * RISE.cumsum(), False)]
)
def test_cooling_is_short_if_the_current_is_back_or_was_not_recorded(current_a: np.ndarray | None, named: bool) -> None:
    moved = np.where(np.arange(201) > 100, 0.2 + 0.8 * RISE, RISE) * 1e-3
    loop = MeasuredLoop(
        0.1 * np.arange(201), 10.0 - RISE, moved, current_a, ("wire_resistance_ohm",), "displacement", RunFacts({})
    )
    found = short_cooling(loop)
    assert bool(found) is named
    assert not found or found == pytest.approx({"short": 0.2, "unit": "mm", "short_pct": 20.0})


def test_a_recording_that_moves_less_than_asked_or_not_beyond_its_noise_is_not_judged() -> None:
    ohm, current_a = 10.0 - RISE, 0.1 + 0.2 * RISE
    short = np.where(np.arange(201) > 100, 0.2 + 0.8 * RISE, RISE) * 1e-3
    assert recording_defects(recording(short, ohm, current_a), "displacement")
    assert not recording_defects(recording(short, ohm, current_a), "displacement", 4e-3)
    held = 1e-6 * np.random.default_rng(6).standard_normal(201)
    assert not recording_defects(recording(held, ohm, current_a), "displacement")
    assert not recording_defects(recording(short, ohm, current_a), "force")


def test_in_one_fit_each_detector_looks_once(monkeypatch: pytest.MonkeyPatch) -> None:
    with mw.open_rig("simulated") as rig:
        loop = mw.characterize(rig)
    looks: Counter[str] = Counter()

    def counting(one: Defect) -> Defect:
        def look(seen: MeasuredLoop) -> Numbers:
            looks[one.key] += 1
            return one.detect(seen)

        return one._replace(detect=look)

    monkeypatch.setattr("musclewire.judge._defects.DEFECTS", tuple(map(counting, DEFECTS)))
    mw.estimate(mw.fit(loop), loop)
    assert looks == {one.key: 1 for one in DEFECTS}


@pytest.mark.parametrize(
    ("metadata", "said"),
    [
        ({}, ""),  # one instrument
        ({"join_delay_s": 0.3}, "of no stated deviation; with 50 ms"),
        ({"join_delay_s": 0.3, "join_delay_std_s": 0.025}, "known to 25 ms; with 50 ms"),
        ({"join_delay_s": 0.3, "join_delay_std_s": 1e-4}, ""),
    ],
)
def test_joined_clocks_are_warned_of_if_their_delay_is_known_no_better_than_the_gap(
    metadata: dict[str, float], said: str
) -> None:
    # Straight branches 4 % of the stroke apart, over 10 s each: in 50 ms the wire moves by 0.5 % of the stroke, so the
    # gap of 4 % changes by twice that, a quarter of itself.
    rise = np.linspace(0.0, 1.0, 101)
    moved = np.concatenate([rise, rise[-2::-1]]) * 1e-3
    ohm = np.concatenate([10.0 - rise, 9.0 - 0.04 + rise[1:]])
    loop = recording(moved, ohm, np.full(moved.size, 0.2)).with_metadata(metadata)
    texts = [text for text in recording_defects(loop, "displacement") if "joined" in text]
    assert len(texts) == bool(said)
    assert all(said in text and "is 3 to 5 % of the stroke" in text for text in texts)
