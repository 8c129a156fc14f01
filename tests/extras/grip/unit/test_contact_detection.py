"""Contact against a heat balance in closed form: power computed from theta, m, the air and contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from musclewire.errors import CallerError
from musclewire.extras.grip import ContactDetector
from musclewire.extras.grip._contact_detection import AirDisturbance, ContactState, FreeClosing

FREE = FreeClosing(
    resistance_min_ohm=15.0,
    resistance_max_ohm=17.5,
    holding_power_w=(0.55, -0.25),
    closing_energy_j=(0.25,),
    normalised_min=0.08,
    normalised_max=0.95,
    normalised_noise=0.0015,
    thermal_time_s=0.6,
)
DT_S = 0.05
CONTRACTS_S = 1.3
# A wire that warms to B in 0.4 s and then contracts, slowly at both ends.
WARMING = np.linspace(0.87, 1.0, 8)
TURN = np.pi * DT_S * np.arange(1, 27) / CONTRACTS_S
PLACES = np.concatenate([WARMING, 1.0 - 0.93 * 0.5 * (1.0 - np.cos(TURN))])
RATES = np.concatenate([np.zeros(8), -0.93 * 0.5 * np.pi / CONTRACTS_S * np.sin(TURN)])


def powers(contact: float = 0.0, slope_w: float = 0.0, level: float = 0.0) -> np.ndarray:
    """P = theta (1 + level) - m dl/dt + s [(l_c - l) - tau dl/dt] at each place, (n,)."""
    free = (0.55 - 0.25 * PLACES) * (1.0 + level) - 0.25 * RATES
    return free + np.where(contact > PLACES, slope_w * (contact - PLACES - 0.6 * RATES), 0.0)


def states(power: np.ndarray, places: np.ndarray = PLACES) -> list[ContactState]:
    detector, found = ContactDetector(FREE), []
    state = detector.start()
    for place, watt in zip(places, power, strict=True):
        state = detector.step(state, 15.0 + 2.5 * float(place), float(watt), DT_S)
        found.append(state)
    return found


def test_a_free_closing_as_learned_scores_nothing() -> None:
    assert max(state.score for state in states(powers())) < 1.0
    assert all(abs(state.innovation) < 1.0 for state in states(powers()) if state.innovation is not None)


@given(st.floats(0.4, 0.85), st.floats(0.2, 1.0))
def test_contact_is_found_with_its_place_and_its_slope(contact: float, slope_w: float) -> None:
    last = states(powers(contact, slope_w))[-4]
    assert last.touched
    # One sample is up to 0.055 here, and a step of power within one is told to about half of it.
    assert last.place == pytest.approx(contact, abs=0.03)
    assert last.slope_w == pytest.approx(slope_w, rel=0.25)


@given(st.floats(0.4, 0.85))
def test_contact_is_found_before_much_of_the_way_is_gone(contact: float) -> None:
    found = next(state for state in states(powers(contact, 0.5)) if state.touched)
    assert found.normalised is not None
    assert 0.0 < contact - found.normalised < 0.15


@given(st.floats(-0.15, 0.15))
def test_air_that_stays_warmer_or_colder_is_not_contact(level: float) -> None:
    assert not states(powers(level=level))[-1].touched


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000))
def test_draughts_and_noise_as_expected_do_not_alarm(seed: int) -> None:
    random = np.random.default_rng(seed)
    air = AirDisturbance()
    kept = np.exp(-DT_S / air.draught_time_s)
    draught = np.empty(PLACES.size)
    draught[0] = random.standard_normal()
    for row in range(1, PLACES.size):
        draught[row] = kept * draught[row - 1] + np.sqrt(1.0 - kept**2) * random.standard_normal()
    power = powers() + air.draught_fraction * draught * (0.55 - 0.25 * PLACES)
    noisy = PLACES + FREE.normalised_noise * random.standard_normal(PLACES.size)
    assert not states(power, noisy)[-1].touched


@pytest.mark.parametrize("dt_s", [0.05, 0.5, 2.0])
def test_between_samples_the_draught_gains_the_variance_of_a_first_order_process(dt_s: float) -> None:
    """An Ornstein-Uhlenbeck process known at one time: the integral of its diffusion, each part decayed since."""
    air = AirDisturbance(draught_fraction=0.2, draught_time_s=3.0)
    # With a model this noisy the filter learns next to nothing, and its covariance is the prediction.
    detector = ContactDetector(replace(FREE, normalised_noise=0.99, closing_energy_j=(1e4,)), air)
    state, variances = detector.start(), []
    for place in (0.93, 0.90, 0.85, 0.80):
        state = detector.step(state, 15.0 + 2.5 * place, 0.5, dt_s)
        variances.append(float(state.covariance[1, 1]))
    holding_w = 0.55 - 0.25 * 0.5 * (0.85 + 0.80)
    diffusion_w2_per_s = 2.0 * (0.2 * holding_w) ** 2 / 3.0
    gained_w2, _ = quad(lambda ago_s: diffusion_w2_per_s * np.exp(-2.0 * ago_s / 3.0), 0.0, dt_s)
    assert variances[-1] - variances[-2] == pytest.approx(gained_w2, rel=1e-5)


def test_a_wire_at_rest_or_warming_is_never_judged() -> None:
    noisy = 0.87 + 0.02 * np.random.default_rng(1).standard_normal(400)
    assert all(state.innovation is None for state in states(np.full(400, 0.04), noisy))
    assert all(state.innovation is None for state in states(powers()[:8], WARMING))


def test_the_same_state_steps_to_the_same_state_twice() -> None:
    detector, power = ContactDetector(FREE), powers(0.7, 0.5)
    state = states(power)[20]
    one, other = (detector.step(state, 16.0, 0.6, DT_S) for _ in range(2))
    assert (one.score, one.place, one.slope_w) == (other.score, other.place, other.slope_w)
    assert state.score == states(power)[20].score


def test_once_found_contact_stays_found() -> None:
    found = [state.touched for state in states(powers(0.7, 0.8))]
    assert found == sorted(found)


@pytest.mark.parametrize(
    "wrong",
    [
        {"normalised_noise": 0.0},
        {"normalised_noise": 1.0},
        {"thermal_time_s": 0.0},
        {"normalised_min": 0.96},
        {"holding_power_w": ()},
        {"closing_energy_j": (float("nan"),)},
        {"resistance_min_ohm": 18.0},
    ],
)
def test_a_free_closing_that_cannot_be_is_refused(wrong: dict) -> None:
    with pytest.raises(CallerError):
        replace(FREE, **wrong)
