from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.sensing import KnownSpring, PolynomialEstimator, SensingModel, estimates, force_model
from musclewire.signals import WireSample

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


def forces(spring: KnownSpring, course_n: list[float]) -> list[float]:
    """Return the estimated forces [N] of a wire whose spring is pulled with these, friction included."""
    curve = SensingModel(15.0, 17.0, (10.0, -10.0), (10.0, -10.0), 0.0, 1.0, quantity="force")
    samples = [WireSample(0.0, 2.0, curve.resistance_ohm(force_n), 1.0) for force_n in course_n]
    found = estimates(PolynomialEstimator(curve, 1.0, spring), samples)
    return [estimate.value - force_n for (estimate, _), force_n in zip(found, course_n, strict=True)]


def test_friction_follows_the_direction_of_motion_and_stays_when_the_wire_stops() -> None:
    spring = KnownSpring(500.0, friction_n=0.05, turning_m=1e-4)
    # Half of the turning travel takes half of the way from one limit to zero and no more.
    course_n = [5.0, 5.25, 5.25, 5.225, 2.725, 2.725, 2.975]
    expected_n = [0.05, 0.05, 0.05, 0.025, -0.05, -0.05, 0.05]
    assert forces(spring, course_n) == pytest.approx(expected_n, abs=1e-9)


@given(st.lists(st.floats(0.0, 10.0), min_size=1, max_size=30))
def test_friction_never_exceeds_its_limit(course_n: list[float]) -> None:
    assert max(map(abs, forces(KnownSpring(300.0, friction_n=0.03), course_n))) <= 0.03 + 1e-9
