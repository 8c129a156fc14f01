"""One step of one wire, compiled: heat in, then temperature and stress together from enthalpy and the load's force.

Works in place on the state's record of a :class:`RunningWire`. The method, its order and its error are explained in
docs/explanation/numerics.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.compiled import compiled_inline, compiled_inner
from musclewire.wire._balance import (
    BalancedWire,
    ConnectorForce,
    LoadPoint,
    TrialPoint,
    balance_at,
    contraction_of,
    settled,
    strain_at,
)
from musclewire.wire._fronts import PhaseFractions, ShakedownEffects, cumulative_at, fronts_after, phases_of_class
from musclewire.wire._row import Rows, StepConstants, WireState

# Newton's last step may be this long: it is applied linearly, and the error that remains is of second order in it.
SOLVED_K = 1e-3
PLAIN_STEPS = 4  # of Newton, after which the safe method begins
MAX_EVALUATIONS = 200  # of the balance, after which a step counts as unsolved
# From here on the safe method halves its bracket instead of trusting slopes.
BISECT_AFTER = 60
# Bend of the load within the last Newton step that may be left.
SMALL_BEND_N = 1e-6
# A connector whose load is balanced by friction to within this stays where it is.
HELD_N = 1e-9
# Heat below this is rounding.
NO_HEAT_J = 1e-12
NO_PUSH = ConnectorForce(0.0, 0.0, 0.0)


class RunningWire(NamedTuple):
    """A wire in compiled code: its two records, of which a step changes the state, and both tables."""

    state: WireState
    constants: StepConstants
    cells: Rows
    load: Rows


class Equilibrium(NamedTuple):
    """A solution of both balances with the slopes that the next guess needs, the load in balance."""

    wire: BalancedWire
    temperature_slope_k_per_j: float
    stress_slope_pa_per_j: float
    contraction_slope_per_j: float
    stress_per_contraction_pa: float  # at constant enthalpy, negative: what a second wire on the same connector feels
    evaluations: int  # of the balances
    solved: bool


@compiled_inline
def friction_at(
    limit_n: float, limit_per_contraction_n: float, per_presliding: float, before_n: float, moved: float
) -> tuple[float, float]:
    """Return friction [N] after a motion, with its slope over contraction [N]: elastic first, then Coulomb.

    ``per_presliding`` is the contraction per motion over which friction rises from 0 to its limit, ``moved`` a
    contraction.

    References
    ----------
    Dahl's model with exponent 0: Dahl 1968, Aerospace Corp. TOR-0158(3107-18)-1.
    """
    per_contraction = limit_n * per_presliding
    elastic = before_n + per_contraction * moved
    above, below = elastic > limit_n, elastic < -limit_n
    friction = limit_n if above else (-limit_n if below else elastic)
    slope = limit_per_contraction_n if above else (-limit_per_contraction_n if below else per_contraction)
    return friction, slope


@compiled_inline
def load_at(
    constants: StepConstants, load: Rows, contraction: float, before: tuple[float, float], push: ConnectorForce
) -> LoadPoint:
    """Return the load's force at a contraction: pretension, spring, table, push, and friction after the motion there.

    ``load`` has force and friction beyond spring and guide [N], (2, n_points). Below 0 the force is that of the first
    point; beyond the last point it keeps its slope, and friction its value. ``before`` is the connector's contraction
    and the friction [N] before the motion.
    """
    k = constants
    force_n = k.pretension_n + k.spring_n * contraction
    force_n += push.force_n + push.per_contraction_n * (contraction - push.contraction)
    slope_n = k.spring_n + push.per_contraction_n
    limit_n, limit_slope_n = k.friction_n, 0.0
    if load.table.shape[1] > 2:
        last = load.table.shape[1] - 1
        place = contraction * k.load_points_per_contraction
        inside = place if place > 0.0 else 0.0
        low = int(inside) if inside < last else last - 1
        rise_n = load.table[0, low + 1] - load.table[0, low]
        force_n += load.table[0, low] + rise_n * (inside - low)
        slope_n += rise_n * k.load_points_per_contraction if place > 0.0 else 0.0
        part = inside - low if inside < last else 1.0
        rub_n = load.table[1, low + 1] - load.table[1, low]
        limit_n += load.table[1, low] + rub_n * part
        limit_slope_n = rub_n * k.load_points_per_contraction if (place > 0.0) & (place < last) else 0.0
        limit_slope_n = limit_slope_n if limit_n > 0.0 else 0.0
        limit_n = limit_n if limit_n > 0.0 else 0.0
    friction_n, friction_slope_n = friction_at(
        limit_n, limit_slope_n, k.per_presliding, before[1], contraction - before[0]
    )
    return LoadPoint(force_n + friction_n, slope_n + friction_slope_n, friction_n, friction_slope_n, limit_n)


@compiled_inline
def phases_at(wire: RunningWire, shakedown: ShakedownEffects, temperature_k: float, stress_pa: float) -> PhaseFractions:
    """Return the volume fractions at a trial point, from the fronts before; those after go to ``front_trial``."""
    state, k = wire.state, wire.constants
    trial = state.front_trial
    whole = PhaseFractions(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for row in range(state.front_austenite.shape[0]):
        before = (state.front_austenite[row], state.front_martensite[row])
        after = fronts_after(k, temperature_k, stress_pa, shakedown.barrier_factor, k.class_barrier_k[row], before)
        martensite = cumulative_at(k, wire.cells, row, after.martensite)
        austenite = cumulative_at(k, wire.cells, row, after.austenite)
        part = phases_of_class(k.class_weight[row], after, martensite, austenite)
        whole = PhaseFractions(
            whole.martensite + part.martensite,
            whole.r_phase + part.r_phase,
            whole.martensite_per_k + part.martensite_per_k,
            whole.martensite_per_pa + part.martensite_per_pa,
            whole.r_phase_per_k + part.r_phase_per_k,
            whole.r_phase_per_pa + part.r_phase_per_pa,
        )
        trial[6 * row] = after.austenite
        trial[6 * row + 1] = after.martensite
        trial[6 * row + 2] = after.austenite_per_k
        trial[6 * row + 3] = after.austenite_per_pa
        trial[6 * row + 4] = after.martensite_per_k
        trial[6 * row + 5] = after.martensite_per_pa
    return whole


@compiled_inline
def trial_at(
    wire: RunningWire,
    shakedown: ShakedownEffects,
    push: ConnectorForce,
    temperature_k: float,
    stress_pa: float,
    enthalpy_j: float,
) -> TrialPoint:
    """Return both balances at a trial temperature and stress."""
    state, k = wire.state, wire.constants
    phases = phases_at(wire, shakedown, temperature_k, stress_pa)
    strain = strain_at(k, temperature_k, stress_pa, phases.martensite, phases.r_phase)
    before = (state.connector_contraction, state.friction_n)
    load = load_at(k, wire.load, contraction_of(k, shakedown, strain), before, push)
    balance = balance_at(k, shakedown, phases, strain, load, (temperature_k, stress_pa, enthalpy_j))
    return TrialPoint(phases, strain, load, balance)


@compiled_inline
def bend_n(wire: RunningWire, point: TrialPoint, push: ConnectorForce, moved: float) -> float:
    """Return how far the load after a motion is from its straight continuation [N]: 0 for a spring without friction."""
    state, k = wire.state, wire.constants
    if wire.load.table.shape[1] == 2 and k.friction_n == 0.0:
        return 0.0
    before = (state.connector_contraction, state.friction_n)
    after = load_at(k, wire.load, point.balance.contraction + moved, before, push)
    return abs(after.force_n - (point.load.force_n + point.load.per_contraction_n * moved))


@compiled_inline
def solve(
    wire: RunningWire, shakedown: ShakedownEffects, enthalpy_j: float, guess: tuple[float, float], push: ConnectorForce
) -> Equilibrium:
    """Return temperature and stress of a wire at an enthalpy, in balance with its load, or the last trial, not solved.

    Newton's method in both unknowns, with one evaluation a step as a rule. If four steps do not suffice (a wall, a jump
    of the drive), stress is balanced at constant temperature in a bracket, and temperature by the reduced equation in
    another. Of the wire only ``front_trial`` changes.
    """
    temperature_k, stress_pa = guess
    k = wire.constants
    low_k, high_k, low_pa, high_pa = -math.inf, math.inf, 0.0, math.inf
    evaluations = 0
    solved = False
    while True:
        evaluations += 1
        point = trial_at(wire, shakedown, push, temperature_k, stress_pa, enthalpy_j)
        balance = point.balance
        rise_k, rise_pa = balance.rise_k, balance.rise_pa
        slack = stress_pa <= 0.0 and rise_pa < 0.0
        if slack:  # temperature alone meets the enthalpy
            rise_k, rise_pa = -balance.heat_j / balance.heat_per_k, 0.0
        if abs(rise_k) < SOLVED_K and abs(rise_pa) * k.martensite_k_per_pa < SOLVED_K:
            moved = balance.contraction_per_k * rise_k + balance.contraction_per_pa * rise_pa
            solved = slack or bend_n(wire, point, push, moved) < SMALL_BEND_N
        if solved or evaluations >= MAX_EVALUATIONS:
            break
        if evaluations <= PLAIN_STEPS:
            temperature_k += rise_k
            stress_pa = max(stress_pa + rise_pa, 0.0)
            continue
        if balance.excess_pa > 0.0:
            high_pa = min(high_pa, stress_pa)
        else:
            low_pa = max(low_pa, stress_pa)
        if not stress_balanced(k, point, stress_pa, high_pa - low_pa):
            stress_pa = next_stress_pa(point, stress_pa, low_pa, high_pa)
            continue
        low_pa, high_pa = 0.0, math.inf
        if balance.heat_j > 0.0:
            high_k = min(high_k, temperature_k)
        else:
            low_k = max(low_k, temperature_k)
        if high_k - low_k < 1e-3 * SOLVED_K:
            solved = True
            rise_k = rise_pa = 0.0
            break
        temperature_k = next_temperature_k(k, point, temperature_k, (low_k, high_k), evaluations)
    if not solved:
        rise_k = rise_pa = 0.0
    after = settled(k, shakedown, point, (rise_k, rise_pa), (temperature_k, stress_pa, enthalpy_j))
    return equilibrium_of(point, after, evaluations, solved)


@compiled_inline
def stress_balanced(constants: StepConstants, point: TrialPoint, stress_pa: float, bracket_pa: float) -> bool:
    """Return whether the force is balanced at the trial's temperature, or the wire is slack."""
    only_pa = point.balance.excess_pa / point.balance.excess_per_pa
    if abs(only_pa) * constants.martensite_k_per_pa < 0.1 * SOLVED_K or bracket_pa < 1.0:
        return True
    return stress_pa <= 0.0 and point.balance.excess_pa > 0.0


