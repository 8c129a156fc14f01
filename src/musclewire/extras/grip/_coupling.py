"""Two wires in equilibrium with each other: on one connector, or with an object between their fingers; compiled.

Either way one number couples them, the displacement of the connector or the force on the object, and it is found by
Newton's method in a bracket. Each wire's temperature and stress are solved together at each trial of that number.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled_inline, compiled_inner
from musclewire.wire import (
    NO_PUSH,
    ConnectorForce,
    Equilibrium,
    RunningWire,
    ShakedownEffects,
    connector_after,
    load_at,
    solve,
)

# Direction of a second wire that has a connector of its own.
SEPARATE = 0.0
# Connector and endpoint are found to within this: a wire's force changes by about 1e-9 N over it.
CLOSE_M = 1e-13
# A force on the object, or a push on a finger, is found to within this.
CLOSE_N = 1e-10
# A wire is held at a trial displacement by a spring that is stiffer than austenite by this factor.
HOLDING_STIFFNESS = 100.0
PLAIN_TRIALS = 12  # of plain Newton, after which every second trial halves the bracket
MAX_TRIALS = 80
MAX_LINEAR_STEPS = 100
SMALL_CONTRACTION = 1e-16


class GrippedObject(NamedTuple):
    """An object between two fingers, and how each finger meets it.

    The endpoints touch it when their displacements add up to ``clearance_m``. The tables of a finger are (n,), at
    displacements of its connector of 0, 1, 2... times ``step_m``; both fingers have the same.
    """

    stiffness_n_per_m: float  # with which the object pushes both endpoints back
    clearance_m: float
    step_m: float
    endpoint_m: FloatArray  # displacement of a free finger's endpoint
    compliance_m_per_n: FloatArray  # displacement that a force at the endpoint takes from it
    leverage: FloatArray  # force that the tendon gains per force at the endpoint


class BalanceGuess(NamedTuple):
    """Where the solution of a wire begins: its enthalpy after the step, and where it and its connector may then be."""

    shakedown: ShakedownEffects
    enthalpy_j: float
    temperature_k: float
    stress_pa: float
    contraction: float


class CoupledBalance(NamedTuple):
    """Both wires after a step, and what pushed each connector beyond its load."""

    first: Equilibrium
    second: Equilibrium
    push: ConnectorForce
    second_push: ConnectorForce
    contraction: float  # of a common connector, as friction
    friction_n: float
    grip_n: float
    earlier: tuple[int, int]  # evaluations of both wires before the last trial
    solved: bool


class LinearizedForce(NamedTuple):
    """A wire's force, linear around a contraction: force [N] there, and its fall per contraction [N]."""

    force_n: float
    fall_n: float
    contraction: float


def no_grip() -> GrippedObject:
    """Return a grip without an object, for wires on one connector."""
    nothing = np.zeros(2)
    return GrippedObject(0.0, 0.0, 1.0, nothing, nothing, nothing)


@compiled_inner
def solve_wire(wire: RunningWire, start: BalanceGuess, guess: tuple[float, float], push: ConnectorForce) -> Equilibrium:
    """Return a wire in balance with its load and a push: one copy of the solution's machine code for all callers."""
    return solve(wire, start.shakedown, start.enthalpy_j, guess, push)


@compiled_inline
def pull_of(wire: RunningWire, found: Equilibrium) -> LinearizedForce:
    """Return a wire's force around a solution, at constant enthalpy; below 0 it stands for a slack wire."""
    k = wire.constants
    slope_pa = found.stress_per_contraction_pa
    if not slope_pa < 0.0:  # no wire gets stiffer by pulling less: only a guess, so that Newton's method goes on
        slope_pa = -1.0 / (k.austenite_compliance_per_pa * k.per_stretch)
    return LinearizedForce(found.wire.stress_pa * k.section_m2, -slope_pa * k.section_m2, found.wire.contraction)


@compiled_inline
def pull_at(pull: LinearizedForce, contraction: float) -> float:
    """Return the linear force at a contraction [N], below 0 for a slack wire."""
    return pull.force_n - pull.fall_n * (contraction - pull.contraction)


