"""One step of one wire of grains: heat in enthalpy form, grains, balance with the load. First order.

A step's heat goes to the grains in parts, each by the capacity that the part before showed; stress follows its slope
in the step before; friction is that with which the step began.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from grain_wire.compiling import compiled
from grain_wire.switching import Array, Grains, follow

TWENTY_DEGC_K = 293.15
POISSON_RATIO = 0.33
SMALL_BEND_N = 1e-5
MAX_NEWTON_STEPS = 30
MAX_CAPACITY_RATIO = 30.0
SAFE_SLOPE_FRACTION = 0.8
MAX_PARTS = 6
SMALL_PART = 1e-2
NO_RISE_K = 1e-9


class Shakedown(NamedTuple):
    """What remains of a new wire's shakedown: 1 at first, 0 in the end; the strain gained; the barrier's factor."""

    remaining: float
    residual_strain: float
    barrier_factor: float


class Running(NamedTuple):
    """A wire in compiled code: two records, of which a step changes the state; grains; tables; shakedown.

    ``load_n`` is (2, n): force and friction of the load [N] at displacements of 0, 1, 2... times ``load_step_m``.
    """

    state: Any
    constants: Any
    grains: Grains
    convection_w_per_m2_k: Array
    load_n: Array
    shakedown: Shakedown


@compiled
def shakedown_of(constants: Any, cycles: float) -> Shakedown:
    """Return the state of a wire's shakedown after so many transformation cycles."""
    remaining = math.exp(-cycles / constants.shakedown_cycles)
    return Shakedown(
        remaining, constants.shakedown_strain * (1.0 - remaining), 1.0 + constants.shakedown_barrier * remaining
    )


@compiled
def strains(c: Any, stress_pa: float, martensite: float, r_phase: float, temperature_k: float) -> tuple:
    """Return transformation, elastic and thermal strain."""
    orientable = c.strain_saturated - (c.strain_saturated - c.strain_at_no_stress) * math.exp(
        -stress_pa / c.strain_stress_scale_pa
    )
    transformation = orientable * martensite + c.r_phase_strain * r_phase
    elastic = stress_pa / modulus_pa(c, martensite)
    expansion = c.martensite_expansion_per_k * martensite + c.austenite_expansion_per_k * (1.0 - martensite)
    return transformation, elastic, expansion * (temperature_k - TWENTY_DEGC_K)


@compiled
def modulus_pa(c: Any, martensite: float) -> float:
    """Return the modulus of phases in series (Reuss)."""
    return 1.0 / ((1.0 - martensite) / c.austenite_modulus_pa + martensite / c.martensite_modulus_pa)


@compiled
def total_strain(c: Any, stress_pa: float, martensite: float, r_phase: float, temperature_k: float) -> float:
    """Return the sum of the strains."""
    transformation, elastic, thermal = strains(c, stress_pa, martensite, r_phase, temperature_k)
    return transformation + elastic + thermal


@compiled
def contraction_at(wire: Running, stress_pa: float) -> float:
    """Return the contraction relative to the cold wire, at a stress, with the present phases."""
    state, c = wire.state, wire.constants
    strain = total_strain(c, stress_pa, state.martensite_fraction, state.r_phase_fraction, state.temperature_k)
    strain += wire.shakedown.residual_strain
    return (c.cold_strain - strain) / (1.0 + c.cold_strain)


@compiled
def compliance_per_pa(wire: Running, stress_pa: float) -> float:
    """Return the derivative of strain by stress, with the present phases."""
    c, martensite = wire.constants, wire.state.martensite_fraction
    orienting = (
        (c.strain_saturated - c.strain_at_no_stress)
        / c.strain_stress_scale_pa
        * math.exp(-stress_pa / c.strain_stress_scale_pa)
    )
    return 1.0 / modulus_pa(c, martensite) + martensite * orienting


@compiled
def resistance_ohm(
    c: Any, stress_pa: float, martensite: float, r_phase: float, temperature_k: float, remaining: float
) -> float:
    """Return the resistance: phases mixed by volume, then the change of shape."""
    transformation, elastic, thermal = strains(c, stress_pa, martensite, r_phase, temperature_k)
    warm = temperature_k - TWENTY_DEGC_K
    resistivity = (
        martensite
        * (
            c.martensite_resistivity_ohm_m
            * (1.0 + c.shakedown_resistivity * remaining)
            * (1.0 + c.martensite_resistivity_per_k * warm)
        )
        + r_phase * (c.r_phase_resistivity_ohm_m * (1.0 + c.r_phase_resistivity_per_k * warm))
        + (1.0 - martensite - r_phase) * (c.austenite_resistivity_ohm_m * (1.0 + c.austenite_resistivity_per_k * warm))
    )
    stretch, thinning = 1.0 + transformation, 1.0 - POISSON_RATIO * elastic
    shape = resistivity * c.austenite_length_m / c.area_m2 * stretch * stretch * (1.0 + elastic)
    return shape / (thinning * thinning * (1.0 + thermal))


