"""The inner loop: one wire on one spring through time, compiled.

Per step: electrical balance (voltage divider), heat balance in enthalpy form, grains, mechanical balance.
The order of a step and its two linear predictions are explained in docs/explanation/numerics.md.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.compiled import compiled
from musclewire.physics.mechanics import (
    friction_force_n,
    maximum_transformation_strain,
    maximum_transformation_strain_slope_per_pa,
    reuss_modulus_pa,
)
from musclewire.physics.resistivity import (
    REFERENCE_TEMPERATURE_K,
    phase_resistivity_ohm_m,
    wire_resistance_ohm,
)
from musclewire.physics.transformation import advantage_k, cooled_grain, heated_grain

__all__ = [
    "Drives",
    "Sums",
    "WireConstants",
    "WireState",
    "advance",
    "cool_swept",
    "cooled_plain",
    "drives_at",
    "heat_swept",
    "strain_at",
    "switch_grains",
    "total_strain",
]

FloatArray = NDArray[np.float64]

# A predicted capacity beyond this multiple of the wire's own means a plateau; more would only slow recovery.
LARGEST_CAPACITY_RATIO = 30.0
# Twice the steepest Clausius-Clapeyron slope of martensite: no load makes stress follow temperature faster.
STEEPEST_STRESS_PA_PER_K = 2e7


class WireConstants(NamedTuple):
    """Everything that does not change while a wire runs; SI units. Built by ``simulate.wire``."""

    wire_length_m: float
    leg_length_m: float
    legs: float
    austenite_length_m: float
    area_m2: float
    surface_m2: float
    heat_capacity_j_per_k: float
    latent_heat_j: float
    series_resistance_ohm: float
    shunt_resistance_ohm: float
    ambient_temperature_k: float
    convection_factor: float
    convection_table_start_k: float
    convection_table_step_k: float
    convection_table_w_per_m2_k: FloatArray
    pretension_n: float
    spring_stiffness_n_per_m: float
    friction_n: float
    friction_presliding_m: float
    martensite_temperature_k: float
    martensite_stress_rate_pa_per_k: float
    martensite_barrier_k: float
    martensite_barrier_per_pa: float
    r_phase_temperature_k: float
    r_phase_stress_rate_pa_per_k: float
    r_phase_entropy_ratio: float
    r_phase_barrier_k: float
    r_to_m_barrier_k: float
    strain_at_no_stress: float
    strain_saturated: float
    strain_stress_scale_pa: float
    r_phase_strain: float
    austenite_modulus_pa: float
    martensite_modulus_pa: float
    austenite_expansion_per_k: float
    martensite_expansion_per_k: float
    austenite_resistivity_ohm_m: float
    austenite_resistivity_per_k: float
    r_phase_resistivity_ohm_m: float
    r_phase_resistivity_per_k: float
    martensite_resistivity_ohm_m: float
    martensite_resistivity_per_k: float
    shakedown_cycles: float
    shakedown_strain: float
    shakedown_resistivity: float
    shakedown_barrier: float
    cold_strain: float
    martensite_spread_k: float
    r_phase_spread_k: float
    grain_edges: FloatArray
    grain_middle: FloatArray
    grain_width: FloatArray


class WireState(NamedTuple):
    """All that a wire remembers.

    ``grain_*`` are shares of each grain, (n_grains,); ``seen_drives_k`` the drives they last followed, (6,).
    """

    time_s: float
    temperature_k: float
    stress_pa: float
    contraction: float
    friction_n: float
    enthalpy_j: float
    heat_in_j: float
    heat_out_j: float
    cycles: float
    martensite_fraction: float
    r_phase_fraction: float
    resistance_ohm: float
    capacity_j_per_k: float
    stress_slope_pa_per_k: float
    grain_martensite: FloatArray
    grain_r_phase: FloatArray
    seen_drives_k: FloatArray


class Sums(NamedTuple):
    """Means over one call of :func:`advance`: what an averaging acquisition card sees."""

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float
    force_n: float


@compiled
def inverse_of_spread_per_k(spread_k: float) -> float:
    """Return 1/spread, with a spread under a microkelvin taken as that: a switch rather than a ramp."""
    return 1.0 / max(abs(spread_k), 1e-6)


class Drives(NamedTuple):
    """How far [K] each of the six phase changes is beyond its barrier, for a grain of offset 0."""

    a_to_m_k: float
    a_to_r_k: float
    r_to_m_k: float
    m_to_a_k: float
    r_to_a_k: float
    m_to_r_k: float


@compiled
def drives_at(constants: WireConstants, temperature_k: float, stress_pa: float, barrier_factor: float) -> Drives:
    """Return the six drives at a temperature and a stress."""
    martensite = advantage_k(
        temperature_k,
        stress_pa,
        constants.martensite_temperature_k,
        constants.martensite_stress_rate_pa_per_k,
    )
    r_phase = constants.r_phase_entropy_ratio * advantage_k(
        temperature_k, stress_pa, constants.r_phase_temperature_k, constants.r_phase_stress_rate_pa_per_k
    )
    preference = martensite - r_phase
    barrier = barrier_factor * (constants.martensite_barrier_k + constants.martensite_barrier_per_pa * stress_pa)
    return Drives(
        martensite - barrier,
        r_phase - constants.r_phase_barrier_k,
        preference - constants.r_to_m_barrier_k,
        -martensite - barrier,
        -r_phase - constants.r_phase_barrier_k,
        -preference - constants.r_to_m_barrier_k,
    )


@compiled
def spreads(constants: WireConstants) -> tuple[float, float, float]:
    """Return the spreads [K] over the grains of f_M, f_R and f_M - f_R.

    A spread under a microkelvin counts as that: a switch rather than a ramp.
    """
    spread_m = constants.martensite_spread_k
    spread_r = constants.r_phase_entropy_ratio * constants.r_phase_spread_k
    spread_p = spread_m - spread_r
    if abs(spread_p) < 1e-6:
        spread_p = 1e-6
    return max(spread_m, 1e-6), max(spread_r, 1e-6), spread_p


@compiled
def grain_at(edges: FloatArray, place: float) -> int:
    """Return the number of the grain that holds a place in units of the spread; -1 and n_grains lie outside."""
    low = -1
    high = edges.shape[0]
    while high - low > 1:
        middle = (low + high) // 2
        if edges[middle] <= place:
            low = middle
        else:
            high = middle
    return low


@compiled
def grains_swept(edges: FloatArray, before: float, after: float) -> tuple[int, int]:
    """Return first and past-the-last grain between two places of a moving threshold, both places included."""
    first = grain_at(edges, min(before, after))
    last = grain_at(edges, max(before, after))
    return max(first, 0), min(last + 1, edges.shape[0] - 1)


@compiled
def cool_swept(
    constants: WireConstants,
    drives: Drives,
    first: int,
    last: int,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> None:
    """Let grains ``first`` to before ``last`` follow the cooling drives, in place."""
    spread_m, spread_r, spread_p = spreads(constants)
    for j in range(first, last):
        middle = constants.grain_middle[j]
        per_width = 1.0 / constants.grain_width[j]
        grain_martensite[j], grain_r_phase[j] = cooled_grain(
            grain_martensite[j],
            grain_r_phase[j],
            drives.a_to_m_k + spread_m * middle,
            drives.a_to_r_k + spread_r * middle,
            drives.r_to_m_k + spread_p * middle,
            per_width / spread_m,
            per_width / spread_r,
            per_width / abs(spread_p),
        )


@compiled
def heat_swept(
    constants: WireConstants,
    drives: Drives,
    first: int,
    last: int,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> None:
    """Let grains ``first`` to before ``last`` follow the heating drives, in place."""
    spread_m, spread_r, spread_p = spreads(constants)
    for j in range(first, last):
        middle = constants.grain_middle[j]
        per_width = 1.0 / constants.grain_width[j]
        grain_martensite[j], grain_r_phase[j] = heated_grain(
            grain_martensite[j],
            grain_r_phase[j],
            drives.m_to_a_k - spread_m * middle,
            drives.r_to_a_k - spread_r * middle,
            drives.m_to_r_k - spread_p * middle,
            per_width / spread_m,
            per_width / spread_r,
            per_width / abs(spread_p),
        )


@compiled
def switch_grains(
    constants: WireConstants,
    drives: Drives,
    seen: Drives,
    grain_martensite: FloatArray,
    grain_r_phase: FloatArray,
) -> tuple[float, float]:
    """Let every grain follow drives that changed from ``seen``, in place; return the change of both sums of shares.

    A grain moves only when one of its drives has risen, and only if that drive's threshold swept over it: so a
    step looks at the few grains between the thresholds before and after, whatever their number in all.
    """
    spread_m, spread_r, spread_p = spreads(constants)
    edges = constants.grain_edges
    change_m = 0.0
    change_r = 0.0
    for change in range(6):
        if change == 0:
            new, old, spread = drives.a_to_m_k, seen.a_to_m_k, -spread_m
        elif change == 1:
            new, old, spread = drives.a_to_r_k, seen.a_to_r_k, -spread_r
        elif change == 2:
            new, old, spread = drives.r_to_m_k, seen.r_to_m_k, -spread_p
        elif change == 3:
            new, old, spread = drives.m_to_a_k, seen.m_to_a_k, spread_m
        elif change == 4:
            new, old, spread = drives.r_to_a_k, seen.r_to_a_k, spread_r
        else:
            new, old, spread = drives.m_to_r_k, seen.m_to_r_k, spread_p
        if new <= old:
            continue
        first, last = grains_swept(edges, old / spread, new / spread)
        for j in range(first, last):
            change_m -= grain_martensite[j]
            change_r -= grain_r_phase[j]
        if change < 3:
            cool_swept(constants, drives, first, last, grain_martensite, grain_r_phase)
        else:
            heat_swept(constants, drives, first, last, grain_martensite, grain_r_phase)
        for j in range(first, last):
            change_m += grain_martensite[j]
            change_r += grain_r_phase[j]
    return change_m, change_r


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
def stress_in_balance_pa(
    constants: WireConstants,
    stress_pa: float,
    martensite: float,
    r_phase: float,
    temperature_k: float,
    friction_n: float,
    residual_strain: float,
) -> float:
    """Return the leg stress [Pa] at which wire and spring agree: one Newton step from ``stress_pa``.

    F_T = F_p + k S l_leg + friction, sigma = F_T / (legs A); a slack wire carries nothing.
    The function is almost linear in stress, so that one step leaves an error of second order.
    """
    strain = total_strain(constants, stress_pa, martensite, r_phase, temperature_k) + residual_strain
    contraction = constants.cold_strain - strain
    stiffness = constants.spring_stiffness_n_per_m * constants.leg_length_m
    section = constants.legs * constants.area_m2
    wanted = (constants.pretension_n + stiffness * contraction + friction_n) / section
    compliance = 1.0 / reuss_modulus_pa(
        martensite, constants.austenite_modulus_pa, constants.martensite_modulus_pa
    ) + martensite * maximum_transformation_strain_slope_per_pa(
        stress_pa,
        constants.strain_at_no_stress,
        constants.strain_saturated,
        constants.strain_stress_scale_pa,
    )
    return max(stress_pa - (stress_pa - wanted) / (1.0 + stiffness * compliance / section), 0.0)


@compiled
def resistance_of(
    constants: WireConstants,
    stress_pa: float,
    martensite: float,
    r_phase: float,
    temperature_k: float,
    fresh: float,
) -> float:
    """Return the wire's resistance [ohm]: phases mixed by volume, then the change of shape."""
    transformation, elastic, thermal = strain_at(constants, stress_pa, martensite, r_phase, temperature_k)
    martensite_resistivity = constants.martensite_resistivity_ohm_m * (1.0 + constants.shakedown_resistivity * fresh)
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
        resistivity, constants.austenite_length_m, constants.area_m2, transformation, elastic + thermal
    )


