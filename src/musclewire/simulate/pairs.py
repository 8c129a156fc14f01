"""Two coupled wires: pulling together or against each other, or each on its finger with an object between them.

Each wire has its own heat, phases and history, by the same functions as a single wire. The two are coupled by a circuit
and a connector, or by an object that both fingers touch.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.wire.state import Rows, RunningWire, WireConstants, WireState
from musclewire.wire.step import (
    compliance_per_pa,
    contraction_at_stress,
    find_equilibrium,
    heat,
    load_beyond_spring,
    resistance_ahead_ohm,
    running,
    settle_at,
)

__all__ = ["APART", "OWN_SUPPLY", "PARALLEL", "SERIES", "Grip", "Pair", "PairMeans", "advance_pair", "no_grip"]

# Supply of the second wire: its own one, in parallel with the first wire, or in series with it.
OWN_SUPPLY, PARALLEL, SERIES = 0, 1, 2
# Direction in which the second wire pulls the common connector: 1 with the first, -1 against it; 0 without one.
APART = 0.0
# Newton's method ends at a step below this: the force is then balanced to 1e-8 N.
SMALL_MOVE_M = 1e-13
MAX_NEWTON_STEPS = 30


class Grip(NamedTuple):
    """An object between two fingers, and how each finger meets it.

    The endpoints touch it when their displacements add up to ``clearance_m``. The tables of a finger are (n,), at
    displacements of its connector of 0, 1, 2... times ``step_m``; both fingers have the same.

    Parameters
    ----------
    stiffness_n_per_m
        Stiffness with which the object pushes both endpoints back [N/m].
    clearance_m
        Sum of both endpoints' displacements at first touch [m].
    step_m
        Connector displacement from point to point of the tables [m].
    endpoint_m
        Displacement of a free finger's endpoint [m].
    compliance_m_per_n
        Displacement that a force at the endpoint takes from it [m/N].
    leverage
        Force that the tendon gains per force at the endpoint.
    """

    stiffness_n_per_m: float
    clearance_m: float
    step_m: float
    endpoint_m: FloatArray
    compliance_m_per_n: FloatArray
    leverage: FloatArray


class Pair(NamedTuple):
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


class HeatedPair(NamedTuple):
    """Voltages of two wires during one step, and the temperature rises that their grains followed [K]."""

    wire_voltage_v: float
    shunt_voltage_v: float
    rises_k: tuple[float, float]


@compiled
def at_table(table: FloatArray, step_m: float, displacement_m: float) -> tuple[float, float]:
    """Return value and slope of a table, extrapolated linearly at both ends."""
    place = displacement_m / step_m
    low = min(max(int(place), 0), table.shape[0] - 2)
    rise = table[low + 1] - table[low]
    return table[low] + rise * (place - low), rise / step_m


@compiled
def grip_of(grip: Grip, displacement_m: float, other_m: float) -> tuple[float, float, float]:
    """Return the force between endpoint and object [N], with the force and stiffness on the first connector."""
    own, own_slope = at_table(grip.endpoint_m, grip.step_m, displacement_m)
    other, _ = at_table(grip.endpoint_m, grip.step_m, other_m)
    soft = at_table(grip.compliance_m_per_n, grip.step_m, displacement_m)[0]
    soft += at_table(grip.compliance_m_per_n, grip.step_m, other_m)[0]
    squeezed = own + other - grip.clearance_m
    if squeezed <= 0.0:
        return 0.0, 0.0, 0.0
    stiffness = grip.stiffness_n_per_m / (1.0 + grip.stiffness_n_per_m * soft)
    leverage, _ = at_table(grip.leverage, grip.step_m, displacement_m)
    return stiffness * squeezed, leverage * stiffness * squeezed, leverage * stiffness * own_slope


@compiled
def contraction_at(wire: RunningWire, stress_pa: float) -> tuple[float, float]:
    """Return the contraction at a stress with unchanged phases, and its decrease with stress [1/Pa]."""
    state, constants = wire.state, wire.constants
    shortened = contraction_at_stress(
        constants,
        stress_pa,
        state.martensite_fraction,
        state.r_phase_fraction,
        state.temperature_k,
        wire.shakedown.residual_strain,
    )
    return shortened, compliance_per_pa(constants, stress_pa, state.martensite_fraction) / (1.0 + constants.cold_strain)


@compiled
def connectors_m(first: RunningWire, second: RunningWire, direction: float) -> tuple[float, float]:
    """Return the displacements of both connectors, positive as their wires pull, from the wire that is not slack."""
    own = first.state.contraction * first.constants.leg_length_m
    other = second.state.contraction * second.constants.leg_length_m
    if direction == APART:
        return own, other
    x = own if first.state.stress_pa > 0.0 or second.state.stress_pa <= 0.0 else direction * other
    return x, direction * x


@compiled
def shared_stresses(first: RunningWire, second: RunningWire, direction: float) -> tuple[float, float]:
    """Return the stresses of two wires on one connector in equilibrium with its load: Newton on its displacement.

    N_1 s_1 + d N_2 s_2 = F_p1 + d F_p2 + k x + force of the table + friction, x = S_1 l_1 = d S_2 l_2; a slack
    wire carries nothing, and either may be slack.
    """
    one, other = first.constants, second.constants
    section, other_section = one.legs * one.area_m2, other.legs * other.area_m2
    stress, other_stress = first.state.stress_pa, second.state.stress_pa
    x, _ = connectors_m(first, second, direction)
    low_m, high_m = -math.inf, math.inf
    for _ in range(MAX_NEWTON_STEPS):
        shortened, taken = contraction_at(first, stress)
        other_shortened, other_taken = contraction_at(second, other_stress)
        per_m, other_per_m = 1.0 / (one.leg_length_m * taken), 1.0 / (other.leg_length_m * other_taken)
        # Linear in the displacement x from here on: both stresses and the load.
        pulled = stress - (x - shortened * one.leg_length_m) * per_m
        other_pulled = other_stress - (direction * x - other_shortened * other.leg_length_m) * other_per_m
        beyond_n, beyond_n_per_m = load_beyond_spring(first.load_table_n, one.load_step_m, x)
        stiffness = one.spring_stiffness_n_per_m + beyond_n_per_m
        load_n = one.pretension_n + direction * other.pretension_n + one.spring_stiffness_n_per_m * x + beyond_n
        missing_n = section * max(pulled, 0.0) + direction * other_section * max(other_pulled, 0.0)
        missing_n -= load_n + first.state.friction_n
        slack = pulled <= 0.0 and other_pulled <= 0.0
        holding = section * per_m if pulled > 0.0 or slack else 0.0
        other_holding = other_section * other_per_m if other_pulled > 0.0 or slack else 0.0
        # With more pull than load the displacement is larger. A step that overshoots at a kink becomes a bisection.
        low_m, high_m = (x, high_m) if missing_n > 0.0 else (low_m, x)
        move_m = missing_n / (holding + other_holding + stiffness)
        if not low_m <= x + move_m <= high_m:
            move_m = 0.5 * (low_m + high_m) - x
        x += move_m
        stress = max(pulled - move_m * per_m, 0.0)
        other_stress = max(other_pulled - direction * move_m * other_per_m, 0.0)
        if abs(move_m) < SMALL_MOVE_M:
            break
    return stress, other_stress


@compiled
def currents_a(
    first_ohm: float, second_ohm: float, series_ohm: float, drive_voltage_v: float, pair: Pair
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


@compiled
def settle_pair(
    first: RunningWire, second: RunningWire, rises_k: tuple[float, float], dt_s: float, pair: Pair, grip: Grip
) -> float:
    """Bring both wires into equilibrium after a step; return the force between endpoint and object [N]."""
    if pair.direction != APART:
        stress, other_stress = shared_stresses(first, second, pair.direction)
        settle_at(first, rises_k[0], dt_s, stress)
        settle_at(second, rises_k[1], dt_s, other_stress)
        return 0.0
    # Each finger's equilibrium takes the other one's position of the step before, and its own stiffness.
    x, y = connectors_m(first, second, APART)
    grip_n, push_n, push_n_per_m = grip_of(grip, x, y)
    _, other_push_n, other_push_n_per_m = grip_of(grip, y, x)
    settle_against(first, rises_k[0], dt_s, push_n, push_n_per_m)
    settle_against(second, rises_k[1], dt_s, other_push_n, other_push_n_per_m)
    return grip_n


@compiled
def settle_against(wire: RunningWire, rise_k: float, dt_s: float, push_n: float, push_n_per_m: float) -> None:
    """Bring a wire into equilibrium with its load and with a force known from the end of the step before."""
    shortened, _ = contraction_at(wire, wire.state.stress_pa)
    moved_m = (shortened - wire.state.contraction) * wire.constants.leg_length_m
    find_equilibrium(wire, rise_k, dt_s, push_n + push_n_per_m * moved_m, push_n_per_m)


@compiled
def heat_pair(first: RunningWire, second: RunningWire, drive_voltage_v: float, dt_s: float, pair: Pair) -> HeatedPair:
    """Heat both wires by one step's current; return the voltages and the temperature rises that the grains followed."""
    first_ohm = resistance_ahead_ohm(first.state, dt_s)
    second_ohm = resistance_ahead_ohm(second.state, dt_s)
    current, partner, voltage, through = currents_a(
        first_ohm, second_ohm, first.constants.series_resistance_ohm, drive_voltage_v, pair
    )
    rise = heat(first, current * current * first_ohm, dt_s)
    other_rise = heat(second, partner * partner * second_ohm, dt_s)
    return HeatedPair(voltage, through * first.constants.shunt_resistance_ohm, (rise, other_rise))