@compiled
def load_beyond_spring(load_n: Array, step_m: float, displacement_m: float) -> tuple[float, float]:
    """Return force [N] and stiffness [N/m] of a load's table; beyond its end it keeps its slope."""
    table = load_n[0]
    if displacement_m <= 0.0:
        return table[0], 0.0
    place = displacement_m / step_m
    low = min(int(place), table.shape[0] - 2)
    rise = table[low + 1] - table[low]
    return table[low] + rise * (place - low), rise / step_m


@compiled
def friction_limit_n(wire: Running, displacement_m: float) -> float:
    """Return the Coulomb friction at a displacement: the guide's plus the load's."""
    table = wire.load_n[1]
    place = min(max(displacement_m / wire.constants.load_step_m, 0.0), table.shape[0] - 1.0)
    low = min(int(place), table.shape[0] - 2)
    return wire.constants.friction_n + table[low] + (table[low + 1] - table[low]) * (place - low)


@compiled
def equilibrium_stress_pa(wire: Running, push_n: float, push_n_per_m: float) -> float:
    """Return the stress at which wire and load agree: one Newton step, several where the load has a kink."""
    state, c = wire.state, wire.constants
    stress_pa = state.stress_pa
    spring = c.spring_stiffness_n_per_m * c.leg_length_m
    section = c.legs * c.area_m2
    per_stretch = 1.0 / (1.0 + c.cold_strain)
    start = contraction_at(wire, stress_pa)
    contraction = start
    low_pa, high_pa = 0.0, math.inf
    for _ in range(MAX_NEWTON_STEPS):
        moved_m = (contraction - start) * c.leg_length_m
        place_m = contraction * c.leg_length_m
        beyond_n, beyond_n_per_m = load_beyond_spring(wire.load_n, c.load_step_m, place_m)
        stiffness = spring + (beyond_n_per_m + push_n_per_m) * c.leg_length_m
        pushed_n = push_n + push_n_per_m * moved_m
        wanted = (c.pretension_n + spring * contraction + beyond_n + pushed_n + state.friction_n) / section
        excess_pa = stress_pa - wanted
        low_pa, high_pa = (low_pa, stress_pa) if excess_pa > 0.0 else (stress_pa, high_pa)
        compliance = compliance_per_pa(wire, stress_pa)
        stress_pa = max(stress_pa - excess_pa / (1.0 + stiffness * per_stretch * compliance / section), 0.0)
        if stress_pa > high_pa or stress_pa < low_pa:
            stress_pa = 0.5 * (low_pa + high_pa)
        if wire.load_n.shape[1] == 2:  # a plain spring is linear
            break
        contraction = contraction_at(wire, stress_pa)
        after_m = contraction * c.leg_length_m
        straight_n = beyond_n + beyond_n_per_m * (after_m - place_m)
        if abs(load_beyond_spring(wire.load_n, c.load_step_m, after_m)[0] - straight_n) < SMALL_BEND_N:
            break
    return stress_pa


@compiled
def convection_w_per_m2_k(wire: Running, temperature_k: float) -> float:
    """Return the heat transfer coefficient at a wall temperature, from the table."""
    c, table = wire.constants, wire.convection_w_per_m2_k
    place = (temperature_k - c.convection_table_start_k) / c.convection_table_step_k
    place = min(max(place, 0.0), table.shape[0] - 1.001)
    low = int(place)
    part = place - low
    return c.convection_factor * (table[low] * (1.0 - part) + table[low + 1] * part)


class Heated(NamedTuple):
    """After a step's heat: temperature, phases, apparent capacity, and the rise that the grains followed."""

    temperature_k: float
    martensite: float
    r_phase: float
    capacity_j_per_k: float
    rise_k: float


