"""A wire on a spring through time, compiled.

A step: electrical balance (voltage divider), heat balance in enthalpy form, grains, mechanical balance. Its order
and its two linear predictions are explained in docs/explanation/numerics.md.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from musclewire.compiled import compiled, compiled_inline
from musclewire.physics.mechanics import friction_force_n
from musclewire.physics.resistivity import REFERENCE_TEMPERATURE_K
from musclewire.simulate.balances import (
    contraction_at_stress,
    convection_w_per_m2_k,
    friction_limit_n,
    resistance_of,
    stress_in_balance_pa,
)
from musclewire.simulate.state import FloatArray, Sums, WireConstants, WireNumbers, WireState
from musclewire.simulate.switching import drives_at, drives_from, keep_drives, switch_grains

__all__ = ["advance", "advance_plain"]

# A predicted capacity beyond this multiple of the wire's own means a plateau; more would only slow recovery.
LARGEST_CAPACITY_RATIO = 30.0
# How steeply stress is predicted to follow temperature at most, as a share of Clausius and Clapeyron's slope. A rest
# leaves a slope of rounding errors; were it steeper than theirs, a wire that cools would be predicted to lose stress
# faster than martensite needs to, and would turn to austenite by cooling. A soft load shows that in its next step, a
# stiff one cannot.
SAFE_SHARE = 0.8
# Parts in which a step's heat is taken up, at most; and the share of it that may be left for the next step.
MOST_PARTS = 6
SMALL_PART = 1e-2
# Rises below this are rounding.
NO_RISE_K = 1e-9
NUMBERS = len(WireNumbers._fields)


class Freshness(NamedTuple):
    """How new a wire still is: 1 before its first cycle, 0 when settled, and what that does."""

    fresh: float
    residual_strain: float
    barrier_factor: float


@compiled
def freshness_of(constants: WireConstants, cycles: float) -> Freshness:
    """Return the state of a wire's shakedown after some cycles."""
    fresh = math.exp(-cycles / constants.shakedown_cycles)
    return Freshness(fresh, constants.shakedown_strain * (1.0 - fresh), 1.0 + constants.shakedown_barrier * fresh)


class TakenUp(NamedTuple):
    """Where a step's heat has brought a wire, the capacity it showed, and the rise its grains have followed."""

    temperature_k: float
    martensite: float
    r_phase: float
    capacity_j_per_k: float
    rise_k: float


@compiled_inline
def heat_taken_up(
    state: WireNumbers,
    constants: WireConstants,
    freshness: Freshness,
    heat_j: float,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
    seen_drives: FloatArray,
) -> TakenUp:
    """Return temperature and phases after a step's heat, found together; the grains move in place.

    A rise is tried with the last known capacity, the grains follow it, and enthalpy says what rise is left. Stress
    goes along by its slope in the step before. Energy is kept to rounding.
    """
    own = constants.heat_capacity_j_per_k
    ratio = constants.r_phase_entropy_ratio
    enthalpy_j = state.enthalpy_j + heat_j
    martensite, r_phase, capacity = state.martensite_fraction, state.r_phase_fraction, state.capacity_j_per_k
    grains = grain_martensite.shape[0]
    rise_k = 0.0
    temperature_k = state.temperature_k
    left_k = heat_j / own
    for _ in range(MOST_PARTS):
        # Latent heat makes the wire's capacity larger than its own by a factor only known once grains have moved.
        # Coming from below, a part of the way at a time, never moves grains further than the heat there is.
        part_k = left_k * own / capacity
        rise_k += part_k
        drives = drives_at(
            constants,
            state.temperature_k + rise_k,
            state.stress_pa + state.stress_slope_pa_per_k * rise_k,
            freshness.barrier_factor,
        )
        seen = drives_from(seen_drives)
        change_m, change_r = switch_grains(constants, drives, seen, grain_martensite, grain_r_phase)
        keep_drives(drives, seen_drives)
        martensite += change_m / grains
        r_phase += change_r / grains
        temperature_k = (
            REFERENCE_TEMPERATURE_K + (enthalpy_j + constants.latent_heat_j * (martensite + ratio * r_phase)) / own
        )
        if part_k != 0.0:
            capacity = own - constants.latent_heat_j * (change_m + ratio * change_r) / (grains * part_k)
            capacity = min(max(capacity, own), LARGEST_CAPACITY_RATIO * own)
        left_before_k, left_k = left_k, state.temperature_k + rise_k
        left_k = temperature_k - left_k
        if left_k * left_before_k <= 0.0 or abs(left_k) < SMALL_PART * abs(heat_j / own) + NO_RISE_K:
            break
    return TakenUp(temperature_k, martensite, r_phase, capacity, rise_k)


