"""Speed limits: which references a wire cannot follow, and what would help."""

from __future__ import annotations

import numpy as np
import pytest
from known_plant import LIMITS, MODEL, plant_settings, sine

from musclewire.controllers import staircase
from musclewire.errors import CallerError, RecordingError
from musclewire.identify import FastestWay, speed_limits_of
from musclewire.signals import RunFacts

STATED = {
    "sample_period_s": 0.05,
    "shunt_resistance_ohm": 1.0,
    "wire_diameter_m": 1e-4,
    "pretension_n": 1.0,
    **LIMITS,
    "limit_sense_voltage_v": 0.2,
    "limit_maximum_voltage_v": 4.5,
}
FACTS = RunFacts(STATED)


def test_a_slow_reference_has_no_findings_and_its_whole_amplitude() -> None:
    limits = speed_limits_of(MODEL, sine(0.02), FACTS, plant_settings())
    assert (limits.findings, limits.warnings) == ((), ())
    assert limits.possible_amplitude == pytest.approx(limits.asked_amplitude, rel=0.02)
    assert str(limits) == "the wire can follow this reference"


def test_a_fast_one_is_named_with_what_would_help() -> None:
    limits = speed_limits_of(MODEL, sine(1.0, 0.014), FACTS, plant_settings(heat_per_unit=2.5))
    assert {one.direction for one in limits.findings} == {"cooling", "heating"}
    assert limits.possible_amplitude < 0.9 * limits.asked_amplitude
    cooling, heating = limits.warnings
    for word in (
        "cools",
        "moving air",
        "um (loss over capacity",
        "times slower",
        "wire itself allows an amplitude of",
    ):
        assert word in cooling
    assert "times the maximum voltage" in heating


def test_what_would_help_does_help() -> None:
    found = speed_limits_of(MODEL, sine(0.5), FACTS, plant_settings()).help
    assert found.slower is not None
    assert found.heat_loss is not None
    assert speed_limits_of(MODEL, sine(0.5 / (1.03 * found.slower)), FACTS, plant_settings()).findings == ()


def test_a_level_of_a_staircase_that_is_reached_before_its_end_is_no_finding() -> None:
    assert speed_limits_of(MODEL, staircase(0.015, 0.03, 0.003, hold_s=6.0), FACTS, plant_settings()).findings == ()
    fast = speed_limits_of(MODEL, staircase(0.015, 0.03, 0.003, hold_s=0.1), FACTS, plant_settings())
    assert "cooling" in {one.direction for one in fast.findings}


def test_what_is_not_known_is_said() -> None:
    with pytest.raises(RecordingError, match="no power through its loop"):
        speed_limits_of(MODEL, sine(0.1), FACTS)
    with pytest.raises(CallerError, match="tune this model"):
        speed_limits_of(MODEL, sine(0.1), FACTS, plant_settings(quantity="force"))


@pytest.mark.parametrize("frequency_hz", [0.1, 1.0])
def test_the_fastest_way_sample_by_sample_is_that_which_the_limits_are_said_from(frequency_hz: float) -> None:
    targets = sine(frequency_hz).target
    settings = plant_settings()
    way = FastestWay(MODEL, FACTS, settings, from_cold=False)
    misses = np.array([way.miss(target) for target in targets.tolist()])
    found = speed_limits_of(MODEL, sine(frequency_hz), FACTS, settings).findings
    assert bool(found) == bool((np.abs(misses) > 0.02 * (MODEL.quantity_max - MODEL.quantity_min)).any())
    assert max((one.missed for one in found), default=np.abs(misses).max()) == pytest.approx(np.abs(misses).max())


def test_from_cold_all_of_the_target_is_missed_until_the_wire_is_warm() -> None:
    way = FastestWay(MODEL, FACTS, plant_settings(), from_cold=True)
    misses = [way.miss(0.02) for _ in range(100)]
    warm = misses.index(next(miss for miss in misses if miss != -0.02))
    assert 1 < warm < 60
    assert np.all(np.diff(misses[warm:]) >= 0.0)
    assert misses[-1] == 0.0


def test_a_target_that_the_voltage_cannot_hold_is_no_matter_of_speed() -> None:
    """It would excuse a loop for ever, though waiting does not help: the miss is to be named."""
    settings, targets = plant_settings(), [0.01, *[0.03] * 2000]
    for maximum_v, held in ((4.5, True), (2.75, False)):
        way = FastestWay(MODEL, RunFacts({**STATED, "limit_maximum_voltage_v": maximum_v}), settings, from_cold=False)
        misses = [way.miss(target) for target in targets]
        assert min(misses) < -0.01
        assert misses[-1] == 0.0
        assert (way._level == pytest.approx(0.03)) is held