@compiled_inner
def held_wire(
    wire: RunningWire, start: BalanceGuess, guess: tuple[float, float], contraction: float, expected_n: float
) -> Equilibrium:
    """Return a wire held at about a contraction by a stiff spring that there has the force expected [N]."""
    state, k = wire.state, wire.constants
    before = (state.connector_contraction, state.friction_n)
    own_n = load_at(k, wire.load, contraction, before, NO_PUSH).force_n
    stiffness_n = HOLDING_STIFFNESS * k.section_m2 / (k.austenite_compliance_per_pa * k.per_stretch)
    return solve_wire(wire, start, guess, ConnectorForce(expected_n - own_n, stiffness_n, contraction))


@compiled_inline
def contraction_error(found: Equilibrium, contraction: float) -> float:
    """Return how far a wire ended away from the contraction at which it was held; a slack wire hangs where it likes."""
    return abs(found.wire.contraction - contraction) if found.wire.stress_pa > 0.0 else 0.0


@compiled_inner
def balanced_contraction(
    first: RunningWire,
    other_pretension_n: float,
    pull: LinearizedForce,
    other: LinearizedForce,
    sense: tuple[float, float],
    start: float,
) -> float:
    """Return the contraction of the first wire at which both pulls balance the load of their connector.

    N_1 + d N_2 = F_p1 + d F_p2 + k x + table + friction; each pull is linear and 0 for a slack wire. ``sense`` is the
    direction d, and the second wire's contraction per contraction of the first.
    """
    state, k = first.state, first.constants
    before = (state.connector_contraction, state.friction_n)
    direction, ratio = sense
    fall_n = other.fall_n * abs(ratio)
    low, high = -math.inf, math.inf
    contraction = start
    for _ in range(MAX_LINEAR_STEPS):
        load = load_at(k, first.load, contraction, before, NO_PUSH)
        load_n = load.force_n + direction * other_pretension_n
        own_n, others_n = pull_at(pull, contraction), pull_at(other, ratio * contraction)
        missing_n = max(own_n, 0.0) + direction * max(others_n, 0.0) - load_n
        if missing_n == 0.0:
            return contraction
        # With more pull than load the contraction is larger.
        if missing_n > 0.0:
            low = contraction
        else:
            high = contraction
        if own_n > 0.0 or others_n > 0.0:
            holding_n = (pull.fall_n if own_n > 0.0 else 0.0) + (fall_n if others_n > 0.0 else 0.0)
            moved = missing_n / (holding_n + load.per_contraction_n)
        else:
            moved = slack_move(pull.fall_n, fall_n, (own_n, others_n), direction, load_n, load.per_contraction_n)
        after = contraction + moved
        if not abs(moved) > SMALL_CONTRACTION:
            return after
        # A step that overshoots at a kink becomes a bisection.
        if not low < after < high:
            after = 0.5 * (low + high)
        contraction = after
    return contraction


@compiled_inline
def slack_move(
    fall_n: float, other_fall_n: float, pulls_n: tuple[float, float], direction: float, load_n: float, slope_n: float
) -> float:
    """Return the move of a connector on which both wires are slack: to where the load is 0 or a wire holds it."""
    moved = -load_n / slope_n if slope_n > 0.0 else -math.copysign(math.inf, load_n)
    if load_n > 0.0:
        moved = max(moved, (pulls_n[0] - load_n) / (fall_n + slope_n))
        if direction > 0.0:
            moved = max(moved, (pulls_n[1] - load_n) / (other_fall_n + slope_n))
    elif direction < 0.0:
        moved = min(moved, (-pulls_n[1] - load_n) / (other_fall_n + slope_n))
    return moved