@compiled_inline
def heated(
    state: WireNumbers,
    constants: WireConstants,
    freshness: Freshness,
    power_w: float,
    dt_s: float,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
    seen_drives: FloatArray,
) -> tuple[WireNumbers, float]:
    """Return the wire after heat has flowed for one step and its grains have followed, and the rise they saw [K]."""
    middle_k = state.temperature_k + 0.5 * dt_s * state.temperature_rate_k_per_s
    excess_k = middle_k - constants.ambient_temperature_k
    loss_w = convection_w_per_m2_k(constants, middle_k) * constants.surface_m2 * excess_k
    heat_j = (power_w - loss_w) * dt_s
    taken = heat_taken_up(state, constants, freshness, heat_j, grain_martensite, grain_r_phase, seen_drives)
    after = WireNumbers(
        state.time_s,
        taken.temperature_k,
        state.stress_pa,
        state.contraction,
        state.friction_n,
        state.enthalpy_j + heat_j,
        state.heat_in_j + power_w * dt_s,
        state.heat_out_j + loss_w * dt_s,
        state.cycles + 0.5 * abs(taken.martensite - state.martensite_fraction),
        taken.martensite,
        taken.r_phase,
        state.resistance_ohm,
        taken.capacity_j_per_k,
        state.stress_slope_pa_per_k,
        (taken.temperature_k - state.temperature_k) / dt_s,
        state.resistance_rate_ohm_per_s,
    )
    return after, taken.rise_k


@compiled_inline
def settled(
    state: WireNumbers,
    constants: WireConstants,
    freshness: Freshness,
    rise_k: float,
    dt_s: float,
    stress_pa: float,
) -> WireNumbers:
    """Return the wire under its new stress, with the contraction, friction and resistance it then has.

    How stress followed temperature is kept for the next step's prediction, as far as it can be trusted.
    """
    martensite, r_phase, temperature_k = state.martensite_fraction, state.r_phase_fraction, state.temperature_k
    contraction = contraction_at_stress(
        constants, stress_pa, martensite, r_phase, temperature_k, freshness.residual_strain
    )
    moved_m = (contraction - state.contraction) * constants.leg_length_m
    limit_n = friction_limit_n(constants, contraction * constants.leg_length_m)
    friction_n = friction_force_n(state.friction_n, moved_m, limit_n, constants.friction_presliding_m)
    slope = state.stress_slope_pa_per_k
    if abs(rise_k) > NO_RISE_K:
        slope = (stress_pa - state.stress_pa) / rise_k
        steepest = SAFE_SHARE * constants.martensite_stress_rate_pa_per_k
        slope = min(max(slope, -steepest), steepest)
    resistance_ohm = resistance_of(constants, stress_pa, martensite, r_phase, temperature_k, freshness.fresh)
    return WireNumbers(
        state.time_s,
        temperature_k,
        stress_pa,
        contraction,
        friction_n,
        state.enthalpy_j,
        state.heat_in_j,
        state.heat_out_j,
        state.cycles,
        martensite,
        r_phase,
        resistance_ohm,
        state.capacity_j_per_k,
        slope,
        state.temperature_rate_k_per_s,
        (resistance_ohm - state.resistance_ohm) / dt_s,
    )


@compiled_inline
def balanced(
    state: WireNumbers,
    constants: WireConstants,
    freshness: Freshness,
    rise_k: float,
    dt_s: float,
    push_n: float,
    push_n_per_m: float,
) -> WireNumbers:
    """Return the wire in balance with its load and a push on its connector, with the resistance it then has."""
    stress_pa = stress_in_balance_pa(
        constants,
        state.stress_pa,
        state.martensite_fraction,
        state.r_phase_fraction,
        state.temperature_k,
        state.friction_n,
        freshness.residual_strain,
        push_n,
        push_n_per_m,
    )
    return settled(state, constants, freshness, rise_k, dt_s, stress_pa)