@compiled
def advance_pair_rows(
    states: tuple[Rows, Rows],
    constants: tuple[Rows, Rows],
    load_tables_n: tuple[FloatArray, FloatArray],
    pair_values: tuple[Any, ...],
    grip_values: tuple[Any, ...],
    drive_voltage_v: float,
    dt_s: float,
    steps: int,
) -> tuple[float, float, float, float, float, float, float]:
    """Advance two wires in place, each an array of one record, (1,); return the means of :func:`advance_pair`."""
    one, other = constants[0][0], constants[1][0]
    first, second = running(states[0][0], one, load_tables_n[0]), running(states[1][0], other, load_tables_n[1])
    pair, grip = Pair(*pair_values), Grip(*grip_values)
    wire_v, shunt_v, moved, force, other_moved, other_force, grip_sum = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x, y = connectors_m(first, second, pair.direction)
    for _ in range(steps):
        stress, other_stress = first.state.stress_pa, second.state.stress_pa
        heated = heat_pair(first, second, drive_voltage_v, dt_s, pair)
        wire_v += heated.wire_voltage_v
        shunt_v += heated.shunt_voltage_v
        grip_n = settle_pair(first, second, heated.rises_k, dt_s, pair, grip)
        x_before, y_before = x, y
        x, y = connectors_m(first, second, pair.direction)
        moved += 0.5 * (x_before + x)
        force += 0.5 * (stress + first.state.stress_pa) * one.legs * one.area_m2
        other_moved += 0.5 * (y_before + y)
        other_force += 0.5 * (other_stress + second.state.stress_pa) * other.legs * other.area_m2
        grip_sum += grip_n
    # Adding up time step by step would accumulate rounding errors; both wires have the first one's clock.
    first.state.time_s += steps * dt_s
    second.state.time_s = first.state.time_s
    return (
        wire_v / steps,
        shunt_v / steps,
        moved / steps,
        force / steps,
        other_moved / steps,
        other_force / steps,
        grip_sum / steps,
    )


