from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.physics._material import (
    friction_force_n,
    maximum_transformation_strain,
    maximum_transformation_strain_slope_per_pa,
    reuss_modulus_pa,
)

SETTINGS = settings(derandomize=True, deadline=None, max_examples=100)
STRAINS = st.floats(0.005, 0.08)
SCALES_PA = st.floats(10e6, 500e6)


def test_phases_in_series_add_their_compliances() -> None:
    """Half of 30 GPa and half of 60 GPa in series: the harmonic mean, 40 GPa."""
    assert reuss_modulus_pa(0.5, 60e9, 30e9) == pytest.approx(40e9)
    assert reuss_modulus_pa(0.0, 60e9, 30e9) == pytest.approx(60e9)
    assert reuss_modulus_pa(1.0, 60e9, 30e9) == pytest.approx(30e9)


@SETTINGS
@given(x=st.floats(0.0, 1.0), e_a=st.floats(1e9, 200e9), e_m=st.floats(1e9, 200e9))
def test_the_modulus_of_a_mixture_lies_between_its_phases_and_below_their_mean(
    x: float, e_a: float, e_m: float
) -> None:
    mixed = reuss_modulus_pa(x, e_a, e_m)
    assert min(e_a, e_m) * (1 - 1e-12) <= mixed <= max(e_a, e_m) * (1 + 1e-12)
    assert mixed <= ((1 - x) * e_a + x * e_m) * (1 + 1e-12)


def test_the_transformation_strain_begins_and_ends_where_it_is_told_to() -> None:
    assert maximum_transformation_strain(0.0, 0.01, 0.05, 100e6) == pytest.approx(0.01)
    assert maximum_transformation_strain(100e6, 0.01, 0.05, 100e6) == pytest.approx(0.05 - 0.04 / math.e)
    assert maximum_transformation_strain(5e9, 0.01, 0.05, 100e6) == pytest.approx(0.05)


@SETTINGS
@given(stress=st.floats(0.0, 600e6), h_0=STRAINS, h_sat=STRAINS, scale=SCALES_PA)
def test_the_slope_is_the_derivative_of_the_transformation_strain(
    stress: float, h_0: float, h_sat: float, scale: float
) -> None:
    step = 1e-4 * scale

    def strain(at: float) -> float:
        return maximum_transformation_strain(at, h_0, h_sat, scale)

    difference = (strain(stress + step) - strain(stress - step)) / (2 * step)
    slope = maximum_transformation_strain_slope_per_pa(stress, h_0, h_sat, scale)
    # Rounding of strains near 0.05 over the step is 1e-17/step; truncation is (1e-4)^2/6 of the slope.
    assert slope == pytest.approx(difference, rel=1e-6, abs=1e-16 / step)


MOVES_M = st.lists(st.floats(-1e-3, 1e-3), min_size=1, max_size=30)


def after(moves: list[float], limit_n: float = 0.03, presliding_m: float = 20e-6) -> float:
    friction = 0.0
    for move in moves:
        friction = friction_force_n(friction, move, limit_n, presliding_m)
    return friction


@SETTINGS
@given(moves=MOVES_M)
def test_friction_never_exceeds_its_limit(moves: list[float]) -> None:
    assert abs(after(moves)) <= 0.03


@SETTINGS
@given(moves=MOVES_M, parts=st.integers(2, 9))
def test_friction_depends_on_the_way_and_not_on_its_pace(moves: list[float], parts: int) -> None:
    in_parts = [move / parts for move in moves for _ in range(parts)]
    assert after(in_parts) == pytest.approx(after(moves), abs=1e-12)


def test_friction_is_elastic_first_then_coulombs_and_stays_at_rest() -> None:
    assert after([5e-6]) == pytest.approx(0.03 / 4)
    assert after([1.0]) == 0.03
    assert after([1.0, 0.0, 0.0]) == 0.03
    assert after([1.0, -40e-6]) == pytest.approx(-0.03)


def test_a_guide_without_friction_has_none() -> None:
    assert friction_force_n(0.01, 1e-3, 0.0, 20e-6) == 0.0


@SETTINGS
@given(moves=MOVES_M)
def test_friction_takes_work_over_a_closed_way(moves: list[float]) -> None:
    """It may give back what is stored elastically and no more: half of limit times presliding travel."""
    friction, work = 0.0, 0.0
    for move in moves:
        for _ in range(200):
            new = friction_force_n(friction, move / 200, 0.03, 20e-6)
            work += 0.5 * (friction + new) * move / 200
            friction = new
    # The rounded corner between elastic and sliding is cut by one of 200 parts of up to 1 mm.
    assert work >= -0.03 * 5e-6 * len(moves)
