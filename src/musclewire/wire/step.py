"""One step of one wire, compiled: heat in enthalpy form, grains, equilibrium with the load.

Works in place on the records of a :class:`RunningWire`. Its order and its two linear predictions are explained in
docs/explanation/numerics.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inline
from musclewire.physics.material import (
    friction_force_n,
    maximum_transformation_strain,
    maximum_transformation_strain_slope_per_pa,
    reuss_modulus_pa,
)
from musclewire.physics.resistance import REFERENCE_TEMPERATURE_K, phase_resistivity_ohm_m, wire_resistance_ohm
from musclewire.wire.state import RunningWire, Shakedown, WireConstants, WireState
from musclewire.wire.switching import follow

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
    "find_equilibrium",
    "heat",
    "resistance_ahead_ohm",
    "running",
    "settle_at",
    "shakedown_of",
    "step",
]

# Deviation of the load from its linearisation above which Newton's method continues; less is of second order.
SMALL_BEND_N = 1e-5
MAX_NEWTON_STEPS = 30
# A predicted heat capacity above this multiple of the sensible one means a plateau; more would only slow recovery.
MAX_CAPACITY_RATIO = 30.0
# Limit of the predicted slope of stress over temperature, as a fraction of the Clausius-Clapeyron slope. At rest the
# slope consists of rounding errors; if it were steeper than the phase boundary, a cooling wire would be predicted to
# lose stress faster than martensite requires, and would transform to austenite by cooling. A soft load corrects this in
# the next step, a stiff one cannot.
SAFE_SLOPE_FRACTION = 0.8
# Maximum number of parts of a step's heat, and the fraction of it that may be left to the next step.
MAX_PARTS = 6
SMALL_PART = 1e-2
# Rises below this are rounding.
NO_RISE_K = 1e-9


@compiled
def strain_at(
    constants: WireConstants, stress_pa: float, martensite: float, r_phase: float, temperature_k: float
) -> tuple[float, float, float]:
    """Return transformation strain, elastic strain and thermal strain of the wire.

    Parameters
    ----------
    constants
        The wire's constants, one record.
    stress_pa
        Stress of a leg [Pa].
    martensite
        Volume fraction of martensite, 0 to 1.
    r_phase
        Volume fraction of R-phase, 0 to 1 - ``martensite``.
    temperature_k
        Temperature of the wire [K].

    Returns
    -------
    The three strains, each positive for a longer wire. Transformation strain is 0 in austenite, elastic strain is 0
    without stress, thermal strain is 0 at 20 C.

    References
    ----------
    Transformation strain after Lagoudas et al. 2012, doi 10.1016/j.ijplas.2011.10.009; modulus after Reuss.
    """
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
    """Return the total strain of the wire relative to stress-free austenite at 20 C.

    Parameters
    ----------
    constants
        The wire's constants, one record.
    stress_pa
        Stress of a leg [Pa].
    martensite
        Volume fraction of martensite, 0 to 1.
    r_phase
        Volume fraction of R-phase, 0 to 1 - ``martensite``.
    temperature_k
        Temperature of the wire [K].

    Returns
    -------
    The sum of transformation, elastic and thermal strain, without the residual strain of shakedown.
    """
    transformation, elastic, thermal = strain_at(constants, stress_pa, martensite, r_phase, temperature_k)
    return transformation + elastic + thermal


@compiled
def contraction_of(constants: WireConstants, strain: float) -> float:
    """Return the contraction of the wire relative to its cold length under pretension.

    Strain is relative to stress-free austenite, contraction to the longer, cold wire that a ruler measures.

    Parameters
    ----------
    constants
        The wire's constants, one record; its ``cold_strain`` is the strain of the cold wire under pretension.
    strain
        Total strain relative to stress-free austenite at 20 C, residual strain included.

    Returns
    -------
    The contraction, positive if the wire is shorter than cold; for a finger's wire, 0.04 is 4 % of stroke.
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
    """Return the contraction of a wire at a stress, with unchanged phases."""
    strain = total_strain(constants, stress_pa, martensite, r_phase, temperature_k) + residual_strain
    return contraction_of(constants, strain)


