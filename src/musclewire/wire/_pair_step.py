"""One step of two coupled wires, compiled: their circuit, what both are expected to become, and both solved together.

The order and the bookkeeping of heat are those of a single wire (``wire/_wires.py``).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled_inline
from musclewire.wire._balance import ConnectorForce, convection_w_per_m2_k, loss_w
from musclewire.wire._constants import StepConstants
from musclewire.wire._coupling import (
    APART,
    BalanceGuess,
    CoupledBalance,
    GrippedObject,
    balance_connector,
    hold_object,
)
from musclewire.wire._fronts import shakedown_of
from musclewire.wire._state import WireState
from musclewire.wire._step import NO_HEAT_J, Equilibrium, RunningWire, accept, guess_after, middle_of_step
from musclewire.wire._stepping import RESISTANCE, STRAIN, TEMPERATURE, StepAttempt, WireInstant, error_ratio, owed_j

__all__ = [
    "OWN_SUPPLY",
    "PARALLEL",
    "SERIES",
    "RunningPair",
    "HeatDirection",
    "PairConnection",
    "PairAttempt",
    "PairInstant",
    "PairSetting",
    "attempt_both",
    "course_of",
    "error_ratio_of_both",
    "instant_of_both",
    "present",
    "remember",
    "accept_pair_step",
]

# Supply of the second wire: its own one, in parallel with the first wire, or in series with it.
OWN_SUPPLY, PARALLEL, SERIES = 0, 1, 2


class PairConnection(NamedTuple):
    """What joins two wires.

    Parameters
    ----------
    direction
        Which way the second wire pulls the connector of the first: 1 in its direction, -1 against it; 0 if each has a
        connector of its own.
    feed
        How the second wire gets its current: ``OWN_SUPPLY``, ``PARALLEL`` or ``SERIES``.
    partner_voltage_v
        Voltage of the second wire's own supply [V]; not used by the other two feeds.
    partner_series_ohm
        Resistance in series with the second wire at its own supply [ohm].
    """

    direction: float
    feed: int
    partner_voltage_v: float
    partner_series_ohm: float


class RunningPair(NamedTuple):
    """Two wires in compiled code."""

    first: RunningWire
    second: RunningWire


class PairSetting(NamedTuple):
    """What does not change during a sample: the drive [V], what joins the wires, and the object between them."""

    drive_voltage_v: float
    pair: PairConnection
    grip: GrippedObject


class PairInstant(NamedTuple):
    """Both wires at one moment: each in circuit and air, voltage across the terminals [V], current of the shunt [A]."""

    first: WireInstant
    second: WireInstant
    terminals_v: float
    shunt_a: float


class HeatDirection(NamedTuple):
    """Direction of a pair's last step: the heat of each wire over that of both, as a vector of length 1.

    Where wires are joined each feels the other's heat. Slopes over the pair's heat along that direction are what both
    remember, and the rest of the heat only warms a wire.

    Parameters
    ----------
    joined
        Whether the wires feel each other; otherwise their slopes are over their own heat, as a single wire's.
    own, other
        Components of the direction; both 0 before the first step.
    """

    joined: bool
    own: float
    other: float


class PredictedWire(NamedTuple):
    """A wire as it is, or as it is expected after some heat: temperature, resistance, stress, its connector's place."""

    temperature_k: float
    resistance_ohm: float
    stress_pa: float
    contraction: float


class PairAttempt(NamedTuple):
    """A step of a pair that was tried: of each wire, of what joins them, and both in the circuit at its end."""

    first: StepAttempt
    second: StepAttempt
    joint: CoupledBalance
    ended: PairInstant


@compiled_inline
def currents_a(
    first_ohm: float, second_ohm: float, series_ohm: float, drive_voltage_v: float, pair: PairConnection
) -> tuple[float, float, float, float]:
    """Return the currents of both wires [A], the voltage across the terminals and the current through the shunt."""
    if pair.feed == SERIES:
        current = drive_voltage_v / (first_ohm + second_ohm + series_ohm)
        return current, current, current * (first_ohm + second_ohm), current
    if pair.feed == PARALLEL:
        together = first_ohm * second_ohm / (first_ohm + second_ohm)
        current = drive_voltage_v / (together + series_ohm)
        voltage = current * together
        return voltage / first_ohm, voltage / second_ohm, voltage, current
    current = drive_voltage_v / (first_ohm + series_ohm)
    partner = pair.partner_voltage_v / (second_ohm + pair.partner_series_ohm)
    return current, partner, current * first_ohm, current


