"""Two coupled wires: pulling together or against each other, or each on its finger with an object between them.

Each wire has its own heat, phases and history, by the same functions as a single wire. The two are coupled by a circuit
and a connector, or by an object that both fingers touch; ``_coupling.py`` solves for both at once.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inline
from musclewire.extras.grip._coupling import (
    SEPARATE,
    BalanceGuess,
    CoupledBalance,
    GrippedObject,
    balance_connector,
    grip_force_n,
    hold_object,
)
from musclewire.wire import (
    CHOSEN,
    DURATION,
    MIN_STEP_S,
    STEPS,
    ConnectorForce,
    Equilibrium,
    Rows,
    RunningWire,
    StepAttempt,
    StepConstants,
    StepControl,
    WireConstants,
    WireInstant,
    WireState,
    accept,
    convection_w_per_m2_k,
    error_ratio,
    guess_after,
    longest_step_s,
    loss_w,
    middle_of_step,
    next_step_s,
    owed_j,
    plan_of,
    rises_over,
    shakedown_of,
    shorter_step_s,
)

# Supply of the second wire, as compiled code compares it:
OWN_SUPPLY = 0
PARALLEL = 1  # with the first wire
SERIES = 2  # with the first wire


class PairConnection(NamedTuple):
    """What joins two wires."""

    direction: float  # in which the second wire pulls the connector of the first, -1 against it; 0 if each has its own
    feed: int  # how the second wire gets its current: OWN_SUPPLY, PARALLEL or SERIES
    second_voltage_v: float  # of the second wire's own supply; not used by the other two feeds
    second_series_ohm: float  # in series with the second wire at its own supply


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
    first_a = drive_voltage_v / (first_ohm + series_ohm)
    second_a = pair.second_voltage_v / (second_ohm + pair.second_series_ohm)
    return first_a, second_a, first_a * first_ohm, first_a


@compiled_inline
def wire_instant(constants: StepConstants, wire: PredictedWire, current_a: float) -> WireInstant:
    """Return a wire at a current, with the heat that the current gives it and the air takes from it."""
    convection = convection_w_per_m2_k(constants, constants, wire.temperature_k)
    power_w = current_a * current_a * wire.resistance_ohm
    return WireInstant(current_a, power_w, loss_w(constants, convection, wire.temperature_k))


@compiled_inline
def instant_of_both(
    wires: RunningPair, setting: PairSetting, first: PredictedWire, second: PredictedWire
) -> PairInstant:
    """Return both wires in their circuit and in the air; shunt and leads are the first one's."""
    series_ohm = wires.first.constants.series_resistance_ohm
    first_a, second_a, terminals_v, shunt_a = currents_a(
        first.resistance_ohm, second.resistance_ohm, series_ohm, setting.drive_voltage_v, setting.pair
    )
    return PairInstant(
        wire_instant(wires.first.constants, first, first_a),
        wire_instant(wires.second.constants, second, second_a),
        terminals_v,
        shunt_a,
    )


@compiled_inline
def present_wire(state: WireState) -> PredictedWire:
    """Return a wire as it is."""
    return PredictedWire(state.temperature_k, state.resistance_ohm, state.stress_pa, state.connector_contraction)


@compiled_inline
def wire_ahead(state: WireState, constants: StepConstants, half_j: float, heat_j: float) -> PredictedWire:
    """Return a wire after some heat, by the slopes of the last step; ``half_j`` is half of the heat at its start."""
    middle = middle_of_step(state, constants, half_j)
    temperature_k, stress_pa = guess_after(state, middle, heat_j)
    moved = 0.0 if half_j * state.last_heat_j < 0.0 else state.contraction_slope_per_j * heat_j
    return PredictedWire(temperature_k, middle.resistance_ohm, stress_pa, state.connector_contraction + moved)


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
def attempt_of_one(
    wire: RunningWire,
    found: Equilibrium,
    instants: tuple[WireInstant, WireInstant, WireInstant],
    half_j: float,
    heat_j: float,
    step_s: float,
    joined: bool,
) -> StepAttempt:
    """Return the attempt of one wire; slopes are over the whole step, as they contain how the other wire moved."""
    began, within, ended = instants
    state, k = wire.state, wire.constants
    owes_j = owed_j(began, within, ended, step_s)
    turned = joined or half_j * state.last_heat_j < 0.0
    before = k.per_capacity_k_per_j if turned else state.temperature_slope_k_per_j
    error_k = abs(owes_j) * max(found.temperature_slope_k_per_j, before)
    if joined:
        slopes = rises_over(k, state, found.wire, heat_j)
        found = Equilibrium(
            wire=found.wire,
            temperature_slope_k_per_j=slopes.temperature_k_per_j,
            stress_slope_pa_per_j=slopes.stress_pa_per_j,
            contraction_slope_per_j=slopes.contraction_per_j,
            stress_per_contraction_pa=found.stress_per_contraction_pa,
            evaluations=found.evaluations,
            solved=found.solved,
        )
    return StepAttempt(found, within, ended, heat_j, owes_j, error_k)