@compiled
def convection_w_per_m2_k(constants: WireConstants, temperature_k: float) -> float:
    """Return the heat transfer coefficient at this wall temperature, from the wire's table."""
    table = constants.convection_table_w_per_m2_k
    place = (temperature_k - constants.convection_table_start_k) / constants.convection_table_step_k
    place = min(max(place, 0.0), table.shape[0] - 1.001)
    low = int(place)
    part = place - low
    return constants.convection_factor * (table[low] * (1.0 - part) + table[low + 1] * part)


def advance(
    state: WireState, constants: WireConstants, drive_voltage_v: float, dt_s: float, steps: int
) -> tuple[WireState, Sums]:
    """Return the state after ``steps`` steps of ``dt_s`` at one drive voltage, and the means on the way.

    The state given is left as it was. Energy is kept to rounding: enthalpy changes by heat in minus heat
    out, and temperature follows from enthalpy and phase fractions.
    """
    # Only plain tuples cross into compiled code and back. Numba would call the class of a named tuple on the way
    # out; a Ctrl-C that arrives in that call finds nobody to handle it, and the process dies on the spot.
    values = advance_plain(tuple(state), tuple(constants), drive_voltage_v, dt_s, steps)
    return WireState(*values[: len(WireState._fields)]), Sums(*values[len(WireState._fields) :])


