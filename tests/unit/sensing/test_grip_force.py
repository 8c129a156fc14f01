from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.sensing.grip_force import GripCurve

# Two fingers whose endpoints move 6 mm while resistance falls through its range, lever 5 throughout.
CURVE = GripCurve(
    fingers=2,
    endpoint_m=(6e-3, -6e-3),
    leverage=(5.0,),
    finger_compliance_m_per_n=1e-3,
    wire_compliance_m_per_n=4e-5,
    power_per_newton_w=(0.05,),
    normalised_min=0.0,
    normalised_max=1.0,
)
# Springs in series: the object's, two fingers of 1 mm/N and two wires of 0.04 mm/N at a lever of 5.
GIVE_M_PER_N = 2 * 1e-3 + 2 * 4e-5 * 25


@given(st.floats(0.0, 0.9), st.floats(10.0, 5000.0), st.floats(0.0, 1.0))
def test_travel_is_shared_by_springs_in_series(contact: float, stiffness: float, share: float) -> None:
    place = contact * share
    force = CURVE.force_n(place, contact, stiffness)
    assert force == pytest.approx(2 * 6e-3 * (contact - place) / (1 / stiffness + GIVE_M_PER_N), rel=1e-9, abs=1e-12)


@given(st.floats(0.1, 0.9), st.floats(10.0, 5000.0))
def test_no_object_is_held_harder_than_a_rigid_one(place: float, stiffness: float) -> None:
    assert CURVE.force_n(place, 0.95, stiffness) <= CURVE.most_force_n(place, 0.95)
    assert CURVE.most_force_n(place, 0.95) == pytest.approx(12e-3 * (0.95 - place) / GIVE_M_PER_N, rel=1e-3)


@given(st.floats(0.1, 0.8), st.floats(20.0, 2000.0))
def test_power_tells_stiffness_where_a_newton_costs_what_was_learned(place: float, stiffness: float) -> None:
    force = CURVE.force_n(place, 0.9, stiffness)
    slope_w = 0.05 * 5.0 * force / (0.9 - place)
    assert CURVE.force_by_power_n(place, 0.9, slope_w) == pytest.approx(force)
    assert CURVE.stiffness_by_power_n_per_m(place, 0.9, slope_w) == pytest.approx(stiffness, rel=1e-6)


def test_power_beyond_what_a_rigid_object_costs_says_rigid_and_none_says_soft() -> None:
    assert CURVE.stiffness_by_power_n_per_m(0.5, 0.9, 100.0) == 1e6
    assert CURVE.stiffness_by_power_n_per_m(0.5, 0.9, 0.0) == 1.0


def test_before_contact_there_is_no_force() -> None:
    assert CURVE.force_n(0.9, 0.8, 200.0) == 0.0
    assert CURVE.force_by_power_n(0.9, 0.8, 1.0) == 0.0


@pytest.mark.parametrize("wrong", [{"fingers": 0}, {"finger_compliance_m_per_n": -1.0}, {"power_per_newton_w": (0.0,)}])
def test_a_curve_that_cannot_be_is_refused(wrong: dict) -> None:
    with pytest.raises(CallerError):
        replace(CURVE, **wrong)
