from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.physics._resistance import phase_resistivity_ohm_m, wire_resistance_ohm

AREA_M2 = math.pi / 4 * 100e-6**2


def test_resistivity_is_as_stated_at_20_degrees_and_linear_from_there() -> None:
    assert phase_resistivity_ohm_m(1e-6, 4e-4, 293.15) == 1e-6
    assert phase_resistivity_ohm_m(1e-6, 4e-4, 393.15) == pytest.approx(1.04e-6)
    assert phase_resistivity_ohm_m(1e-6, -4e-4, 393.15) == pytest.approx(0.96e-6)


def test_an_undeformed_wire_has_resistivity_times_length_over_area() -> None:
    """126 ohm/m over 14 cm, the paper's 100 um wire: 17.64 ohm."""
    rho = 126.0 * AREA_M2
    assert wire_resistance_ohm(rho, 0.14, AREA_M2, 0.0, 0.0, 0.0) == pytest.approx(17.64)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(strain=st.floats(0.0, 0.08))
def test_transformation_strain_keeps_the_volume(strain: float) -> None:
    length = 0.14 * (1 + strain)
    area = AREA_M2 * 0.14 / length
    expected = 1e-6 * length / area
    assert wire_resistance_ohm(1e-6, 0.14, AREA_M2, strain, 0.0, 0.0) == pytest.approx(expected, rel=1e-12)


def test_thermal_expansion_lowers_the_resistance_by_geometry() -> None:
    """Longer by a share and wider by the same on both sides: l/A falls by that share."""
    expected = 1e-6 * 0.14 * 1.001 / (AREA_M2 * 1.001**2)
    assert wire_resistance_ohm(1e-6, 0.14, AREA_M2, 0.0, 0.0, 0.001) == pytest.approx(expected, rel=1e-12)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(strain=st.floats(-0.02, 0.02))
def test_elastic_strain_thins_the_wire_by_poissons_ratio(strain: float) -> None:
    diameter = 100e-6 * (1 - 0.33 * strain)
    expected = 1e-6 * 0.14 * (1 + strain) / (math.pi / 4 * diameter**2)
    assert wire_resistance_ohm(1e-6, 0.14, AREA_M2, 0.0, strain, 0.0) == pytest.approx(expected, rel=1e-12)