@compiled
def advance_plain(
    state_values: tuple[Any, ...],
    constant_values: tuple[Any, ...],
    drive_voltage_v: float,
    dt_s: float,
    steps: int,
) -> tuple[Any, ...]:
    """Do the work of :func:`advance` on plain tuples: state and means in one tuple."""
    state = WireState(*state_values)
    constants = WireConstants(*constant_values)
    grain_martensite = state.grain_martensite.copy()
    grain_r_phase = state.grain_r_phase.copy()
    temperature = state.temperature_k
    stress = state.stress_pa
    contraction = state.contraction
    friction = state.friction_n
    enthalpy = state.enthalpy_j
    heat_in = state.heat_in_j
    heat_out = state.heat_out_j
    cycles = state.cycles
    martensite = state.martensite_fraction
    r_phase = state.r_phase_fraction
    resistance = state.resistance_ohm
    capacity = state.capacity_j_per_k
    stress_slope = state.stress_slope_pa_per_k

    fresh = math.exp(-cycles / constants.shakedown_cycles)
    residual = constants.shakedown_strain * (1.0 - fresh)
    barrier_factor = 1.0 + constants.shakedown_barrier * fresh
    drive = state.seen_drives_k
    seen = Drives(drive[0], drive[1], drive[2], drive[3], drive[4], drive[5])
    grains = grain_martensite.shape[0]
    own_capacity = constants.heat_capacity_j_per_k
    wire_voltage_sum = 0.0
    shunt_voltage_sum = 0.0
    displacement_sum = 0.0
    force_sum = 0.0

    for _ in range(steps):
        # Electrical balance: the buffer amplifier drives wire, shunt and leads in series.
        current = drive_voltage_v / (resistance + constants.series_resistance_ohm)
        power = current * current * resistance
        wire_voltage_sum += current * resistance
        shunt_voltage_sum += current * constants.shunt_resistance_ohm

        # Heat balance in enthalpy; the grains see a temperature and a stress predicted one step ahead.
        excess = temperature - constants.ambient_temperature_k
        loss = convection_w_per_m2_k(constants, temperature) * constants.surface_m2 * excess
        heat_in += power * dt_s
        heat_out += loss * dt_s
        heat = (power - loss) * dt_s
        enthalpy += heat
        rise = heat / capacity
        drives = drives_at(constants, temperature + rise, stress + stress_slope * rise, barrier_factor)
        change_m, change_r = switch_grains(constants, drives, seen, grain_martensite, grain_r_phase)
        new_martensite = martensite + change_m / grains
        new_r_phase = r_phase + change_r / grains
        seen = drives
        transformed = (new_martensite - martensite) + constants.r_phase_entropy_ratio * (new_r_phase - r_phase)
        cycles += 0.5 * abs(new_martensite - martensite)
        martensite = new_martensite
        r_phase = new_r_phase
        temperature = (
            REFERENCE_TEMPERATURE_K
            + (enthalpy + constants.latent_heat_j * (martensite + constants.r_phase_entropy_ratio * r_phase))
            / own_capacity
        )

        # Mechanical balance with the load.
        new_stress = stress_in_balance_pa(constants, stress, martensite, r_phase, temperature, friction, residual)
        new_contraction = (
            constants.cold_strain - total_strain(constants, new_stress, martensite, r_phase, temperature) - residual
        )
        friction = friction_force_n(
            friction,
            (new_contraction - contraction) * constants.leg_length_m,
            constants.friction_n,
            constants.friction_presliding_m,
        )
        contraction = new_contraction
        if abs(rise) > 1e-9:
            capacity = own_capacity - constants.latent_heat_j * transformed / rise
            capacity = min(max(capacity, own_capacity), LARGEST_CAPACITY_RATIO * own_capacity)
            stress_slope = (new_stress - stress) / rise
            stress_slope = min(max(stress_slope, -STEEPEST_STRESS_PA_PER_K), STEEPEST_STRESS_PA_PER_K)
        stress = new_stress
        resistance = resistance_of(constants, stress, martensite, r_phase, temperature, fresh)
        displacement_sum += contraction * constants.leg_length_m
        force_sum += stress * constants.legs * constants.area_m2

    # Sums kept step by step gather rounding errors; the state goes out with fresh ones.
    martensite = grain_martensite.mean()
    r_phase = grain_r_phase.mean()
    return (
        state.time_s + steps * dt_s,
        temperature,
        stress,
        contraction,
        friction,
        enthalpy,
        heat_in,
        heat_out,
        cycles,
        martensite,
        r_phase,
        resistance,
        capacity,
        stress_slope,
        grain_martensite,
        grain_r_phase,
        np.array([seen.a_to_m_k, seen.a_to_r_k, seen.r_to_m_k, seen.m_to_a_k, seen.r_to_a_k, seen.m_to_r_k]),
        wire_voltage_sum / steps,
        shunt_voltage_sum / steps,
        displacement_sum / steps,
        force_sum / steps,
    )


@compiled
def cooled_plain(
    constant_values: tuple[Any, ...], stress_pa: float, hottest_k: float, coldest_k: float, steps: int
) -> tuple[Any, ...]:
    """Return martensite and R-phase of the grains, and drives, after cooling from all austenite at one stress."""
    constants = WireConstants(*constant_values)
    grains = constants.grain_middle.shape[0]
    grain_martensite = np.zeros(grains)
    grain_r_phase = np.zeros(grains)
    drives = drives_at(constants, hottest_k, stress_pa, 1.0)
    for step in range(steps + 1):
        temperature = hottest_k + (coldest_k - hottest_k) * step / steps
        drives = drives_at(constants, temperature, stress_pa, 1.0)
        cool_swept(constants, drives, 0, grains, grain_martensite, grain_r_phase)
    seen = np.array(
        [drives.a_to_m_k, drives.a_to_r_k, drives.r_to_m_k, drives.m_to_a_k, drives.r_to_a_k, drives.m_to_r_k]
    )
    return grain_martensite, grain_r_phase, seen