def advance(
    state: WireState, constants: WireConstants, drive_voltage_v: float, dt_s: float, steps: int
) -> tuple[WireState, Sums]:
    """Return the state after ``steps`` steps of ``dt_s`` at one drive voltage, and the means on the way.

    The state given is left as it was. Energy is kept to rounding: enthalpy changes by heat in minus heat
    out, and temperature follows from enthalpy and phase fractions.
    """
    # Only plain tuples cross into compiled code and back. Numba would call the class of a named tuple on the way
    # out; a Ctrl-C that arrives in that call finds nobody to handle it, and the process dies on the spot.
    numbers: tuple[Any, ...] = tuple(state[:NUMBERS])
    martensite, r_phase, seen = state.grain_martensite.copy(), state.grain_r_phase.copy(), state.seen_drives.copy()
    after, means = advance_plain(numbers, martensite, r_phase, seen, tuple(constants), drive_voltage_v, dt_s, steps)
    return WireState._make((*after, martensite, r_phase, seen)), Sums(*means)


@compiled
def advance_plain(
    numbers: tuple[float, ...],
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
    seen_drives: FloatArray,
    constant_values: tuple[Any, ...],
    drive_voltage_v: float,
    dt_s: float,
    steps: int,
) -> tuple[tuple[Any, ...], tuple[float, float, float, float]]:
    """Do the work of :func:`advance` on plain tuples, with the grains' arrays in place."""
    constants = WireConstants(*constant_values)
    state = WireNumbers(*numbers)
    freshness = freshness_of(constants, state.cycles)
    wire_voltage_sum = 0.0
    shunt_voltage_sum = 0.0
    displacement_sum = 0.0
    force_sum = 0.0
    for _ in range(steps):
        # Resistance half a step ahead, as it will be on the mean over the step.
        resistance_ohm = state.resistance_ohm + 0.5 * dt_s * state.resistance_rate_ohm_per_s
        # The buffer amplifier drives wire, shunt and leads in series.
        current = drive_voltage_v / (resistance_ohm + constants.series_resistance_ohm)
        power_w = current * current * resistance_ohm
        wire_voltage_sum += current * resistance_ohm
        shunt_voltage_sum += current * constants.shunt_resistance_ohm
        state, rise_k = heated(state, constants, freshness, power_w, dt_s, grain_martensite, grain_r_phase, seen_drives)
        contraction, stress_pa = state.contraction, state.stress_pa
        state = balanced(state, constants, freshness, rise_k, dt_s, 0.0, 0.0)
        # The mean over a step, as for the voltages: else strain would lag resistance by a step.
        displacement_sum += 0.5 * (contraction + state.contraction) * constants.leg_length_m
        force_sum += 0.5 * (stress_pa + state.stress_pa) * constants.legs * constants.area_m2
    means = (wire_voltage_sum / steps, shunt_voltage_sum / steps, displacement_sum / steps, force_sum / steps)
    time_s = state.time_s + steps * dt_s
    return plain(state, time_s, state.martensite_fraction, state.r_phase_fraction), means


@compiled
def plain(state: WireNumbers, time_s: float, martensite_fraction: float, r_phase_fraction: float) -> tuple[float, ...]:
    """Return the numbers as a plain tuple, with time, which would gather rounding errors if kept up step by step.

    The phase fractions stay as they were kept up: fresh ones differ in the last bit, which the predictions of the
    next steps would blow up, so that a run cut in two would not be the run in one.
    """
    return (
        time_s,
        state.temperature_k,
        state.stress_pa,
        state.contraction,
        state.friction_n,
        state.enthalpy_j,
        state.heat_in_j,
        state.heat_out_j,
        state.cycles,
        martensite_fraction,
        r_phase_fraction,
        state.resistance_ohm,
        state.capacity_j_per_k,
        state.stress_slope_pa_per_k,
        state.temperature_rate_k_per_s,
        state.resistance_rate_ohm_per_s,
    )
