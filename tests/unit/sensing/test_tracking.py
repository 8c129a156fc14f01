"""Segment A-B and segment B-C told apart by how power and resistance move together."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.sensing import PolynomialEstimator, SensingModel, estimates, segment_course
from musclewire.signals import Reason, WireSample

R_MIN, R_MAX = 15.0, 17.3
SAMPLES = 1800


def slow_loop(noise_ohm: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Resistance, power and the true contraction (0 to 1) of one slow heating and cooling."""
    heat = 0.5 * (1.0 - np.cos(np.linspace(0.0, 2.0 * np.pi, SAMPLES)))
    lag = np.where(np.arange(SAMPLES) < SAMPLES // 2, 0.62, 0.42)
    contraction = 1.0 / (1.0 + np.exp(-25.0 * (heat - lag)))
    resistance = 17.0 + 1.0 * heat - 3.0 * contraction
    noise = noise_ohm * np.random.default_rng(3).standard_normal(SAMPLES)
    return resistance + noise, 0.005 + 0.6 * heat, contraction


@pytest.mark.parametrize("noise_ohm", [0.0, 0.005, 0.02])
def test_a_cold_wire_is_told_from_a_contracting_one(noise_ohm: float) -> None:
    resistance, power, contraction = slow_loop(noise_ohm)
    sensing = segment_course(R_MIN, R_MAX, resistance, power).sensing
    assert sensing[contraction > 0.2].all()
    first, last = SAMPLES // 10, SAMPLES - SAMPLES // 10
    assert not sensing[:first].any()
    assert not sensing[last:].any()


def test_a_step_of_power_held_from_cold_is_followed_through_b() -> None:
    """The power no longer changes while the resistance first rises (A-B) and then falls (B-C)."""
    heat = 1.0 - np.exp(-np.arange(400) / 60.0)
    contraction = 1.0 / (1.0 + np.exp(-25.0 * (heat - 0.6)))
    resistance = 17.0 + 1.0 * heat - 3.0 * contraction
    power = np.full(400, 0.6)
    power[0] = 0.005
    sensing = segment_course(R_MIN, R_MAX, resistance, power).sensing
    assert not sensing[:40].any()
    assert sensing[contraction > 0.3].all()


def test_a_change_that_comes_with_the_turn_of_the_power_is_not_counted_against_the_direction_after_it() -> None:
    """A cold wire whose resistance steps up in the sample in which its power falls is still in A-B."""
    resistance, power = np.full(60, 17.0), np.full(60, 0.3)
    power[30:] = 0.1
    resistance[30] += 0.5  # smoothed, more than the change that counts
    assert not segment_course(R_MIN, R_MAX, resistance, power).sensing[:31].any()


BEGINS_OHM = {"in A-B": 17.0, "between B and C": 16.8}


def moved(begins_ohm: float, by_ohm: float, power_factor: float, samples: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Resistance and power that change evenly from the first sample on."""
    part = np.linspace(0.0, 1.0, samples)
    return begins_ohm + by_ohm * part, 0.3 * power_factor**part


@pytest.mark.parametrize("begins", BEGINS_OHM)
@pytest.mark.parametrize("warmer", [True, False], ids=["heated", "cooled"])
@pytest.mark.parametrize("rises", [True, False], ids=["rising", "falling"])
def test_in_a_b_resistance_moves_with_the_temperature_and_between_b_and_c_against_it(
    begins: str, warmer: bool, rises: bool
) -> None:
    """Lan and Fan 2010, Fig. 3(b): the sign decides, in whichever segment the wire was found before."""
    begins_ohm = BEGINS_OHM[begins] if rises else 17.25
    by_ohm = 0.25 if rises else -0.25
    before = np.full(30, BEGINS_OHM[begins])
    resistance, power = moved(begins_ohm, by_ohm, 2.0 if warmer else 0.5)
    # The wire first rests where its segment is certain, then is led to the resistance at which the change begins.
    led = np.linspace(BEGINS_OHM[begins], begins_ohm, 30)
    watt = np.concatenate([np.full(60, 0.3), power])
    course = segment_course(R_MIN, R_MAX, np.concatenate([before, led, resistance]), watt)
    assert course.sensing[-1] == (warmer != rises)


@pytest.mark.parametrize("warmer", [True, False], ids=["heated", "cooled"])
@pytest.mark.parametrize("rises", [True, False], ids=["rising", "falling"])
def test_a_cold_wire_is_sensed_once_power_and_resistance_move_in_opposite_directions(rises: bool, warmer: bool) -> None:
    estimator = PolynomialEstimator(SensingModel(R_MIN, R_MAX, (0.03, -0.03), (0.03, -0.03), 0.0, 1.0), 1.0)
    resistance, power = moved(17.0 if rises else 17.25, 0.25 if rises else -0.25, 2.0 if warmer else 0.5)
    wire_v = np.sqrt(power * resistance)
    samples = [WireSample(0.0, 2.0, *pair) for pair in np.column_stack([wire_v, wire_v / resistance]).tolist()]
    reasons = [estimate.reason for estimate, _ in estimates(estimator, samples)]
    assert reasons[0] is Reason.COLD
    assert (reasons[-1] is Reason.OK) == (warmer != rises)