@compiled_inline
def heat_loss_w(constants: StepConstants, temperature_k: float) -> float:
    """Return the heat that a wire loses to the air at a temperature [W]."""
    return loss_w(constants, convection_w_per_m2_k(constants, constants, temperature_k), temperature_k)


@compiled_inline
def instant_of_both(
    wires: RunningPair, setting: PairSetting, first: PredictedWire, second: PredictedWire
) -> PairInstant:
    """Return both wires in their circuit and in the air; shunt and leads are the first one's."""
    one, two = wires.first.constants, wires.second.constants
    own_ohm, other_ohm = first.resistance_ohm, second.resistance_ohm
    current, partner, voltage, through = currents_a(
        own_ohm, other_ohm, one.series_resistance_ohm, setting.drive_voltage_v, setting.pair
    )
    return PairInstant(
        WireInstant(current, current * current * own_ohm, heat_loss_w(one, first.temperature_k)),
        WireInstant(partner, partner * partner * other_ohm, heat_loss_w(two, second.temperature_k)),
        voltage,
        through,
    )


@compiled_inline
def present(state: WireState) -> PredictedWire:
    """Return a wire as it is."""
    return PredictedWire(state.temperature_k, state.resistance_ohm, state.stress_pa, state.connector_contraction)


@compiled_inline
def course_of(first: WireState, second: WireState, joined: bool) -> HeatDirection:
    """Return the direction of the last step of a pair."""
    together_j = math.hypot(first.last_heat_j, second.last_heat_j)
    if not joined or together_j == 0.0:
        return HeatDirection(joined, 0.0, 0.0)
    return HeatDirection(joined, first.last_heat_j / together_j, second.last_heat_j / together_j)


@compiled_inline
def along(course: HeatDirection, heat_j: float, other_j: float) -> float:
    """Return the part of a pair's heat along its course [J]; 0 after a turn, when no phase changes at first."""
    return max(course.own * heat_j + course.other * other_j, 0.0)


@compiled_inline
def ahead(
    state: WireState, constants: StepConstants, joined: bool, heat_j: float, half_j: float, along_j: float, unit: float
) -> PredictedWire:
    """Return a wire after some heat, by the slopes of the last step.

    ``half_j`` is half of the step's heat at the rate of its start, ``along_j`` the part of the pair's heat along its
    course, and ``unit`` this wire's component of the course.
    """
    if not joined:
        middle = middle_of_step(state, constants, half_j)
        temperature_k, stress_pa = guess_after(state, middle, heat_j)
        return PredictedWire(temperature_k, middle.resistance_ohm, stress_pa, state.connector_contraction)
    warming_k = constants.per_capacity_k_per_j * (heat_j - along_j * unit)
    return PredictedWire(
        state.temperature_k + state.temperature_slope_k_per_j * along_j + warming_k,
        state.resistance_ohm + state.resistance_slope_ohm_per_j * along_j,
        max(state.stress_pa + state.stress_slope_pa_per_j * along_j, 0.0),
        state.connector_contraction + state.contraction_slope_per_j * along_j,
    )


@compiled_inline
def ahead_of_both(
    wires: RunningPair, course: HeatDirection, heats_j: tuple[float, float], halves_j: tuple[float, float]
) -> tuple[PredictedWire, PredictedWire]:
    """Return both wires after some heat, by the slopes of the last step."""
    one, two = wires
    along_j = along(course, heats_j[0], heats_j[1])
    return (
        ahead(one.state, one.constants, course.joined, heats_j[0], halves_j[0], along_j, course.own),
        ahead(two.state, two.constants, course.joined, heats_j[1], halves_j[1], along_j, course.other),
    )


