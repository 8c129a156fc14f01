"""Electrical, thermal and mechanical balance of a wire at one instant: compiled."""

from __future__ import annotations

import math

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.physics.mechanics import (
    maximum_transformation_strain,
    maximum_transformation_strain_slope_per_pa,
    reuss_modulus_pa,
)
from musclewire.physics.resistivity import REFERENCE_TEMPERATURE_K, phase_resistivity_ohm_m, wire_resistance_ohm
from musclewire.wire.state import RunningWire, WireConstants

__all__ = [
    "compliance_per_pa",
    "contraction_at_stress",
    "contraction_of",
    "convection_w_per_m2_k",
    "friction_limit_n",
    "load_beyond_spring",
    "resistance_of",
    "strain_at",
    "equilibrium_stress_pa",
    "total_strain",
]

# How far a load may be from the straight line along which a Newton step went; less is an error of second order.
SMALL_BEND_N = 1e-5
MAX_NEWTON_STEPS = 30


@compiled
def strain_at(
    constants: WireConstants, stress_pa: float, martensite: float, r_phase: float, temperature_k: float
) -> tuple[float, float, float]:
    """Return transformation strain, elastic strain and thermal strain of the wire."""
    orientable = maximum_transformation_strain(
        stress_pa, constants.strain_at_no_stress, constants.strain_saturated, constants.strain_stress_scale_pa
    )
    transformation = orientable * martensite + constants.r_phase_strain * r_phase
    elastic = stress_pa / reuss_modulus_pa(martensite, constants.austenite_modulus_pa, constants.martensite_modulus_pa)
    expansion = constants.martensite_expansion_per_k * martensite + constants.austenite_expansion_per_k * (
        1.0 - martensite
    )
    return transformation, elastic, expansion * (temperature_k - REFERENCE_TEMPERATURE_K)


@compiled
def total_strain(
    constants: WireConstants, stress_pa: float, martensite: float, r_phase: float, temperature_k: float
) -> float:
    """Return the whole strain of the wire against stress-free austenite at 20 C."""
    transformation, elastic, thermal = strain_at(constants, stress_pa, martensite, r_phase, temperature_k)
    return transformation + elastic + thermal


@compiled
def contraction_of(constants: WireConstants, strain: float) -> float:
    """Return how much shorter the wire is than cold under pretension, as a fraction of that length.

    Strain counts from stress-free austenite, contraction from the longer wire that one lays a ruler on.
    """
    return (constants.cold_strain - strain) / (1.0 + constants.cold_strain)


@compiled
def contraction_at_stress(
    constants: WireConstants,
    stress_pa: float,
    martensite: float,
    r_phase: float,
    temperature_k: float,
    residual_strain: float,
) -> float:
    """Return the contraction of a wire at a stress while its phases stay."""
    strain = total_strain(constants, stress_pa, martensite, r_phase, temperature_k) + residual_strain
    return contraction_of(constants, strain)


@compiled
def compliance_per_pa(constants: WireConstants, stress_pa: float, martensite: float) -> float:
    """Return how much strain grows with stress [1/Pa] while the phases stay."""
    return 1.0 / reuss_modulus_pa(
        martensite, constants.austenite_modulus_pa, constants.martensite_modulus_pa
    ) + martensite * maximum_transformation_strain_slope_per_pa(
        stress_pa,
        constants.strain_at_no_stress,
        constants.strain_saturated,
        constants.strain_stress_scale_pa,
    )


@compiled
def load_beyond_spring(load_table_n: FloatArray, step_m: float, displacement_m: float) -> tuple[float, float]:
    """Return force [N] and stiffness [N/m] of the load beyond pretension and spring, from its table.

    Below 0 the load has let go and keeps the force it begins with; beyond the table it goes on as it ended.
    """
    table = load_table_n[0]
    if displacement_m <= 0.0:
        return table[0], 0.0
    place = displacement_m / step_m
    low = min(int(place), table.shape[0] - 2)
    rise = table[low + 1] - table[low]
    return table[low] + rise * (place - low), rise / step_m


@compiled
def friction_limit_n(constants: WireConstants, load_table_n: FloatArray, displacement_m: float) -> float:
    """Return the largest friction [N] at a displacement: the guide's, and what the load has of its own."""
    table = load_table_n[1]
    place = min(max(displacement_m / constants.load_step_m, 0.0), table.shape[0] - 1.0)
    low = min(int(place), table.shape[0] - 2)
    limit_n: float = constants.friction_n + table[low] + (table[low + 1] - table[low]) * (place - low)
    return limit_n


