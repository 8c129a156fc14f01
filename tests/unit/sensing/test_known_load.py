from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.sensing._known_load import KnownSpring, force_model
from musclewire.sensing._model import SensingModel

STRAIN = SensingModel(15.0, 17.0, (0.0352, -0.03), (0.0348, -0.03), 0.0, 1.0, rmse_heating=1e-4)


@given(st.floats(10.0, 1e4), st.floats(0.01, 1.0), st.floats(15.0, 17.0))
def test_force_is_stiffness_times_length_times_strain(stiffness: float, length: float, ohm: float) -> None:
    force = force_model(STRAIN, stiffness, length)
    assert force.quantity == "force"
    assert force.value(ohm) == pytest.approx(stiffness * length * STRAIN.strain(ohm), rel=1e-12)
    assert force.estimate(ohm).std == pytest.approx(stiffness * length * STRAIN.estimate(ohm).std, rel=1e-9)


def test_a_displacement_needs_no_length_to_become_a_force() -> None:
    metres = SensingModel(15.0, 17.0, (0.0024, -0.002), (0.0024, -0.002), 0.0, 1.0, quantity="displacement")
    assert force_model(metres, 500.0, 0.07).value(16.0) == pytest.approx(500.0 * 0.0014)


def test_a_model_of_force_is_refused_with_what_to_use() -> None:
    force = force_model(STRAIN, 588.6, 0.07)
    with pytest.raises(CallerError, match="give one of strain"):
        force_model(force, 588.6, 0.07)


@pytest.mark.parametrize("stiffness", [0.0, -1.0, float("nan"), float("inf")])
def test_a_stiffness_that_cannot_be_is_refused(stiffness: float) -> None:
    with pytest.raises(CallerError, match="stiffness"):
        KnownSpring(stiffness)


def test_friction_follows_the_direction_of_motion_and_stays_when_the_wire_stops() -> None:
    spring = KnownSpring(500.0, friction_n=0.05, turning_m=1e-4)
    up = spring.friction_after(-0.05, 500.0 * 5e-4)
    assert up == 0.05
    assert spring.friction_after(up, 0.0) == up
    # Half of the turning travel takes half of the way from one limit to zero and no more.
    assert spring.friction_after(up, -500.0 * 5e-5) == pytest.approx(0.025)
    assert spring.friction_after(up, -500.0 * 5e-3) == -0.05


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=30))
def test_friction_never_exceeds_its_limit(changes: list[float]) -> None:
    spring = KnownSpring(300.0, friction_n=0.03)
    friction = 0.03
    for change in changes:
        friction = spring.friction_after(friction, change)
        assert abs(friction) <= 0.03


def test_without_friction_there_is_none() -> None:
    assert KnownSpring(300.0).friction_after(0.0, 1.0) == 0.0
    assert np.isfinite(force_model(STRAIN, 300.0, 0.07).quantity_max)