@compiled
def compliance_per_pa(constants: WireConstants, stress_pa: float, martensite: float) -> float:
    """Return the derivative of strain by stress [1/Pa], with unchanged phases."""
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
    """Return force [N] and stiffness [N/m] that a load's table adds to pretension and spring.

    Below 0 the force is that of the first point, without stiffness; beyond the last point it keeps its slope.
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
    """Return the Coulomb friction [N] at a displacement: the guide's plus the load's."""
    table = load_table_n[1]
    place = min(max(displacement_m / constants.load_step_m, 0.0), table.shape[0] - 1.0)
    low = min(int(place), table.shape[0] - 2)
    limit_n: float = constants.friction_n + table[low] + (table[low + 1] - table[low]) * (place - low)
    return limit_n


@compiled
def equilibrium_stress_pa(wire: RunningWire, push_n: float, push_n_per_m: float) -> float:
    """Return the leg stress [Pa] at which wire and load are in equilibrium: one Newton step, several at a kink.

    The balance is F_T = F_p + k S l_leg + force of the load's table + friction + push, with sigma = F_T / (legs A); a
    slack wire carries nothing.

    Parameters
    ----------
    wire
        The wire with its load; its phases and temperature are those after the step's heat.
    push_n
        Another force on the connector at the wire's displacement [N]: that of a second wire; 0 without one.
    push_n_per_m
        Stiffness of that force [N/m].

    Returns
    -------
    Stress of a leg [Pa], 0 or more.

    Notes
    -----
    The equation is almost linear in stress, so that one step leaves an error of second order. If the slope of the table
    changes within that step, more steps follow, bracketed by stresses known to be too low and too high: at a wall a
    single step would overshoot far out of it, and the next one far into it.

    References
    ----------
    Lan and Fan 2010, Eq. 8, F_T = F_p + F.
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
        if load_table_n.shape[1] == 2:  # a plain spring is linear
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
    """Return the wire's resistance [ohm]: phases mixed by volume, then the change of shape.

    Parameters
    ----------
    constants
        The wire's constants, one record.
    stress_pa
        Stress of a leg [Pa], for transformation strain and elastic strain.
    martensite
        Volume fraction of martensite, 0 to 1.
    r_phase
        Volume fraction of R-phase, 0 to 1 - ``martensite``.
    temperature_k
        Temperature of the wire [K].
    shakedown_remaining
        Fraction of the shakedown that remains: 1 for a new wire, 0 in the end. It raises the resistivity of
        martensite by ``shakedown_resistivity``.

    Returns
    -------
    Resistance of the whole wire [ohm], without leads and shunt.
    """
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


class EnthalpyStep(NamedTuple):
    """Result of a step's heat: temperature, phases, apparent heat capacity, and the rise that the grains followed.

    Parameters
    ----------
    temperature_k
        Temperature after the step [K].
    martensite
        Volume fraction of martensite after the step.
    r_phase
        Volume fraction of R-phase after the step.
    capacity_j_per_k
        Heat over rise in the last part of the step, latent heat included [J/K]; at least the sensible heat capacity.
    rise_k
        Rise of temperature that the grains followed [K].
    """

    temperature_k: float
    martensite: float
    r_phase: float
    capacity_j_per_k: float
    rise_k: float


@compiled
def shakedown_of(constants: WireConstants, cycles: float) -> Shakedown:
    """Return the state of a wire's shakedown after a number of cycles.

    Parameters
    ----------
    constants
        The wire's constants, one record.
    cycles
        Full transformation cycles since the wire was new, 0 or more; half a cycle counts as half.

    Returns
    -------
    The fraction that remains, exp(-cycles / shakedown_cycles), and its effects. It has none in a wire whose shakedown
    was over at the start: its constants are 0.

    References
    ----------
    The form is assumed; the signs are those of Churchill and Shaw, SMASIS2009-48968, and Hartwich et al. 2021,
    doi 10.3390/s21206804.
    """
    remaining = math.exp(-cycles / constants.shakedown_cycles)
    return Shakedown(
        remaining, constants.shakedown_strain * (1.0 - remaining), 1.0 + constants.shakedown_barrier * remaining
    )


@compiled_inline
def running(state: WireState, constants: WireConstants, load_table_n: FloatArray) -> RunningWire:
    """Return a wire as a step takes it, with the shakedown that remains after its cycles."""
    return RunningWire(state, constants, load_table_n, shakedown_of(constants, state.cycles))


