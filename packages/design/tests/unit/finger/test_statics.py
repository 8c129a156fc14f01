"""The finger at large deflection: closed forms, derivatives, virtual work, contact."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from musclewire_design._finger.chain import finger_chain, place
from musclewire_design._finger.closed_forms import pure_moment_stiffness_n_per_m
from musclewire_design._finger.curve import (
    beam_stress_pa,
    bent_per_m,
    finger_curve,
    linear_error,
    reciprocity_error,
    touch_curve,
    travel_for_endpoint_m,
)
from musclewire_design._finger.geometry import FingerGeometry
from musclewire_design._finger.statics import (
    FingerProblem,
    equilibria,
    equilibrium,
    sensitivity,
)
from packages.design.tests.unit.finger.fingers import CURVED, PLAIN

from musclewire.errors import CallerError
from musclewire.wire import ElasticObject

TRAVELS = np.linspace(0.0, 1.05e-3, 22)


def bends_as_m(geometry: FingerGeometry) -> float:
    """The length as which the segments bend, feet included (O'Donnell 1960)."""
    return geometry.flexible_length_m + (2 * geometry.columns - 1) * 0.442 * geometry.beam_thickness_m


@pytest.mark.parametrize(("columns", "within"), [(4, 1e-3), (8, 3e-4)])
def test_the_stiffness_is_that_of_a_pure_moment(columns: int, within: float) -> None:
    finger = PLAIN.with_(columns=columns, column_width_m=0.1e-3)
    first = equilibrium(finger_chain(finger), finger.stiffness_n_m2, 1e-7)
    closed = pure_moment_stiffness_n_per_m(finger.stiffness_n_m2, finger.tendon_offset_m, bends_as_m(finger))
    assert first.tendon_force_n / first.travel_m == pytest.approx(closed, rel=within)


def test_a_straight_finger_bends_by_travel_over_offset() -> None:
    bent = equilibria(finger_chain(PLAIN), PLAIN.stiffness_n_m2, TRAVELS)[-1]
    assert bent.angles_rad[-1] == pytest.approx(bent.travel_m / PLAIN.tendon_offset_m, rel=0.01)
    moment = bent.tendon_force_n * PLAIN.tendon_offset_m
    assert bent_per_m(bent) == pytest.approx(np.full(32, moment / PLAIN.stiffness_n_m2), rel=0.03)
    bending = 0.5 * PLAIN.youngs_modulus_pa * PLAIN.beam_thickness_m * moment / PLAIN.stiffness_n_m2
    pressing = bent.tendon_force_n / (PLAIN.beam_depth_m * PLAIN.beam_thickness_m)
    assert beam_stress_pa(PLAIN, bent).max() == pytest.approx(bending + pressing, rel=0.03)


def test_more_elements_change_the_force_by_two_thousandths_at_most() -> None:
    # The feet of the beam are distributed over the elements next to them, so it is their size that is felt.
    coarse, fine = (
        equilibria(finger_chain(CURVED, elements_per_segment=n), CURVED.stiffness_n_m2, TRAVELS)[-1] for n in (8, 32)
    )
    assert coarse.tendon_force_n == pytest.approx(fine.tendon_force_n, rel=2e-3)
    assert coarse.endpoint_displacement_m == pytest.approx(fine.endpoint_displacement_m, rel=5e-4)


angles = st.lists(st.floats(-1.5, 1.5), min_size=16, max_size=16).map(np.array)


@given(angles, st.floats(-2.0, 2.0), st.floats(-0.5, 0.5))
def test_the_derivatives_are_those_of_the_energy(at: np.ndarray, force: float, push: float) -> None:
    chain = finger_chain(CURVED, elements_per_segment=4)
    problem = FingerProblem(chain, CURVED.stiffness_n_m2)

    def energy(angles_rad: np.ndarray) -> float:
        placed = place(chain, angles_rad)
        turns = chain.turns @ angles_rad - chain.natural_turn_rad
        bent = 0.5 * CURVED.stiffness_n_m2 * (turns**2 / chain.yielding_m).sum()
        return float(bent + push * problem.displacement_m(placed) - force * problem.travel_m(placed))

    def slope(angles_rad: np.ndarray) -> np.ndarray:
        return problem.moments(angles_rad, place(chain, angles_rad), force, push)

    direction = np.cos(np.arange(16.0))
    step = 1e-5
    along = (energy(at + step * direction) - energy(at - step * direction)) / (2 * step)
    assert slope(at) @ direction == pytest.approx(along, rel=1e-6, abs=1e-8)
    turned = (slope(at + step * direction) - slope(at - step * direction)) / (2 * step)
    assert problem.tangent(place(chain, at), force, push) @ direction == pytest.approx(turned, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("finger", [PLAIN, CURVED])
def test_the_tendons_work_is_the_energy_in_the_beam(finger: FingerGeometry) -> None:
    chain = finger_chain(finger)
    found = equilibria(chain, finger.stiffness_n_m2, np.linspace(0.0, 1e-3, 41))
    force = np.array([at.tendon_force_n for at in found])
    turns = chain.turns @ found[-1].angles_rad - chain.natural_turn_rad
    stored = 0.5 * finger.stiffness_n_m2 * (turns**2 / chain.yielding_m).sum()
    assert np.trapezoid(force, dx=1e-3 / 40) == pytest.approx(stored, rel=1e-4)


@pytest.mark.parametrize("finger", [PLAIN, CURVED])
def test_the_tendon_feels_an_endpoint_force_as_the_endpoint_feels_the_travel(finger: FingerGeometry) -> None:
    assert reciprocity_error(finger, TRAVELS[2:]) < 1e-5
    slope = sensitivity(equilibria(finger_chain(finger), finger.stiffness_n_m2, TRAVELS)[10])
    assert slope.tendon_force_per_endpoint_force == pytest.approx(slope.endpoint_per_travel, rel=1e-9)


def test_the_linear_answer_to_an_endpoint_force_holds_over_the_working_range() -> None:
    worst = linear_error(CURVED, TRAVELS[1:], np.array([0.05, 0.1]))
    assert worst.displacement_fraction < 0.002
    assert worst.tendon_force_fraction < 0.01
    # What is left out is of second order: half the force leaves a quarter.
    half = linear_error(CURVED, TRAVELS[1:], np.array([0.025, 0.05]))
    assert worst.displacement_m / half.displacement_m == pytest.approx(4.0, rel=0.15)


@given(st.floats(4.5e-3, 6.5e-3), st.floats(5.0, 1e5))
def test_an_object_pushes_back_as_deep_as_it_is_pressed(clearance: float, stiffness: float) -> None:
    for at in touch_curve(CURVED, TRAVELS, ElasticObject(stiffness, clearance)):
        depth = max(at.endpoint_displacement_m - clearance, 0.0)
        assert at.endpoint_force_n == pytest.approx(stiffness * depth)


def test_an_object_too_hard_to_press_stops_the_endpoint_and_costs_the_tendon() -> None:
    at = touch_curve(CURVED, TRAVELS, ElasticObject(1e6, 5e-3))[-1]
    free = equilibria(finger_chain(CURVED), CURVED.stiffness_n_m2, TRAVELS)[-1]
    assert at.endpoint_displacement_m == pytest.approx(5e-3, rel=1e-3)
    assert at.tendon_force_n > 2.0 * free.tendon_force_n


def test_an_endpoint_beyond_the_travel_is_refused_with_the_excess() -> None:
    with pytest.raises(CallerError, match=r"moves 3\.\d+ mm at a travel of 0\.500 mm: \d\d\.\d % less than the 6 mm"):
        travel_for_endpoint_m(finger_chain(PLAIN), PLAIN.stiffness_n_m2, 6e-3, 0.5e-3)


def test_a_curve_that_curls_back_is_refused() -> None:
    with pytest.raises(CallerError, match="moves back"):
        finger_curve(PLAIN, np.linspace(0.0, 2.4e-3, 25))
