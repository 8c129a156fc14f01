from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.physics import (
    air_thermal_conductivity_w_per_m_k,
    convection_coefficient_w_per_m2_k,
    convection_range_note,
    nusselt_morgan,
    rayleigh_of_wire,
)
from musclewire.physics._heat import (
    air_dynamic_viscosity_pa_s,
    air_prandtl,
    churchill_chu_from_k,
    nusselt_churchill_chu,
)
from musclewire.rigs import open_rig

# Incropera and DeWitt, Table A.4, air at one atmosphere: T [K], mu [1e-7 Pa s], k [1e-3 W/(m K)], Pr.
AIR = [(300.0, 184.6, 26.3, 0.707), (350.0, 208.2, 30.0, 0.700), (400.0, 230.1, 33.8, 0.690)]

# Wires at 90 C in air of 22 C: diameter [thousandths of an inch], Churchill and Chu, Morgan [W/(m2 K)], evaluated
# apart from this package with its own properties of air. Dynalloy's wires are listed by
# their rounded millimetres (0.10 mm); they are drawn to inches (0.1016 mm), and only with those do both agree.
HOT_WIRES = [
    (1.0, 496, 434),
    (1.5, 345, 310),
    (2.0, 268, 245),
    (3.0, 190, 175),
    (4.0, 149, 138),
    (5.0, 125, 115),
    (6.0, 108, 102),
    (8.0, 86, 87),
    (10.0, 73, 77),
    (12.0, 64, 69),
    (15.0, 54, 61),
    (20.0, 44, 52),
]
WALL_K, AIR_K = 363.15, 295.15


@pytest.mark.parametrize(("temperature_k", "viscosity", "conductivity", "prandtl"), AIR)
def test_air_is_the_air_of_a_printed_table(
    temperature_k: float, viscosity: float, conductivity: float, prandtl: float
) -> None:
    """Within 1 %: two fits to measured air, and a constant specific heat in the Prandtl number (2 %)."""
    assert air_dynamic_viscosity_pa_s(temperature_k) * 1e7 == pytest.approx(viscosity, rel=0.01)
    assert air_thermal_conductivity_w_per_m_k(temperature_k) * 1e3 == pytest.approx(conductivity, rel=0.01)
    assert air_prandtl(temperature_k) == pytest.approx(prandtl, rel=0.02)


@pytest.mark.parametrize(("thousandths", "churchill_chu", "morgan"), HOT_WIRES)
def test_both_correlations_give_the_tabled_coefficients(
    thousandths: float, churchill_chu: float, morgan: float
) -> None:
    """To 1 W/(m2 K), the table's rounding, or 1 %, the spread of published properties of air."""
    diameter = thousandths * 25.4e-6
    ours = convection_coefficient_w_per_m2_k(WALL_K, AIR_K, diameter)
    conductivity = air_thermal_conductivity_w_per_m_k((WALL_K + AIR_K) / 2)
    by_morgan = nusselt_morgan(rayleigh_of_wire(WALL_K, AIR_K, diameter)) * conductivity / diameter
    assert abs(ours - churchill_chu) <= max(1.0, 0.01 * churchill_chu)
    assert abs(by_morgan - morgan) <= max(1.0, 0.01 * morgan)


def test_churchill_and_chu_give_the_number_of_another_library() -> None:
    """The example in ht's documentation, Nu_horizontal_cylinder_Churchill_Chu(Pr=0.69, Gr=2.63e9); Ra = Gr Pr."""
    assert nusselt_churchill_chu(2.63e9 * 0.69, 0.69) == pytest.approx(139.13493970073597, rel=1e-9)


def test_churchill_and_chu_come_within_the_rounding_of_a_textbook_example() -> None:
    """Incropera and DeWitt, Example 9.4, print 23.3 from rounded intermediate results; the formula gives 23.0."""
    assert nusselt_churchill_chu(5.003e6, 0.703) == pytest.approx(23.3, rel=0.02)


def test_without_buoyancy_churchill_chu_leaves_conduction() -> None:
    assert nusselt_churchill_chu(0.0, 0.7) == pytest.approx(0.36)
    assert convection_coefficient_w_per_m2_k(AIR_K, AIR_K, 1e-4) == pytest.approx(
        0.36 * air_thermal_conductivity_w_per_m_k(AIR_K) / 1e-4
    )


def test_morgans_pieces_nearly_meet() -> None:
    assert nusselt_morgan(0.01 * (1 - 1e-9)) == pytest.approx(nusselt_morgan(0.01), rel=0.025)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    wall=st.floats(260.0, 500.0),
    warmer=st.floats(1.0, 100.0),
    air=st.floats(250.0, 320.0),
    diameter=st.floats(2e-5, 1e-3),
)
def test_a_finer_wire_loses_more_per_area_and_the_coefficient_is_finite(
    wall: float, warmer: float, air: float, diameter: float
) -> None:
    here = convection_coefficient_w_per_m2_k(wall, air, diameter)
    assert 0.0 < here < 5000.0
    assert convection_coefficient_w_per_m2_k(wall, air, diameter / 2) > here
    # Not in general, but at these temperatures a hotter wall loses more heat.
    hot = max(wall, air)
    loss = [convection_coefficient_w_per_m2_k(t, air, diameter) * (t - air) for t in (hot, hot + warmer)]
    assert loss[1] > loss[0]


def test_the_range_of_churchill_and_chu_is_checked_for_a_wire() -> None:
    """The catalogue's thinnest wire lies outside of it up to some kelvin above the air; the paper's wires do not."""
    begins_k = churchill_chu_from_k(25e-6, AIR_K)
    assert rayleigh_of_wire(AIR_K + begins_k, AIR_K, 25e-6) == pytest.approx(1e-5, rel=1e-5)
    assert rayleigh_of_wire(AIR_K + 1.0, AIR_K, 25e-6) < 1e-5
    assert "25 um is below the published range of Churchill and Chu" in convection_range_note(25e-6, AIR_K)
    assert convection_range_note(100e-6, AIR_K) == ""
    assert churchill_chu_from_k(1e-6, AIR_K) == math.inf
    assert "within 600.0 K" in convection_range_note(1e-6, AIR_K)


def test_a_recording_of_a_wire_outside_the_range_says_so() -> None:
    with open_rig("simulated", wire="flexinol-0.025-ht", pretension_n=0.2) as rig:
        assert "Churchill and Chu" in str(rig.metadata()["convection_note"])
    with open_rig("simulated") as rig:
        assert "convection_note" not in rig.metadata()