@compiled_inline
def next_stress_pa(point: TrialPoint, stress_pa: float, low_pa: float, high_pa: float) -> float:
    """Return the next trial stress [Pa] at constant temperature, within its bracket."""
    new_pa = stress_pa - point.balance.excess_pa / point.balance.excess_per_pa
    if point.balance.excess_per_pa > 0.0 and low_pa < new_pa < high_pa:
        return new_pa
    if point.balance.excess_per_pa > 0.0 and new_pa <= 0.0 and low_pa == 0.0:
        return 0.0
    return 0.5 * (low_pa + high_pa) if high_pa < math.inf else 2.0 * stress_pa + 1e7


@compiled_inline
def next_temperature_k(
    constants: StepConstants, point: TrialPoint, temperature_k: float, bracket_k: tuple[float, float], evaluations: int
) -> float:
    """Return the next trial temperature [K] by the equation reduced to it, within its bracket."""
    balance = point.balance
    low_k, high_k = bracket_k
    slope = balance.heat_per_k - balance.heat_per_pa * balance.excess_per_k / balance.excess_per_pa
    new_k = temperature_k - balance.heat_j / slope
    if low_k < new_k < high_k and evaluations <= BISECT_AFTER:
        return new_k
    if low_k > -math.inf and high_k < math.inf:
        return 0.5 * (low_k + high_k)
    # The capacity without latent heat never falls short of the root: it closes the bracket at once.
    return temperature_k - balance.heat_j * constants.per_capacity_k_per_j


