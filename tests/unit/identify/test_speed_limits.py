"""Speed limits: exponential cooling of a lumped capacity, latent heat, and what would help, each in closed form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from known_plant import COOLING_W, HEATING_W, LIMITS, MODEL, TAU_S, plant_settings

from musclewire.controllers import sampled_reference, staircase
from musclewire.errors import CallerError, RecordingError
from musclewire.identify import FastestWay, speed_limits_of
from musclewire.identify._speed_limits.limits import diameter_for
from musclewire.identify._speed_limits.plant import SpeedPlant, fastest_course
from musclewire.signals import RunFacts

LEVELS = np.linspace(0.005, 0.035, 33)
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


def plant(heat_per_unit: float = 0.0) -> SpeedPlant:
    heating, cooling = (np.linspace(*ends, 33) for ends in (HEATING_W, COOLING_W))
    return SpeedPlant(LEVELS, heating, cooling, np.full(33, 0.01), np.full(33, 1.2), TAU_S, heat_per_unit)


def sine(frequency_hz: float, amplitude: float = 0.0075) -> Any:
    time_s = np.arange(0.0, 6.0 / frequency_hz, 0.05)
    return sampled_reference(time_s, 0.02 + amplitude * np.sin(2.0 * math.pi * frequency_hz * time_s))


def test_without_latent_heat_a_wire_cools_like_a_lumped_capacity() -> None:
    excess = np.linspace(*COOLING_W, 33) - 0.01
    assert plant().cooling_times_s() == pytest.approx(TAU_S * np.log(excess / excess[0]), abs=1e-12)
    left = 1.2 - np.linspace(*HEATING_W, 33)
    assert plant().heating_times_s() == pytest.approx(TAU_S * np.log(left[0] / left), abs=1e-12)


def test_latent_heat_over_the_mean_power_is_added() -> None:
    heat_j_per_unit, excess = 2.5, np.linspace(*COOLING_W, 33) - 0.01
    slope = (COOLING_W[1] - COOLING_W[0]) / 0.03
    latent_s = heat_j_per_unit / slope * np.log(excess / excess[0])
    assert plant(heat_j_per_unit).cooling_times_s() == pytest.approx(
        TAU_S * np.log(excess / excess[0]) + latent_s, abs=1e-12
    )


def test_a_step_down_first_crosses_the_gap_and_then_cools_exponentially() -> None:
    found = fastest_course(plant(), np.r_[0.03, np.full(60, 0.005)], 0.01)
    power = HEATING_W[0] + (HEATING_W[1] - HEATING_W[0]) * 25.0 / 30.0
    stands = TAU_S * math.log((power - 0.01) / (power - 0.1 - 0.01))
    assert np.all(found[: int(stands / 0.01)] == pytest.approx(0.03))
    after_s = 0.01 * np.arange(61) - stands
    steady = 0.01 + (power - 0.1 - 0.01) * np.exp(-after_s / TAU_S)
    expected = 0.005 + 0.03 * (steady - COOLING_W[0]) / (COOLING_W[1] - COOLING_W[0])
    moving = after_s > 0.0
    # Between levels time is interpolated: the error is that of a chord over one spacing of the levels.
    assert found[moving] == pytest.approx(np.maximum(expected[moving], 0.005), abs=3e-6)


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


@given(factor=st.floats(1.05, 8.0))
def test_loss_over_capacity_goes_with_the_diameter_to_a_power_between_one_and_two(factor: float) -> None:
    power = -math.log(factor) / math.log(diameter_for(factor, 1e-4, 295.15) / 1e-4)
    assert 1.5 < power < 2.0


@given(frequency_hz=st.floats(0.05, 2.0), loss=st.floats(1.0, 4.0))
def test_more_loss_never_cools_more_slowly(frequency_hz: float, loss: float) -> None:
    assert np.all(plant(2.5).with_loss(loss).cooling_times_s() <= plant(2.5).cooling_times_s() + 1e-12)
    assert np.all(np.isfinite(fastest_course(plant(2.5), sine(frequency_hz).target, 0.05)))


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
