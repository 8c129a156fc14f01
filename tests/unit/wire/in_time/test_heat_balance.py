"""The heat balance of a wire that never transforms, against SciPy's LSODA on equations written out again."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from wire_makers import constants, stepped

from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.wire import WireConstants, WireState, resting_state

# Cold martensite at any temperature reached here, and no latent heat.
INERT = {"latent_heat_j_per_kg": 0.0, "martensite_temperature_k": 3000.0, "r_phase_temperature_k": 300.0}
HISTORY_V = (3.2, 1.0, 2.5, 0.3)
PIECE_S = 1.6


def inert_wire() -> WireConstants:
    return constants(bench_values={"guide_friction_n": 0.0}, **INERT)


def resistance_ohm(temperature_k: float, wire: WireConstants) -> float:
    """Return the resistance of the martensite wire on its spring at this temperature."""
    warm = temperature_k - 293.15

    def strains(stress: float) -> tuple[float, float, float]:
        h = wire.strain_saturated + (wire.strain_at_no_stress - wire.strain_saturated) * math.exp(
            -stress / wire.strain_stress_scale_pa
        )
        return h, stress / wire.martensite_modulus_pa, wire.martensite_expansion_per_k * warm

    def missing(stress: float) -> float:
        # A leg as measured is longer than its austenite by the cold strain, from which strains count.
        austenite_leg_m = wire.leg_length_m / (1 + wire.cold_strain)
        stretch = wire.spring_stiffness_n_per_m * austenite_leg_m * (wire.cold_strain - sum(strains(stress)))
        return stress - (wire.pretension_n + stretch) / (2 * wire.area_m2)

    h, elastic, thermal = strains(brentq(missing, 0.0, 1e9, xtol=1.0))
    rho = wire.martensite_resistivity_ohm_m * (1 + wire.martensite_resistivity_per_k * warm)
    shape = (1 + h) ** 2 * (1 + elastic) / (1 - 0.33 * elastic) ** 2 / (1 + thermal)
    return rho * wire.austenite_length_m / wire.area_m2 * shape


def reference_temperatures_k(wire: WireConstants) -> list[float]:
    """Return the temperature at the end of each piece of the history."""
    diameter = math.sqrt(4 * wire.area_m2 / math.pi)

    def slope(_: float, y: np.ndarray, voltage: float) -> list[float]:
        resistance = resistance_ohm(y[0], wire)
        power = (voltage / (resistance + wire.series_resistance_ohm)) ** 2 * resistance
        h = wire.convection_factor * convection_coefficient_w_per_m2_k(y[0], wire.ambient_temperature_k, diameter)
        return [(power - h * wire.surface_m2 * (y[0] - wire.ambient_temperature_k)) / wire.heat_capacity_j_per_k]

    found = [wire.ambient_temperature_k]
    for voltage in HISTORY_V:
        solved = solve_ivp(slope, (0, PIECE_S), [found[-1]], method="LSODA", rtol=1e-9, atol=1e-9, args=(voltage,))
        found.append(float(solved.y[0, -1]))
    return found[1:]


def our_temperatures_k(wire: WireConstants, dt_s: float) -> list[float]:
    state: WireState = resting_state(wire)
    found = []
    for voltage in HISTORY_V:
        state, _ = stepped(state, wire, voltage, dt_s, round(PIECE_S / dt_s))
        found.append(state.temperature_k)
    assert state.martensite_fraction == pytest.approx(1.0, abs=1e-12)
    return found


def test_without_transformation_the_temperature_is_that_of_scipy() -> None:
    """Heat is lost at the mean of both ends of a step; what is left is the convection table, linear over 2 K."""
    wire = inert_wire()
    assert our_temperatures_k(wire, 1e-3) == pytest.approx(reference_temperatures_k(wire), abs=0.003)


def test_the_error_against_scipy_falls_with_the_square_of_the_step() -> None:
    wire = inert_wire()
    reference = np.array(reference_temperatures_k(wire))
    coarse, middle, fine = (
        np.abs(np.array(our_temperatures_k(wire, dt)) - reference).max() for dt in (0.08, 0.04, 0.02)
    )
    # Order two gives 4.
    assert 3.5 < coarse / middle < 4.7
    assert 3.5 < middle / fine < 4.7