@compiled_inline
def equilibrium_of(point: TrialPoint, after: BalancedWire, evaluations: int, solved: bool) -> Equilibrium:
    """Return a solution with its slopes over heat; a slack wire has those of temperature alone."""
    balance = point.balance
    taut = after.stress_pa > 0.0
    temperature_slope = balance.excess_per_pa * balance.per_determinant if taut else 1.0 / balance.heat_per_k
    stress_slope = -balance.excess_per_k * balance.per_determinant if taut else 0.0
    per_pa = balance.contraction_per_pa - balance.contraction_per_k * balance.heat_per_pa / balance.heat_per_k
    return Equilibrium(
        after,
        temperature_slope,
        stress_slope,
        balance.contraction_per_k * temperature_slope + balance.contraction_per_pa * stress_slope,
        1.0 / per_pa,
        evaluations,
        solved,
    )


class HalfStepWire(NamedTuple):
    """Wire half a step ahead, by the slopes over heat of the last step."""

    temperature_k: float
    resistance_ohm: float
    temperature_slope_k_per_j: float
    stress_slope_pa_per_j: float


@compiled_inline
def middle_of_step(state: WireState, constants: StepConstants, half_heat_j: float) -> HalfStepWire:
    """Return a wire half a step ahead, after half of the step's heat at the rate of its start.

    After a change from heating to cooling or back no phase changes at first: the slopes are those of the capacity
    without latent heat.
    """
    turned = half_heat_j * state.last_heat_j < 0.0
    temperature_slope = constants.per_capacity_k_per_j if turned else state.temperature_slope_k_per_j
    stress_slope = 0.0 if turned else state.stress_slope_pa_per_j
    resistance_slope = 0.0 if turned else state.resistance_slope_ohm_per_j
    return HalfStepWire(
        state.temperature_k + temperature_slope * half_heat_j,
        state.resistance_ohm + resistance_slope * half_heat_j,
        temperature_slope,
        stress_slope,
    )


