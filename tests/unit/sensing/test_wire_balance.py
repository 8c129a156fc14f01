"""The heat balance of a wire by its motion, by its diameter, and the law of its minor loops."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from musclewire.identify import fit
from musclewire.sensing import SensingModel, WireMotion
from musclewire.sensing._wire_balance import (
    ANY_LAW,
    MEASURED,
    TYPICAL_DIAMETER_M,
    HeatBalanceFound,
    balance,
    by_diameter,
    by_motion,
    heat_balance_of,
    law_of_minor_loops,
    steady_power_w,
)
from musclewire.sensing._wire_tables import WireModel
from musclewire.signals import Recording


@pytest.fixture(scope="module")
def wire(model: SensingModel) -> WireModel:
    assert model.wire_model is not None
    return model.wire_model


def moving(tau_s: float, heat_j: float, period_s: float, noise: float = 0.0) -> WireMotion:
    """Return the motion of a wire that is the model itself: a balance, and resistance by temperature at rest."""
    time_s = np.linspace(0.0, 3.0 * period_s, 1200)
    power_w = 0.01 + 0.5 * np.sin(math.pi * time_s / period_s) ** 2
    steady_w, place = np.zeros(1200), np.zeros(1200)
    steady_w[0] = power_w[0]
    for row in range(1, time_s.size):
        dt_s = time_s[row] - time_s[row - 1]
        found, previous = place[row - 1], place[row - 1]
        for _ in range(60):  # the place is a function of the power that it takes heat from
            given_w = 0.5 * (power_w[row] + power_w[row - 1]) - heat_j * (found - previous) / dt_s
            steady_w[row] = given_w + (steady_w[row - 1] - given_w) * math.exp(-dt_s / tau_s)
            found = 0.5 * found + 0.5 * float(np.clip((steady_w[row] - 0.1) / 0.25, 0.0, 1.0))
        place[row] = found
    resistance = 0.2 + 0.3 * steady_w - 0.6 * place
    return WireMotion(time_s, power_w, place, resistance + noise * np.random.default_rng(1).standard_normal(1200))


def test_the_steady_power_of_a_step_is_the_exponential() -> None:
    time_s = np.linspace(0.0, 4.0, 81)
    power_w = np.where(time_s > 0.0, 1.0, 0.0)
    motion = WireMotion(time_s, power_w, np.zeros(81), np.zeros(81))
    steady_w = steady_power_w(motion, 0.8, 0.1)
    assert steady_w[1:] == pytest.approx(1.0 - np.exp(-(time_s[1:] - 0.025) / 0.8), abs=0.002)


@pytest.mark.parametrize(("tau_s", "period_s"), [(0.5, 14.0), (1.2, 14.0), (2.5, 14.0), (1.2, 30.0)])
def test_a_loop_that_is_fast_shows_its_time_constant(tau_s: float, period_s: float) -> None:
    motion = moving(tau_s, 0.05 * tau_s, period_s, noise=1e-4)
    found = by_motion(balance(1.0, 0.05, 1.0, "a guess"), motion)
    assert found.time_constant_s.origin == MEASURED
    assert abs(found.time_constant_s.value - tau_s) < 2.0 * found.time_constant_s.std
    assert found.time_constant_s.std < 0.25 * tau_s


def test_a_loop_that_is_slow_leaves_what_was_known_before() -> None:
    guess = balance(1.0, 0.05, 0.3, "a guess")
    found = by_motion(guess, moving(1.2, 0.06, 3600.0, noise=1e-3))
    assert found.time_constant_s.origin == "a guess"
    assert found.time_constant_s.std == pytest.approx(0.3, rel=0.35)


def test_an_end_where_the_wire_does_not_rest_is_left_alone() -> None:
    guess = balance(1.0, 0.05, 0.3, "a guess")
    motion = WireMotion(*(one[:12] for one in moving(1.2, 0.06, 14.0)))
    assert by_motion(guess, motion) == guess


def test_a_wire_of_no_size_is_any_that_is_sold(model: SensingModel) -> None:
    found = by_diameter(replace(model, wire={}))
    assert "0.025 to 0.51 mm" in found.time_constant_s.origin
    assert found.time_constant_s.std > found.time_constant_s.value
    typical = by_diameter(replace(model, wire={"wire_diameter_m": TYPICAL_DIAMETER_M}))
    assert typical.time_constant_s.value == pytest.approx(found.time_constant_s.value, rel=0.01)


def minor(wire: WireModel, model: SensingModel, law: float) -> tuple[HeatBalanceFound, WireMotion]:
    """Return a slow motion to the middle of the branches and back, by a law, three times."""
    known = heat_balance_of(model)
    places, hours_s = wire.places, 1e5
    drive_w = np.concatenate([np.linspace(0.02, 0.42, 400), np.linspace(0.42, 0.02, 400), np.linspace(0.02, 0.42, 400)])
    up, down = (np.interp(drive_w, one, places) for one in (wire.heating_power_w, wire.cooling_power_w))
    at = up[399]
    back = (1.0 - law) * np.minimum(at, down[400:800]) + law * at * down[400:800] / places[-1]
    place = np.concatenate([up[:400], back, up[800:]])
    time_s = np.linspace(0.0, 3.0 * hours_s, 3600)
    return known, WireMotion(time_s, np.tile(drive_w, 3), np.tile(place, 3), np.zeros(3600))


@pytest.mark.parametrize("law", [0.0, 0.4, 1.0])
def test_a_minor_loop_shows_its_law(law: float, model: SensingModel, wire: WireModel) -> None:
    found = law_of_minor_loops(wire, *minor(wire, model, law))
    assert found.value == pytest.approx(law, abs=0.08)
    assert found.std < ANY_LAW.std


def test_turns_that_follow_different_laws_make_the_number_less_certain(model: SensingModel, wire: WireModel) -> None:
    (known, play), (_, scaled) = (minor(wire, model, law) for law in (0.0, 1.0))
    once = law_of_minor_loops(wire, known, play)
    later_s = play.time_s[-1] + 100.0
    places = [np.concatenate([one.place for one in pair]) for pair in ((play, play), (play, scaled))]
    time_s, power_w = np.concatenate([play.time_s, later_s + play.time_s]), np.tile(play.power_w, 2)
    alike, unlike = (
        law_of_minor_loops(wire, known, WireMotion(time_s, power_w, place, np.zeros(place.size))) for place in places
    )
    assert alike.std < once.std  # nobody knows of a single turn how much turns differ
    assert unlike.std > 0.15
    assert unlike.std > 3.0 * alike.std
    assert unlike.value == pytest.approx(0.5, abs=0.1)


def test_a_cold_end_of_a_minor_loop_says_nothing_of_its_law(model: SensingModel, wire: WireModel) -> None:
    """Below B the place goes on with the power, the quantity does not."""
    known, motion = minor(wire, model, 0.0)
    cold = motion.power_w < 0.05
    still = motion._replace(place=np.where(cold, wire.sensed_from.value, motion.place))
    assert law_of_minor_loops(wire, known, still).value == pytest.approx(0.0, abs=0.1)


def test_a_loop_without_one_may_have_any(loop: Recording) -> None:
    found = fit(loop.between()).wire_model
    assert found is not None
    assert found.minor_loops == ANY_LAW