@compiled
def take_up(wire: Running, heat_j: float) -> Heated:
    """Return temperature and phases after a step's heat; the grains change in place, in parts of the rise."""
    state, c = wire.state, wire.constants
    sensible, ratio = c.heat_capacity_j_per_k, c.r_phase_entropy_ratio
    grains = wire.grains.middle.shape[0]
    enthalpy_j = state.enthalpy_j + heat_j
    martensite, r_phase, capacity = state.martensite_fraction, state.r_phase_fraction, state.capacity_j_per_k
    rise_k, temperature_k, left_k = 0.0, state.temperature_k, heat_j / sensible
    for _ in range(MAX_PARTS):
        part_k = left_k * sensible / capacity
        rise_k += part_k
        change_m, change_r = follow(
            wire.grains,
            c,
            state.temperature_k + rise_k,
            state.stress_pa + state.stress_slope_pa_per_k * rise_k,
            wire.shakedown.barrier_factor,
        )
        martensite += change_m / grains
        r_phase += change_r / grains
        temperature_k = TWENTY_DEGC_K + (enthalpy_j + c.latent_heat_j * (martensite + ratio * r_phase)) / sensible
        if part_k != 0.0:
            capacity = sensible - c.latent_heat_j * (change_m + ratio * change_r) / (grains * part_k)
            capacity = min(max(capacity, sensible), MAX_CAPACITY_RATIO * sensible)
        left_before_k, left_k = left_k, state.temperature_k + rise_k
        left_k = temperature_k - left_k
        if left_k * left_before_k <= 0.0 or abs(left_k) < SMALL_PART * abs(heat_j / sensible) + NO_RISE_K:
            break
    return Heated(temperature_k, martensite, r_phase, capacity, rise_k)


@compiled
def heat_wire(wire: Running, power_w: float, dt_s: float) -> float:
    """Apply one step's heat to a wire and let its grains follow; return the rise that they followed [K]."""
    state, c = wire.state, wire.constants
    middle_k = state.temperature_k + 0.5 * dt_s * state.temperature_rate_k_per_s
    excess_k = middle_k - c.ambient_temperature_k
    loss_w = convection_w_per_m2_k(wire, middle_k) * c.surface_m2 * excess_k
    # Without work_share this is 0; with it, the work on the load is that of the step before.
    heat_j = (power_w - loss_w) * dt_s - c.work_share * state.work_j
    after = take_up(wire, heat_j)
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


@compiled
def settle_at(wire: Running, rise_k: float, dt_s: float, stress_pa: float) -> None:
    """Set the stress of a wire, and contraction, friction and resistance that follow from it."""
    state, c = wire.state, wire.constants
    contraction = contraction_at(wire, stress_pa)
    moved_m = (contraction - state.contraction) * c.leg_length_m
    limit_n = friction_limit_n(wire, contraction * c.leg_length_m)
    ohm = resistance_ohm(
        c,
        stress_pa,
        state.martensite_fraction,
        state.r_phase_fraction,
        state.temperature_k,
        wire.shakedown.remaining,
    )
    if abs(rise_k) > NO_RISE_K:
        steepest = SAFE_SLOPE_FRACTION * c.martensite_stress_rate_pa_per_k
        state.stress_slope_pa_per_k = min(max((stress_pa - state.stress_pa) / rise_k, -steepest), steepest)
    state.work_j = 0.5 * (stress_pa + state.stress_pa) * c.legs * c.area_m2 * moved_m
    state.friction_n = rubbing_n(state.friction_n, moved_m, limit_n, c.friction_presliding_m)
    state.stress_pa = stress_pa
    state.contraction = contraction
    state.resistance_rate_ohm_per_s = (ohm - state.resistance_ohm) / dt_s
    state.resistance_ohm = ohm


@compiled
def rubbing_n(before_n: float, moved_m: float, limit_n: float, presliding_m: float) -> float:
    """Return friction after a small motion (Dahl, exponent 0), explicit: stiffer than the wire it loses itself."""
    if limit_n <= 0.0:
        return 0.0
    return min(max(before_n + limit_n / presliding_m * moved_m, -limit_n), limit_n)


@compiled
def resistance_ahead_ohm(state: Any, dt_s: float) -> float:
    """Return the resistance half a step ahead: its predicted mean over the step."""
    return state.resistance_ohm + 0.5 * dt_s * state.resistance_rate_ohm_per_s


@compiled
def step(wire: Running, power_w: float, dt_s: float) -> None:
    """Advance a wire on its load by one step at an electrical power."""
    rise_k = heat_wire(wire, power_w, dt_s)
    settle_at(wire, rise_k, dt_s, equilibrium_stress_pa(wire, 0.0, 0.0))