@compiled_inline
def guess_after(state: WireState, middle: HalfStepWire, heat_j: float) -> tuple[float, float]:
    """Return temperature [K] and stress [Pa] after a step's heat, by the slopes of the step before."""
    return (
        state.temperature_k + middle.temperature_slope_k_per_j * heat_j,
        max(state.stress_pa + middle.stress_slope_pa_per_j * heat_j, 0.0),
    )


@compiled_inline
def accept(wire: RunningWire, found: Equilibrium, heat_j: float, push: ConnectorForce) -> None:
    """Move a wire to a solution: its state, its fronts, and the slopes for the next step."""
    state, after = wire.state, found.wire
    for row in range(state.front_austenite.shape[0]):
        trial = state.front_trial
        place = 6 * row
        state.front_austenite[row] = trial[place] + trial[place + 2] * after.rise_k + trial[place + 3] * after.rise_pa
        state.front_martensite[row] = (
            trial[place + 1] + trial[place + 4] * after.rise_k + trial[place + 5] * after.rise_pa
        )
    state.enthalpy_j += heat_j
    state.cycles += 0.5 * abs(after.martensite - state.martensite_fraction)
    if abs(heat_j) > NO_HEAT_J:
        state.resistance_slope_ohm_per_j = (after.resistance_ohm - state.resistance_ohm) / heat_j
    state.last_heat_j = heat_j
    state.temperature_slope_k_per_j = found.temperature_slope_k_per_j
    state.stress_slope_pa_per_j = found.stress_slope_pa_per_j
    state.contraction_slope_per_j = found.contraction_slope_per_j
    state.temperature_k = after.temperature_k
    state.martensite_fraction = after.martensite
    state.r_phase_fraction = after.r_phase
    state.resistance_ohm = after.resistance_ohm
    state.stress_pa = after.stress_pa
    state.contraction = after.contraction
    state.evaluations += found.evaluations
    if not found.solved:
        state.unsolved_steps += 1.0
    state.connector_contraction, state.friction_n = connector_after(wire, found, push)


@compiled_inline
def connector_after(wire: RunningWire, found: Equilibrium, push: ConnectorForce) -> tuple[float, float]:
    """Return the connector's contraction and the friction [N] of a solution that the wire has not moved to yet."""
    after = found.wire
    if after.stress_pa > 0.0 or after.contraction >= wire.state.connector_contraction:
        return after.contraction, after.friction_n
    return slid_connector(wire, after.contraction, push)


@compiled_inner
def slid_connector(wire: RunningWire, contraction: float, push: ConnectorForce) -> tuple[float, float]:
    """Return how far a slack wire's connector follows it against the friction (without any: all), and that [N]."""
    state, k = wire.state, wire.constants
    before = (state.connector_contraction, state.friction_n)
    low, high = contraction, state.connector_contraction
    at_wire = load_at(k, wire.load, low, before, push)
    if at_wire.limit_n <= 0.0 or at_wire.force_n >= 0.0:
        return low, at_wire.friction_n
    if load_at(k, wire.load, high, before, push).force_n <= HELD_N:
        return before
    for _ in range(100):
        middle = 0.5 * (low + high)
        if load_at(k, wire.load, middle, before, push).force_n < 0.0:
            low = middle
        else:
            high = middle
        if middle in (low, high) and high - low <= 1e-15:
            break
    return high, load_at(k, wire.load, high, before, push).friction_n