def no_grip() -> Grip:
    """Return a grip without an object, for wires on one connector."""
    nothing = np.zeros(2)
    return Grip(0.0, 0.0, 1.0, nothing, nothing, nothing)


def advance_pair(
    states: tuple[WireState, WireState],
    constants: tuple[WireConstants, WireConstants],
    pair: Pair,
    grip: Grip,
    drive_voltage_v: float,
    dt_s: float,
    steps: int,
) -> tuple[tuple[WireState, WireState], PairMeans]:
    """Return both wires after ``steps`` steps of ``dt_s`` at one drive voltage, and the means over these steps.

    The states passed in are not changed. The circuit's shunt and leads are the first wire's.

    Parameters
    ----------
    states
        State of the first and of the second wire.
    constants
        Constants of both; the load in them is that of the common connector, or of each wire's own finger.
    pair
        How the wires are joined.
    grip
        The object between two fingers; ``no_grip()`` without one.
    drive_voltage_v
        Drive voltage of the first wire's circuit [V], the same in all steps.
    dt_s
        Length of a step [s].
    steps
        How many steps, 1 or more.

    Returns
    -------
    Both states after the last step, and the means over all steps.
    """
    after = (states[0].copy(), states[1].copy())
    # As for one wire, arrays and plain tuples cross into compiled code, and plain numbers come back.
    means = advance_pair_rows(
        (after[0].row, after[1].row),
        (constants[0].row, constants[1].row),
        (constants[0].load_table_n, constants[1].load_table_n),
        tuple(pair),
        tuple(grip),
        drive_voltage_v,
        dt_s,
        steps,
    )
    return after, PairMeans(*means)