@compiled_inline
def attempt_both(
    wires: RunningPair, setting: PairSetting, joined: bool, began: PairInstant, grip_n: float, step_s: float
) -> PairAttempt:
    """Return a step of both wires, solved at once as one is, which do not move yet; ``grip_n`` is that at the start."""
    first, second = wires
    first_half_j, second_half_j = 0.5 * step_s * net_w(began.first), 0.5 * step_s * net_w(began.second)
    first_middle = wire_ahead(first.state, first.constants, first_half_j, first_half_j)
    second_middle = wire_ahead(second.state, second.constants, second_half_j, second_half_j)
    within = instant_of_both(wires, setting, first_middle, second_middle)
    first_j = net_w(within.first) * step_s + first.state.carried_heat_j
    second_j = net_w(within.second) * step_s + second.state.carried_heat_j
    first_end = wire_ahead(first.state, first.constants, first_half_j, first_j)
    second_end = wire_ahead(second.state, second.constants, second_half_j, second_j)
    first_start = start_of(first.state, first.constants, first_j, first_end)
    second_start = start_of(second.state, second.constants, second_j, second_end)
    if setting.pair.direction != SEPARATE:
        joint = balance_connector(first, second, setting.pair.direction, first_start, second_start)
    else:
        joint = hold_object(first, second, setting.grip, grip_n, first_start, second_start)
    ended = instant_of_both(wires, setting, settled_ahead(joint.first), settled_ahead(joint.second))
    of_first = (began.first, within.first, ended.first)
    of_second = (began.second, within.second, ended.second)
    return PairAttempt(
        attempt_of_one(first, joint.first, of_first, first_half_j, first_j, step_s, joined),
        attempt_of_one(second, joint.second, of_second, second_half_j, second_j, step_s, joined),
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
    wire: RunningWire, tried: StepAttempt, push: ConnectorForce, began: WireInstant, step_s: float, joined: bool
) -> None:
    """Move a wire by a step that was tried, in place."""
    state = wire.state
    slopes = rises_over(wire.constants, state, tried.found.wire, tried.heat_j)
    accept(wire, tried.found, tried.heat_j, push)
    if joined:
        state.resistance_slope_ohm_per_j = slopes.resistance_ohm_per_j
    state.carried_heat_j = tried.owed_j
    state.heat_in_j += 0.5 * (began.power_w + tried.ended.power_w) * step_s
    state.heat_out_j += 0.5 * (began.loss_w + tried.ended.loss_w) * step_s
    state.step_error_k = max(state.step_error_k, tried.error_k)


@compiled_inline
def accept_pair_step(
    wires: RunningPair,
    setting: PairSetting,
    tried: PairAttempt,
    began: PairInstant,
    step_s: float,
    joined: bool,
) -> None:
    """Move both wires by a step that was tried, in place."""
    first, second = wires
    joint = tried.joint
    direction = setting.pair.direction
    if direction != SEPARATE:  # the common connector, set below, does not follow a single slack wire
        first.state.connector_contraction, second.state.connector_contraction = -math.inf, -math.inf
    accept_coupled_step(first, tried.first, joint.push, began.first, step_s, joined)
    accept_coupled_step(second, tried.second, joint.second_push, began.second, step_s, joined)
    if direction != SEPARATE:
        lengths = first.constants.leg_length_m / second.constants.leg_length_m
        first.state.connector_contraction, first.state.friction_n = joint.contraction, joint.friction_n
        second.state.connector_contraction = direction * joint.contraction * lengths
        second.state.friction_n = 0.0
    first.state.evaluations += joint.earlier[0]
    second.state.evaluations += joint.earlier[1]
    if not joint.solved and tried.first.found.solved and tried.second.found.solved:
        first.state.unsolved_steps += 1.0
        second.state.unsolved_steps += 1.0


@compiled_inline
def error_ratio_of_both(
    wires: RunningPair, tried: PairAttempt, began: PairInstant, step_s: float, plan: FloatArray
) -> float:
    """Return the largest error of a step of both wires over its tolerance."""
    first, second = wires.first.state, wires.second.state
    return max(
        error_ratio(first, tried.first, began.first, step_s, plan),
        error_ratio(second, tried.second, began.second, step_s, plan),
    )


class PairMeans(NamedTuple):
    """Means over one call: of the circuit's terminals and shunt, of both connectors and wires, and of the object."""

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float
    force_n: float
    second_displacement_m: float
    second_force_n: float
    grip_n: float


class AveragedQuantities(NamedTuple):
    """What is averaged over a sample, at one moment: of the circuit, of both connectors and wires, of the object."""

    terminals_v: float
    shunt_a: float
    displacement_m: float
    stress_pa: float
    second_displacement_m: float
    second_stress_pa: float
    grip_n: float