@compiled_inner
def balance_connector(
    first: RunningWire, second: RunningWire, direction: float, start: BalanceGuess, other: BalanceGuess
) -> CoupledBalance:
    """Return two wires on one connector in balance with the first one's load, by Newton's method on displacement."""
    one, two = first.constants, second.constants
    ratio = direction * one.leg_length_m / two.leg_length_m
    held = start.contraction
    guess, other_guess = (start.temperature_k, start.stress_pa), (other.temperature_k, other.stress_pa)
    expected_n, other_expected_n = start.stress_pa * one.section_m2, other.stress_pa * two.section_m2
    low, high, margin = -math.inf, math.inf, 0.0
    tolerance = CLOSE_M / one.leg_length_m
    trials = earlier = other_earlier = 0
    while True:
        trials += 1
        found = held_wire(first, start, guess, held, expected_n)
        others = held_wire(second, other, other_guess, ratio * held, other_expected_n)
        pull, other_pull = pull_of(first, found), pull_of(second, others)
        after = balanced_contraction(first, two.pretension_n, pull, other_pull, (direction, ratio), held)
        missed = max(contraction_error(found, held), contraction_error(others, ratio * held) * abs(ratio))
        narrow = high - low < 5.0 * margin
        close = max(abs(after - held), missed) < tolerance or narrow
        if not abs(after) < math.inf:  # no displacement balances the load
            after = held
            break
        if close or trials >= MAX_TRIALS:
            break
        # Where both pulls are linear continuations their balance may be on the wrong side by as much.
        margin = missed + tolerance
        if after > held:
            low = max(low, held - margin)
        else:
            high = min(high, held + margin)
        halve = trials > PLAIN_TRIALS and trials % 2 == 0
        if (halve or not low < after < high) and -math.inf < low < high < math.inf:
            after = 0.5 * (low + high)
        held = after
        earlier, other_earlier = earlier + found.evaluations, other_earlier + others.evaluations
        guess = (found.wire.temperature_k, found.wire.stress_pa)
        other_guess = (others.wire.temperature_k, others.wire.stress_pa)
        expected_n, other_expected_n = max(pull_at(pull, held), 0.0), max(pull_at(other_pull, ratio * held), 0.0)
    before = (first.state.connector_contraction, first.state.friction_n)
    friction_n = load_at(one, first.load, after, before, NO_PUSH).friction_n
    solved = close and found.solved and others.solved
    return CoupledBalance(found, others, NO_PUSH, NO_PUSH, after, friction_n, 0.0, (earlier, other_earlier), solved)


@compiled_inner
def at_table(table: FloatArray, step_m: float, displacement_m: float) -> tuple[float, float]:
    """Return value and slope of a table, extrapolated linearly at both ends."""
    place = displacement_m / step_m
    low = min(max(int(place), 0), table.shape[0] - 2)
    rise = table[low + 1] - table[low]
    return table[low] + rise * (place - low), rise / step_m


@compiled_inner
def grip_force_n(grip: GrippedObject, displacement_m: float, other_m: float) -> float:
    """Return the force between each endpoint and the object [N] with both connectors where they are."""
    own, other = at_table(grip.endpoint_m, grip.step_m, displacement_m), at_table(grip.endpoint_m, grip.step_m, other_m)
    squeezed = own[0] + other[0] - grip.clearance_m
    if squeezed <= 0.0:
        return 0.0
    soft = at_table(grip.compliance_m_per_n, grip.step_m, displacement_m)[0]
    soft += at_table(grip.compliance_m_per_n, grip.step_m, other_m)[0]
    return grip.stiffness_n_per_m * squeezed / (1.0 + grip.stiffness_n_per_m * soft)


class FingerBalance(NamedTuple):
    """A finger's wire under a force on its endpoint, with its push on the connector and both displacements."""

    found: Equilibrium
    push: ConnectorForce
    contraction: float
    reach_m: float
    per_n: float  # slope of the endpoint's reach over the force
    beside_n: float  # how far the push is from the true