@compiled
def equilibrium_stress_pa(wire: RunningWire, push_n: float, push_n_per_m: float) -> float:
    """Return the leg stress [Pa] at which wire and load agree: one Newton step from the wire's, on a kink a few.

    F_T = F_p + k S l_leg + what the load's table adds + friction, sigma = F_T / (legs A); a slack wire carries
    nothing. ``push_n`` is a further force on the connector at the wire's displacement, and how it grows with it.
    The function is almost linear in stress, so that one step leaves an error of second order. Where the table bends
    within that step, the steps go on, kept between stresses known to be too low and too high: from a wall a single
    step would go far out of it, and the next one far into it.
    """
    state, constants, load_table_n = wire.state, wire.constants, wire.load_table_n
    martensite, r_phase, temperature_k = state.martensite_fraction, state.r_phase_fraction, state.temperature_k
    residual_strain = wire.shakedown.residual_strain
    stress_pa = state.stress_pa
    spring = constants.spring_stiffness_n_per_m * constants.leg_length_m
    section = constants.legs * constants.area_m2
    per_stretch = 1.0 / (1.0 + constants.cold_strain)
    start = contraction_at_stress(constants, stress_pa, martensite, r_phase, temperature_k, residual_strain)
    contraction = start
    low_pa, high_pa = 0.0, math.inf
    for _ in range(MAX_NEWTON_STEPS):
        moved_m = (contraction - start) * constants.leg_length_m
        place_m = contraction * constants.leg_length_m
        beyond_n, beyond_n_per_m = load_beyond_spring(load_table_n, constants.load_step_m, place_m)
        stiffness = spring + (beyond_n_per_m + push_n_per_m) * constants.leg_length_m
        pushed_n = push_n + push_n_per_m * moved_m
        wanted = (constants.pretension_n + spring * contraction + beyond_n + pushed_n + state.friction_n) / section
        excess_pa = stress_pa - wanted
        low_pa, high_pa = (low_pa, stress_pa) if excess_pa > 0.0 else (stress_pa, high_pa)
        compliance = compliance_per_pa(constants, stress_pa, martensite)
        stress_pa = max(stress_pa - excess_pa / (1.0 + stiffness * per_stretch * compliance / section), 0.0)
        if stress_pa > high_pa or stress_pa < low_pa:
            stress_pa = 0.5 * (low_pa + high_pa)
        if load_table_n.shape[1] == 2:  # a plain spring bends nowhere
            break
        contraction = contraction_at_stress(constants, stress_pa, martensite, r_phase, temperature_k, residual_strain)
        after_m = contraction * constants.leg_length_m
        straight_n = beyond_n + beyond_n_per_m * (after_m - place_m)
        if abs(load_beyond_spring(load_table_n, constants.load_step_m, after_m)[0] - straight_n) < SMALL_BEND_N:
            break
    return stress_pa


@compiled
def resistance_of(
    constants: WireConstants,
    stress_pa: float,
    martensite: float,
    r_phase: float,
    temperature_k: float,
    shakedown_remaining: float,
) -> float:
    """Return the wire's resistance [ohm]: phases mixed by volume, then the change of shape."""
    transformation, elastic, thermal = strain_at(constants, stress_pa, martensite, r_phase, temperature_k)
    martensite_resistivity = constants.martensite_resistivity_ohm_m * (
        1.0 + constants.shakedown_resistivity * shakedown_remaining
    )
    resistivity = (
        martensite
        * phase_resistivity_ohm_m(martensite_resistivity, constants.martensite_resistivity_per_k, temperature_k)
        + r_phase
        * phase_resistivity_ohm_m(
            constants.r_phase_resistivity_ohm_m, constants.r_phase_resistivity_per_k, temperature_k
        )
        + (1.0 - martensite - r_phase)
        * phase_resistivity_ohm_m(
            constants.austenite_resistivity_ohm_m, constants.austenite_resistivity_per_k, temperature_k
        )
    )
    return wire_resistance_ohm(
        resistivity, constants.austenite_length_m, constants.area_m2, transformation, elastic, thermal
    )


@compiled
def convection_w_per_m2_k(constants: WireConstants, temperature_k: float) -> float:
    """Return the heat transfer coefficient at this wall temperature, from the wire's table."""
    table = constants.convection_table_w_per_m2_k
    place = (temperature_k - constants.convection_table_start_k) / constants.convection_table_step_k
    place = min(max(place, 0.0), table.shape[0] - 1.001)
    low = int(place)
    part = place - low
    coefficient: float = constants.convection_factor * (table[low] * (1.0 - part) + table[low + 1] * part)
    return coefficient