@compiled_inline
def start_of(state: WireState, constants: StepConstants, heat_j: float, expected: PredictedWire) -> BalanceGuess:
    """Return where the solution of a wire begins."""
    shakedown = shakedown_of(constants, state.cycles)
    enthalpy_j = state.enthalpy_j + heat_j
    return BalanceGuess(shakedown, enthalpy_j, expected.temperature_k, expected.stress_pa, expected.contraction)


@compiled_inline
def net_w(instant: WireInstant) -> float:
    """Return the rate at which a wire gains heat [W]."""
    return instant.power_w - instant.loss_w


@compiled_inline
def tried_of(
    wire: RunningWire,
    found: Equilibrium,
    instants: tuple[WireInstant, WireInstant, WireInstant],
    half_j: float,
    heat_j: float,
    step_s: float,
    joined: bool,
) -> StepAttempt:
    """Return the attempt of one wire from start, middle and end of the step, as that of a single wire is made."""
    began, within, ended = instants
    state, k = wire.state, wire.constants
    owes_j = owed_j(began, within, ended, step_s)
    turned = joined or half_j * state.last_heat_j < 0.0
    before = k.per_capacity_k_per_j if turned else state.temperature_slope_k_per_j
    return StepAttempt(found, within, ended, heat_j, owes_j, abs(owes_j) * max(found.temperature_slope_k_per_j, before))


@compiled_inline
def attempt_both(
    wires: RunningPair, setting: PairSetting, course: HeatDirection, began: PairInstant, grip_n: float, step_s: float
) -> PairAttempt:
    """Return a step of both wires, which do not move yet: the method of a single wire, with both solved at once.

    ``grip_n`` is the force on the object [N] at the start.
    """
    first, second = wires
    halves_j = (0.5 * step_s * net_w(began.first), 0.5 * step_s * net_w(began.second))
    middle, other_middle = ahead_of_both(wires, course, halves_j, halves_j)
    within = instant_of_both(wires, setting, middle, other_middle)
    heat_j = net_w(within.first) * step_s + first.state.carried_heat_j
    other_j = net_w(within.second) * step_s + second.state.carried_heat_j
    expected, other_expected = ahead_of_both(wires, course, (heat_j, other_j), halves_j)
    start = start_of(first.state, first.constants, heat_j, expected)
    other_start = start_of(second.state, second.constants, other_j, other_expected)
    if setting.pair.direction != APART:
        joint = balance_connector(first, second, setting.pair.direction, start, other_start)
    else:
        joint = hold_object(first, second, setting.grip, grip_n, start, other_start)
    ended = instant_of_both(wires, setting, settled_ahead(joint.first), settled_ahead(joint.second))
    instants = (began.first, within.first, ended.first)
    others = (began.second, within.second, ended.second)
    return PairAttempt(
        tried_of(first, joint.first, instants, halves_j[0], heat_j, step_s, course.joined),
        tried_of(second, joint.second, others, halves_j[1], other_j, step_s, course.joined),
        joint,
        ended,
    )


@compiled_inline
def settled_ahead(found: Equilibrium) -> PredictedWire:
    """Return a wire as it is in a solution."""
    after = found.wire
    return PredictedWire(after.temperature_k, after.resistance_ohm, after.stress_pa, after.contraction)


@compiled_inline
def accept_coupled_step(
    wire: RunningWire, tried: StepAttempt, push: ConnectorForce, began: WireInstant, step_s: float
) -> None:
    """Move a wire by a step that was tried, in place."""
    state = wire.state
    accept(wire, tried.found, tried.heat_j, push)
    state.carried_heat_j = tried.owed_j
    state.heat_in_j += 0.5 * (began.power_w + tried.ended.power_w) * step_s
    state.heat_out_j += 0.5 * (began.loss_w + tried.ended.loss_w) * step_s
    state.step_error_k = max(state.step_error_k, tried.error_k)


