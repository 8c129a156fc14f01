"""Speed of a wire in closed form: exponential cooling of a lumped capacity, latent heat, and the diameter."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from known_plant import COOLING_W, HEATING_W, TAU_S, sine

from musclewire.identify._speed_limits.limits import diameter_for
from musclewire.identify._speed_limits.plant import SpeedPlant, fastest_course

LEVELS = np.linspace(0.005, 0.035, 33)


def plant(heat_per_unit: float = 0.0) -> SpeedPlant:
    heating, cooling = (np.linspace(*ends, 33) for ends in (HEATING_W, COOLING_W))
    return SpeedPlant(LEVELS, heating, cooling, np.full(33, 0.01), np.full(33, 1.2), TAU_S, heat_per_unit)


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


@given(factor=st.floats(1.05, 8.0))
def test_loss_over_capacity_goes_with_the_diameter_to_a_power_between_one_and_two(factor: float) -> None:
    power = -math.log(factor) / math.log(diameter_for(factor, 1e-4, 295.15) / 1e-4)
    assert 1.5 < power < 2.0


@given(frequency_hz=st.floats(0.05, 2.0), loss=st.floats(1.0, 4.0))
def test_more_loss_never_cools_more_slowly(frequency_hz: float, loss: float) -> None:
    assert np.all(plant(2.5).with_loss(loss).cooling_times_s() <= plant(2.5).cooling_times_s() + 1e-12)
    assert np.all(np.isfinite(fastest_course(plant(2.5), sine(frequency_hz).target, 0.05)))