@compiled_inner
def pressed_finger(
    wire: RunningWire,
    start: BalanceGuess,
    guess: tuple[float, float],
    around: float,
    grip: GrippedObject,
    grip_n: float,
) -> FingerBalance:
    """Return a finger whose endpoint a force [N] pushes back; the leverage is linear around a contraction."""
    k = wire.constants
    length_m = k.leg_length_m
    leverage, slope = at_table(grip.leverage, grip.step_m, around * length_m)
    push = ConnectorForce(leverage * grip_n, slope * length_m * grip_n, around)
    found = solve_wire(wire, start, guess, push)
    before = (wire.state.connector_contraction, wire.state.friction_n)
    contraction, _ = connector_after(wire, found, push)
    load = load_at(k, wire.load, contraction, before, push)
    yields = 0.0  # contraction per force at the connector
    if found.wire.stress_pa > 0.0:
        yields = 1.0 / (load.per_contraction_n + pull_of(wire, found).fall_n)
    elif contraction != found.wire.contraction and contraction != before[0]:
        yields = 1.0 / load.per_contraction_n
    x_m = contraction * length_m
    leverage, _ = at_table(grip.leverage, grip.step_m, x_m)
    free_m, free_slope = at_table(grip.endpoint_m, grip.step_m, x_m)
    soft, soft_slope = at_table(grip.compliance_m_per_n, grip.step_m, x_m)
    per_n = -leverage * yields * length_m * (free_slope - soft_slope * grip_n) - soft
    beside_n = abs(leverage * grip_n - (push.force_n + push.per_contraction_n * (contraction - around)))
    return FingerBalance(found, push, contraction, free_m - soft * grip_n, per_n, beside_n)


@compiled_inner
def hold_object(
    first: RunningWire,
    second: RunningWire,
    grip: GrippedObject,
    begin_n: float,
    start: BalanceGuess,
    other: BalanceGuess,
) -> CoupledBalance:
    """Return two fingers in balance, each with its load and both with the object between them.

    Newton's method on the force on the object: each finger is solved under it, and the endpoints must then have
    squeezed the object as far as that force does. Below a force of 0 they do not touch it.
    """
    grip_n = begin_n
    low_n, high_n = -math.inf, math.inf
    guess, other_guess = (start.temperature_k, start.stress_pa), (other.temperature_k, other.stress_pa)
    around, other_around = start.contraction, other.contraction
    trials = earlier = other_earlier = 0
    while True:
        trials += 1
        one = pressed_finger(first, start, guess, around, grip, grip_n)
        two = pressed_finger(second, other, other_guess, other_around, grip, grip_n)
        if grip.stiffness_n_per_m == 0.0:
            close = True
            break
        give = 1.0 / grip.stiffness_n_per_m
        beyond_m = one.reach_m + two.reach_m - grip.clearance_m - give * grip_n
        narrow = high_n - low_n < CLOSE_N
        close = (abs(beyond_m) < CLOSE_M or (grip_n == 0.0 and beyond_m < 0.0) or narrow) and max(
            one.beside_n, two.beside_n
        ) < CLOSE_N * max(1.0, grip_n)
        if close or trials >= MAX_TRIALS:
            break
        margin_n = one.beside_n + two.beside_n + 0.1 * CLOSE_N
        if beyond_m > 0.0:
            low_n = max(low_n, grip_n - margin_n if grip_n > 0.0 else 0.0)
        else:
            high_n = min(high_n, grip_n + margin_n)
        after_n = max(grip_n - beyond_m / (one.per_n + two.per_n - give), 0.0)
        halve = trials > PLAIN_TRIALS and trials % 2 == 0
        if (halve or not low_n < after_n < high_n) and high_n < math.inf:
            after_n = 0.5 * (max(low_n, 0.0) + high_n)
        grip_n = after_n
        earlier, other_earlier = earlier + one.found.evaluations, other_earlier + two.found.evaluations
        guess = (one.found.wire.temperature_k, one.found.wire.stress_pa)
        other_guess = (two.found.wire.temperature_k, two.found.wire.stress_pa)
        around, other_around = one.contraction, two.contraction
    solved = close and one.found.solved and two.found.solved
    return CoupledBalance(one.found, two.found, one.push, two.push, 0.0, 0.0, grip_n, (earlier, other_earlier), solved)