@compiled_inline
def accept_pair_step(
    wires: RunningPair, setting: PairSetting, tried: PairAttempt, began: PairInstant, step_s: float
) -> None:
    """Move both wires by a step that was tried, in place."""
    first, second = wires
    one, two, joint = first.state, second.state, tried.joint
    direction = setting.pair.direction
    if direction != APART:  # the common connector, set below, does not follow a single slack wire
        one.connector_contraction, two.connector_contraction = -math.inf, -math.inf
    accept_coupled_step(first, tried.first, joint.push, began.first, step_s)
    accept_coupled_step(second, tried.second, joint.other_push, began.second, step_s)
    if direction != APART:
        lengths = first.constants.leg_length_m / second.constants.leg_length_m
        one.connector_contraction, one.friction_n = joint.contraction, joint.friction_n
        two.connector_contraction, two.friction_n = direction * joint.contraction * lengths, 0.0
    one.evaluations += joint.earlier[0]
    two.evaluations += joint.earlier[1]
    if not joint.solved and tried.first.found.solved and tried.second.found.solved:
        one.unsolved_steps += 1.0
        two.unsolved_steps += 1.0


@compiled_inline
def remember(state: WireState, before: PredictedWire, together_j: float) -> None:
    """Set the slopes of a joined wire to those of its last step over the heat of the pair, in place."""
    if together_j > NO_HEAT_J:
        per_j = 1.0 / together_j
        state.temperature_slope_k_per_j = (state.temperature_k - before.temperature_k) * per_j
        state.stress_slope_pa_per_j = (state.stress_pa - before.stress_pa) * per_j
        state.contraction_slope_per_j = (state.connector_contraction - before.contraction) * per_j
        state.resistance_slope_ohm_per_j = (state.resistance_ohm - before.resistance_ohm) * per_j


@compiled_inline
def joined_error_ratio(
    state: WireState,
    tried: StepAttempt,
    rates_w: tuple[float, float],
    together_j: tuple[float, float],
    step_and_plan: tuple[float, FloatArray],
) -> float:
    """Return the largest error of a joined wire's step over its tolerance, as ``error_ratio`` of a single wire."""
    step_s, plan = step_and_plan
    before_w, after_w = rates_w
    heat_j, owing_j = together_j
    per_j = 1.0 / heat_j if heat_j > NO_HEAT_J else 0.0
    after = tried.found.wire
    resistance_slope = (after.resistance_ohm - state.resistance_ohm) * per_j
    slope = (after.contraction - state.contraction) * per_j
    bend_ohm = abs(state.resistance_slope_ohm_per_j * before_w - resistance_slope * after_w)
    bend = abs(state.contraction_slope_per_j * before_w - slope * after_w)
    mean = step_s / 12.0
    resistance_ohm = max(abs(owing_j * resistance_slope), bend_ohm * mean)
    strain = max(abs(owing_j * slope), bend * mean)
    return max(
        tried.error_k / plan[TEMPERATURE],
        max(resistance_ohm / (plan[RESISTANCE] * state.resistance_ohm), strain / plan[STRAIN]),
    )


@compiled_inline
def error_ratio_of_both(
    wires: RunningPair, course: HeatDirection, tried: PairAttempt, began: PairInstant, step_s: float, plan: FloatArray
) -> float:
    """Return the largest error of a step of both wires over its tolerance."""
    one, two = wires.first.state, wires.second.state
    first, second = tried.first, tried.second
    if not course.joined:
        return max(
            error_ratio(one, first, began.first, step_s, plan), error_ratio(two, second, began.second, step_s, plan)
        )
    heat_j, owing_j = math.hypot(first.heat_j, second.heat_j), math.hypot(first.owed_j, second.owed_j)
    before_w = along(course, net_w(began.first), net_w(began.second))
    after_w = 0.0
    if heat_j > 0.0:
        after_w = (first.heat_j * net_w(tried.ended.first) + second.heat_j * net_w(tried.ended.second)) / heat_j
    rates_w, together_j, step_and_plan = (before_w, after_w), (heat_j, owing_j), (step_s, plan)
    return max(
        joined_error_ratio(one, first, rates_w, together_j, step_and_plan),
        joined_error_ratio(two, second, rates_w, together_j, step_and_plan),
    )
