"""Two coupled wires: pulling together or against each other, or each on its finger with an object between them.

Each wire has its own heat, phases and history, by the same functions as a single wire. The two are coupled by a circuit
and a connector, or by an object that both fingers touch; ``wire/_coupling.py`` solves for both at once.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inline
from musclewire.wire._constants import WireConstants
from musclewire.wire._coupling import APART, GrippedObject, grip_force_n
from musclewire.wire._pair_step import (
    PairConnection,
    PairInstant,
    PairSetting,
    RunningPair,
    accept_pair_step,
    attempt_both,
    error_ratio_of_both,
    instant_of_both,
    present,
)
from musclewire.wire._row import Rows
from musclewire.wire._state import WireState
from musclewire.wire._step import RunningWire
from musclewire.wire._stepping import (
    CHOSEN,
    DURATION,
    MIN_STEP_S,
    STEPS,
    StepControl,
    longest_step_s,
    next_step_s,
    plan_of,
    shorter_step_s,
)


class PairMeans(NamedTuple):
    """Means over one call of :func:`advance_pair`.

    Parameters
    ----------
    wire_voltage_v
        Voltage across the terminals of the circuit [V]: of the first wire, or of both in series or in parallel.
    shunt_voltage_v
        Voltage of the shunt [V].
    displacement_m
        Displacement of the first wire's connector [m].
    force_n
        Force of the first wire [N].
    partner_displacement_m
        Displacement of the second wire's connector [m], the way that it pulls.
    partner_force_n
        Force of the second wire [N].
    grip_n
        Force between each endpoint and the object [N]; 0 without one.
    """

    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float
    force_n: float
    partner_displacement_m: float
    partner_force_n: float
    grip_n: float


class AveragedQuantities(NamedTuple):
    """What is averaged over a sample, at one moment: of the circuit, of both connectors and wires, of the object."""

    terminals_v: float
    shunt_a: float
    displacement_m: float
    stress_pa: float
    other_displacement_m: float
    other_stress_pa: float
    grip_n: float


@compiled_inline
def shown(wires: RunningPair, setting: PairSetting, instant: PairInstant) -> AveragedQuantities:
    """Return what instruments would see at a moment."""
    one, two = wires.first.state, wires.second.state
    x_m = one.connector_contraction * wires.first.constants.leg_length_m
    y_m = two.connector_contraction * wires.second.constants.leg_length_m
    grip_n = 0.0
    if setting.pair.direction != APART:
        y_m = setting.pair.direction * x_m
    elif setting.grip.stiffness_n_per_m > 0.0:
        grip_n = grip_force_n(setting.grip, x_m, y_m)
    return AveragedQuantities(instant.terminals_v, instant.shunt_a, x_m, one.stress_pa, y_m, two.stress_pa, grip_n)


@compiled_inline
def add_both(sums: FloatArray, step_s: float, before: AveragedQuantities, after: AveragedQuantities) -> None:
    """Add a step to the sums of all means by the trapezoidal rule, in place."""
    sums[0] += step_s * (before.terminals_v + after.terminals_v)
    sums[1] += step_s * (before.shunt_a + after.shunt_a)
    sums[2] += step_s * (before.displacement_m + after.displacement_m)
    sums[3] += step_s * (before.stress_pa + after.stress_pa)
    sums[4] += step_s * (before.other_displacement_m + after.other_displacement_m)
    sums[5] += step_s * (before.other_stress_pa + after.other_stress_pa)
    sums[6] += step_s * (before.grip_n + after.grip_n)


@compiled_inline
def advance_both(wires: RunningPair, setting: PairSetting, plan: FloatArray, sums: FloatArray) -> None:
    """Advance both wires in place by a duration, and add up what is averaged over it, (7,)."""
    one, two = wires.first.state, wires.second.state
    began = instant_of_both(wires, setting, present(one), present(two))
    seen = shown(wires, setting, began)
    fixed = plan[STEPS] > 0.0
    left_s = duration_s = plan[DURATION]
    step_s = duration_s / plan[STEPS] if fixed else longest_step_s(one, duration_s)
    steps_left = int(plan[STEPS])
    while steps_left > 0 if fixed else left_s > 0.0:
        if not fixed:  # equal steps over what is left, none longer than the tolerance asks for
            step_s = left_s / math.ceil(left_s / step_s * (1.0 - 1e-9))
        joined = setting.pair.direction != APART or seen.grip_n > 0.0
        tried = attempt_both(wires, setting, joined, began, seen.grip_n, step_s)
        if not fixed:
            ratio = error_ratio_of_both(wires, tried, began, step_s, plan)
            if ratio > 1.0 and step_s > MIN_STEP_S:
                step_s = shorter_step_s(step_s, ratio)
                continue
            one.step_s = two.step_s = next_step_s(step_s, ratio)
        accept_pair_step(wires, setting, tried, began, step_s, joined)
        after = shown(wires, setting, tried.ended)
        add_both(sums, step_s, seen, after)
        began, seen = tried.ended, after
        left_s -= step_s
        steps_left -= 1
        step_s = step_s if fixed else one.step_s
    # Adding up time step by step would accumulate rounding errors; both wires have the first one's clock.
    one.time_s += duration_s
    two.time_s = one.time_s


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
    """Advance two wires in place, each an array of one record, (1,); fill in the means of :func:`advance_pair`, (7,).

    ``parts`` are the ``step_arrays`` of both wires' constants.
    """
    one, two = parts
    wires = RunningPair(
        RunningWire(states[0][0], one[0][0], one[1][0], one[2][0]),
        RunningWire(states[1][0], two[0][0], two[1][0], two[2][0]),
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

    The states passed in are not changed. The circuit's shunt and leads are the first wire's. Energy of each wire is
    kept to rounding, as for one wire.

    Parameters
    ----------
    states
        State of the first and of the second wire.
    constants
        Constants of both; the load in them is that of each wire's own finger. On a common connector the load is the
        first one's, and of the second one's only its pretension counts.
    pair
        How the wires are joined.
    grip
        The object between two fingers; ``no_grip()`` without one.
    drive_voltage_v
        Drive voltage of the first wire's circuit [V], the same all the time.
    duration_s
        The time [s].
    stepping
        How it is divided into steps, the same for both wires; by default as the tolerances ask for either of them.

    Returns
    -------
    Both states at the end, and the means.

    Raises
    ------
    CallerError
        For a duration that is not positive or that fixed steps do not divide.
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