@compiled_inline
def enthalpy_step(wire: RunningWire, heat_j: float) -> EnthalpyStep:
    """Return temperature and phases after a step's heat, solved together; the grains change in place.

    A rise is predicted with the last heat capacity, the grains follow it, and enthalpy gives the remaining rise. Stress
    is predicted by its slope in the step before. Energy is conserved to rounding.

    Parameters
    ----------
    wire
        The wire before the step. Its grains change in place; its other numbers do not.
    heat_j
        Heat into the wire during the step [J]: electrical heat less the loss to the air.

    Returns
    -------
    Temperature and phases after the step, the apparent heat capacity, and the rise that the grains followed.
    """
    state, constants = wire.state, wire.constants
    sensible_j_per_k = constants.heat_capacity_j_per_k
    ratio = constants.r_phase_entropy_ratio
    enthalpy_j = state.enthalpy_j + heat_j
    martensite, r_phase, capacity = state.martensite_fraction, state.r_phase_fraction, state.capacity_j_per_k
    rise_k = 0.0
    temperature_k = state.temperature_k
    left_k = heat_j / sensible_j_per_k
    for _ in range(MAX_PARTS):
        # Latent heat raises the heat capacity by a factor that is known only once the grains have changed. Parts that
        # approach the rise from below never transform more than the heat allows.
        part_k = left_k * sensible_j_per_k / capacity
        rise_k += part_k
        change_m, change_r, grains = follow(
            state,
            constants,
            state.temperature_k + rise_k,
            state.stress_pa + state.stress_slope_pa_per_k * rise_k,
            wire.shakedown.barrier_factor,
        )
        martensite += change_m / grains
        r_phase += change_r / grains
        temperature_k = (
            REFERENCE_TEMPERATURE_K
            + (enthalpy_j + constants.latent_heat_j * (martensite + ratio * r_phase)) / sensible_j_per_k
        )
        if part_k != 0.0:
            capacity = sensible_j_per_k - constants.latent_heat_j * (change_m + ratio * change_r) / (grains * part_k)
            capacity = min(max(capacity, sensible_j_per_k), MAX_CAPACITY_RATIO * sensible_j_per_k)
        left_before_k, left_k = left_k, state.temperature_k + rise_k
        left_k = temperature_k - left_k
        if left_k * left_before_k <= 0.0 or abs(left_k) < SMALL_PART * abs(heat_j / sensible_j_per_k) + NO_RISE_K:
            break
    return EnthalpyStep(temperature_k, martensite, r_phase, capacity, rise_k)


@compiled_inline
def heat(wire: RunningWire, power_w: float, dt_s: float) -> float:
    """Apply one step's heat to a wire and let its grains follow; return the rise that they followed [K]."""
    state, constants = wire.state, wire.constants
    middle_k = state.temperature_k + 0.5 * dt_s * state.temperature_rate_k_per_s
    excess_k = middle_k - constants.ambient_temperature_k
    loss_w = convection_w_per_m2_k(constants, middle_k) * constants.surface_m2 * excess_k
    heat_j = (power_w - loss_w) * dt_s
    after = enthalpy_step(wire, heat_j)
    state.enthalpy_j += heat_j
    state.heat_in_j += power_w * dt_s
    state.heat_out_j += loss_w * dt_s
    state.cycles += 0.5 * abs(after.martensite - state.martensite_fraction)
    state.temperature_rate_k_per_s = (after.temperature_k - state.temperature_k) / dt_s
    state.temperature_k = after.temperature_k
    state.martensite_fraction = after.martensite
    state.r_phase_fraction = after.r_phase
    state.capacity_j_per_k = after.capacity_j_per_k
    return after.rise_k


@compiled_inline
def settle_at(wire: RunningWire, rise_k: float, dt_s: float, stress_pa: float) -> None:
    """Set the stress of a wire, with the contraction, friction and resistance that follow from it.

    The slope of stress over temperature is kept, within its limit, for the next step's prediction.
    """
    state, constants = wire.state, wire.constants
    martensite, r_phase, temperature_k = state.martensite_fraction, state.r_phase_fraction, state.temperature_k
    contraction = contraction_at_stress(
        constants, stress_pa, martensite, r_phase, temperature_k, wire.shakedown.residual_strain
    )
    moved_m = (contraction - state.contraction) * constants.leg_length_m
    limit_n = friction_limit_n(constants, wire.load_table_n, contraction * constants.leg_length_m)
    resistance_ohm = resistance_of(constants, stress_pa, martensite, r_phase, temperature_k, wire.shakedown.remaining)
    if abs(rise_k) > NO_RISE_K:
        slope = (stress_pa - state.stress_pa) / rise_k
        steepest = SAFE_SLOPE_FRACTION * constants.martensite_stress_rate_pa_per_k
        state.stress_slope_pa_per_k = min(max(slope, -steepest), steepest)
    state.friction_n = friction_force_n(state.friction_n, moved_m, limit_n, constants.friction_presliding_m)
    state.stress_pa = stress_pa
    state.contraction = contraction
    state.resistance_rate_ohm_per_s = (resistance_ohm - state.resistance_ohm) / dt_s
    state.resistance_ohm = resistance_ohm


@compiled_inline
def find_equilibrium(wire: RunningWire, rise_k: float, dt_s: float, push_n: float, push_n_per_m: float) -> None:
    """Bring a wire into equilibrium with its load and another force on its connector, and update its resistance."""
    settle_at(wire, rise_k, dt_s, equilibrium_stress_pa(wire, push_n, push_n_per_m))


@compiled_inline
def resistance_ahead_ohm(state: WireState, dt_s: float) -> float:
    """Return the resistance half a step ahead: its predicted mean over the step."""
    return state.resistance_ohm + 0.5 * dt_s * state.resistance_rate_ohm_per_s


@compiled_inline
def step(wire: RunningWire, power_w: float, dt_s: float) -> None:
    """Advance a wire on its load by one step at an electrical power."""
    rise_k = heat(wire, power_w, dt_s)
    find_equilibrium(wire, rise_k, dt_s, 0.0, 0.0)