@compiled_inline
def shown(wires: RunningPair, setting: PairSetting, instant: PairInstant) -> AveragedQuantities:
    """Return what instruments would see at a moment."""
    first, second = wires.first.state, wires.second.state
    first_m = first.connector_contraction * wires.first.constants.leg_length_m
    second_m = second.connector_contraction * wires.second.constants.leg_length_m
    grip_n = 0.0
    if setting.pair.direction != SEPARATE:
        second_m = setting.pair.direction * first_m
    elif setting.grip.stiffness_n_per_m > 0.0:
        grip_n = grip_force_n(setting.grip, first_m, second_m)
    return AveragedQuantities(
        instant.terminals_v, instant.shunt_a, first_m, first.stress_pa, second_m, second.stress_pa, grip_n
    )


@compiled_inline
def add_both(sums: FloatArray, step_s: float, before: AveragedQuantities, after: AveragedQuantities) -> None:
    """Add a step to the sums of all means by the trapezoidal rule, in place."""
    sums[0] += step_s * (before.terminals_v + after.terminals_v)
    sums[1] += step_s * (before.shunt_a + after.shunt_a)
    sums[2] += step_s * (before.displacement_m + after.displacement_m)
    sums[3] += step_s * (before.stress_pa + after.stress_pa)
    sums[4] += step_s * (before.second_displacement_m + after.second_displacement_m)
    sums[5] += step_s * (before.second_stress_pa + after.second_stress_pa)
    sums[6] += step_s * (before.grip_n + after.grip_n)


@compiled_inline
def advance_both(wires: RunningPair, setting: PairSetting, plan: FloatArray, sums: FloatArray) -> None:
    """Advance both wires in place by a duration, and add up what is averaged over it, (7,)."""
    first, second = wires.first.state, wires.second.state
    began = instant_of_both(wires, setting, present_wire(first), present_wire(second))
    seen = shown(wires, setting, began)
    fixed = plan[STEPS] > 0.0
    left_s = duration_s = plan[DURATION]
    step_s = duration_s / plan[STEPS] if fixed else longest_step_s(first, duration_s)
    steps_left = int(plan[STEPS])
    while steps_left > 0 if fixed else left_s > 0.0:
        if not fixed:  # equal steps over what is left, none longer than the tolerance asks for
            step_s = left_s / math.ceil(left_s / step_s * (1.0 - 1e-9))
        joined = setting.pair.direction != SEPARATE or seen.grip_n > 0.0
        tried = attempt_both(wires, setting, joined, began, seen.grip_n, step_s)
        if not fixed:
            ratio = error_ratio_of_both(wires, tried, began, step_s, plan)
            if ratio > 1.0 and step_s > MIN_STEP_S:
                step_s = shorter_step_s(step_s, ratio)
                continue
            first.step_s = second.step_s = next_step_s(step_s, ratio)
        accept_pair_step(wires, setting, tried, began, step_s, joined)
        after = shown(wires, setting, tried.ended)
        add_both(sums, step_s, seen, after)
        began, seen = tried.ended, after
        left_s -= step_s
        steps_left -= 1
        step_s = step_s if fixed else first.step_s
    # Adding up time step by step would accumulate rounding errors; both wires have the first one's clock.
    first.time_s += duration_s
    second.time_s = first.time_s


@compiled
def advance_pair_rows(
    states: tuple[Rows, Rows],
    parts: tuple[Any, Any],
    pair_values: tuple[Any, ...],
    grip_values: tuple[Any, ...],
    drive_voltage_v: float,
    plan: FloatArray,
    sums: FloatArray,
) -> None:
    """Advance two wires in place, each (1,), by their ``step_arrays``; fill in the pair's means, (7,)."""
    first, second = parts
    wires = RunningPair(
        RunningWire(states[0][0], first[0][0], first[1][0], first[2][0]),
        RunningWire(states[1][0], second[0][0], second[1][0], second[2][0]),
    )
    sums[:] = 0.0
    advance_both(
        wires, PairSetting(drive_voltage_v, PairConnection(*pair_values), GrippedObject(*grip_values)), plan, sums
    )
    sums *= 0.5 / plan[DURATION]
    sums[1] *= wires.first.constants.shunt_resistance_ohm
    sums[3] *= wires.first.constants.section_m2
    sums[5] *= wires.second.constants.section_m2


def advance_pair(
    states: tuple[WireState, WireState],
    constants: tuple[WireConstants, WireConstants],
    pair: PairConnection,
    grip: GrippedObject,
    drive_voltage_v: float,
    duration_s: float,
    stepping: StepControl = CHOSEN,
) -> tuple[tuple[WireState, WireState], PairMeans]:
    """Return both wires after a time at one drive voltage, and the means over that time.

    Shunt and leads are the first wire's. On a common connector the load is the first one's, and of the second one's
    only its pretension counts. Energy of each wire is kept to rounding.
    """
    plan = plan_of(stepping, duration_s)
    after = (states[0].copy(), states[1].copy())
    means = np.empty(7)
    # As for one wire, arrays and plain tuples cross into compiled code, and plain numbers come back.
    advance_pair_rows(
        (after[0].row, after[1].row),
        (constants[0].step_arrays(), constants[1].step_arrays()),
        tuple(pair),
        tuple(grip),
        drive_voltage_v,
        plan,
        means,
    )
    return after, PairMeans(*means.tolist())
