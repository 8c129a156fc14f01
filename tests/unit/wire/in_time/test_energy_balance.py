"""Energy over long runs, over closed cycles, and counted again from what a recording would show."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wire_makers import ALLOYS, Array, alloy, bench, constants, driven, slow_sine_v, wire_100um

from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.wire import DrivenPath, WireConstants, WireState, resting_state

DT_S = 1e-3
CYCLE_V = np.array([slow_sine_v(t) for t in np.arange(0.05, 90.0, 0.1)])
# Heats fast, holds, cools fast, turns in the middle of the transformation.
SWINGS_V = np.repeat((3.2, 0.3, 3.0, 1.6, 2.4, 1.2, 3.4, 0.0), 3000)
MASS_KG = math.pi / 4 * 100e-6**2 * 0.14 * 6450.0
SURFACE_M2 = math.pi * 100e-6 * 0.14


def held_j(state: WireState, wire: WireConstants) -> float:
    """Return m c (T - 20 C) - m L (x_M + r x_R)."""
    values = alloy().values()
    changed = state.martensite_fraction + wire.r_phase_entropy_ratio * state.r_phase_fraction
    return MASS_KG * (
        values["specific_heat_j_per_kg_k"] * (state.temperature_k - 293.15) - values["latent_heat_j_per_kg"] * changed
    )


@pytest.mark.parametrize("kind", sorted(ALLOYS))
def test_over_ten_slow_cycles_the_heat_account_is_closed_to_rounding(kind: str) -> None:
    """900 000 steps: each adds a rounding of 1e-16 of the heat that has gone through, at worst all one way."""
    wire = constants(kind)
    start = resting_state(wire)
    _, end = driven(wire, np.tile(CYCLE_V, 10), DT_S, 100)
    assert end.heat_in_j > 50.0 * wire.latent_heat_j, "little heat went through: this would show little"
    supplied_j = end.heat_in_j - end.heat_out_j - end.carried_heat_j
    assert supplied_j == pytest.approx(end.enthalpy_j - start.enthalpy_j, abs=1e-10 * end.heat_in_j)
    assert end.enthalpy_j == pytest.approx(held_j(end, wire), abs=1e-12 * wire.latent_heat_j)


def latent_j(path: DrivenPath, wire: WireConstants) -> Array:
    return -wire.latent_heat_j * (path.martensite_fraction + wire.r_phase_entropy_ratio * path.r_phase_fraction)


@pytest.mark.parametrize("kind", sorted(ALLOYS))
def test_over_a_settled_cycle_enthalpy_returns_and_heating_takes_up_what_cooling_gives_back(kind: str) -> None:
    wire = constants(kind)
    _, settled = driven(wire, np.tile(CYCLE_V, 2), DT_S, 100)
    path, end = driven(wire, CYCLE_V, DT_S, 100, state=settled)
    moved = end.heat_in_j - settled.heat_in_j
    # A cycle forgets the one before but for its last heat, which decays within a second.
    assert end.enthalpy_j == pytest.approx(settled.enthalpy_j, abs=1e-7 * moved)
    assert end.heat_out_j - settled.heat_out_j == pytest.approx(moved, rel=1e-7)
    hottest = int(path.temperature_k.argmax())
    start_latent = -wire.latent_heat_j * (
        settled.martensite_fraction + wire.r_phase_entropy_ratio * settled.r_phase_fraction
    )
    latent = latent_j(path, wire)
    absorbed, released = latent[hottest] - start_latent, latent[hottest] - latent[-1]
    assert absorbed > 0.7 * wire.latent_heat_j, "most of the wire must have transformed"
    assert released == pytest.approx(absorbed, rel=1e-6)


@pytest.mark.parametrize("friction_n", [0.0, 0.03])
@pytest.mark.parametrize("kind", sorted(ALLOYS))
def test_electrical_energy_less_convection_is_the_heat_that_temperature_and_phases_show(
    kind: str, friction_n: float
) -> None:
    """Counted from outside: V I from the two voltages, convection from the correlation, mass from the dimensions.

    A sample is a step here, so that its voltages are the step's: means of both ends, as the loss is. The wire's own
    convection is a table every 2 K; what it misses between two points, and the product of two means, are the only
    differences.
    """
    wire = constants(kind, bench_values={"guide_friction_n": friction_n})
    start = resting_state(wire)
    path, end = driven(wire, SWINGS_V, DT_S, 1)
    joule_j = np.cumsum(path.wire_voltage_v * path.shunt_voltage_v / bench().values()["shunt_resistance_ohm"]) * DT_S
    air_k = bench().values()["ambient_temperature_k"]
    ends_k = np.concatenate(([start.temperature_k], path.temperature_k))
    h = wire_100um().values()["convection_factor"] * np.array(
        [convection_coefficient_w_per_m2_k(t, air_k, 100e-6) for t in ends_k]
    )
    loss_w = h * SURFACE_M2 * (ends_k - air_k)
    lost_j = np.cumsum(0.5 * (loss_w[1:] + loss_w[:-1])) * DT_S
    values = alloy(kind).values()
    latent = -values["latent_heat_j_per_kg"] * (
        path.martensite_fraction + values["r_phase_entropy_ratio"] * path.r_phase_fraction
    )
    held = MASS_KG * (values["specific_heat_j_per_kg_k"] * (path.temperature_k - 293.15) + latent)
    missing_j = joule_j - lost_j - (held - held_j(start, wire))
    assert np.abs(missing_j).max() < 3e-5 * joule_j[-1]
    assert np.abs(missing_j).max() < 0.01 * np.ptp(latent) * MASS_KG, "a lost hundredth of the latent heat would show"
    assert end.heat_in_j == pytest.approx(joule_j[-1], rel=1e-7)


def test_a_recording_of_20_hz_shows_the_same_energy() -> None:
    """Means of voltages over 50 ms, temperature at the end of each: what a rig and a thermometer would give.

    The product of two means is not the mean of the product, and the loss is taken at the ends of the samples; with a
    time constant of half a second both are worth less than a percent.
    """
    wire = constants()
    start = resting_state(wire)
    path, end = driven(wire, SWINGS_V[::50], DT_S, 50)
    joule_j = float(np.sum(path.wire_voltage_v * path.shunt_voltage_v)) * 0.05 / wire.shunt_resistance_ohm
    ends_k = np.concatenate(([start.temperature_k], path.temperature_k))
    air_k = wire.ambient_temperature_k
    loss_w = [
        0.9 * convection_coefficient_w_per_m2_k(t, air_k, 100e-6) * SURFACE_M2 * (t - air_k) for t in ends_k.tolist()
    ]
    lost_j = float(np.trapezoid(loss_w, dx=0.05))
    assert joule_j - lost_j == pytest.approx(held_j(end, wire) - held_j(start, wire), abs=0.01 * joule_j)
