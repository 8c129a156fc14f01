from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.sensing.contact import ContactDetector, FreeClosing
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
FREE = FreeClosing(15.0, 17.5, (0.5,), (0.25,), 0.0, 1.0, 0.001, 0.6)
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


def test_a_known_stiffness_picks_the_place_from_which_power_grows_as_it_should() -> None:
    # Two candidates that explain the power alike well, by a steep slope from near and by a flat one from far.
    near, far, here = 0.6, 0.8, 0.5
    slopes = [0.05 * 5.0 * CURVE.force_n(here, place, stiffness) / (place - here) for place, stiffness in
              ((near, 1000.0), (far, 100.0))]  # fmt: skip
    weights = np.array([4.0 / slope**2 for slope in slopes])
    state = (
        ContactDetector(FREE)
        .start()
        ._replace(
            normalised=here,
            places=np.array([near, far]),
            overlaps=weights * np.array(slopes),
            weights=weights,
            place=far,
        )
    )
    assert CURVE.contact_place(state, 1000.0) == near
    assert CURVE.contact_place(state, 100.0) == far


def test_without_candidates_the_place_is_the_detectors() -> None:
    state = ContactDetector(FREE).start()
    assert CURVE.contact_place(state, 200.0) == state.place
