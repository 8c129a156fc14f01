"""Whole histories in one compiled call: a drive over time, temperatures and stresses, two wires that meet."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from grain_wire.compiling import compiled
from grain_wire.stepping import (
    Running,
    compliance_per_pa,
    contraction_at,
    equilibrium_stress_pa,
    heat_wire,
    load_beyond_spring,
    resistance_ahead_ohm,
    resistance_ohm,
    settle_at,
    shakedown_of,
    step,
    total_strain,
)
from grain_wire.switching import Array, follow

# Supply of the second wire: its own, in parallel with the first, or in series; and no common connector.
OWN_SUPPLY, PARALLEL, SERIES = 0, 1, 2
SEPARATE = 0.0
SMALL_MOVE_M = 1e-13
MAX_NEWTON_STEPS = 30


class Grip(NamedTuple):
    """An object between two fingers: stiffness and clearance, and tables of a finger every ``step_m``."""

    stiffness_n_per_m: float
    clearance_m: float
    step_m: float
    endpoint_m: Array
    compliance_m_per_n: Array
    leverage: Array


class Pair(NamedTuple):
    """What joins two wires: direction of the second's pull (1, -1, 0 apart), its feed and its own supply."""

    direction: float
    feed: int
    second_voltage_v: float
    second_series_ohm: float


@compiled
def advance(wire: Running, drive_v: float, dt_s: float, steps: int) -> tuple[float, float, float, float]:
    """Advance a wire at one drive voltage; return the sums over the steps of both voltages, displacement and force."""
    state, c = wire.state, wire.constants
    wire_v, shunt_v, moved, pulled = 0.0, 0.0, 0.0, 0.0
    for _ in range(steps):
        ohm = resistance_ahead_ohm(state, dt_s)
        current = drive_v / (ohm + c.series_resistance_ohm)
        wire_v += current * ohm
        shunt_v += current * c.shunt_resistance_ohm
        contraction, stress_pa = state.contraction, state.stress_pa
        step(wire, current * current * ohm, dt_s)
        moved += 0.5 * (contraction + state.contraction) * c.leg_length_m
        pulled += 0.5 * (stress_pa + state.stress_pa) * c.legs * c.area_m2
    state.time_s += steps * dt_s
    return wire_v, shunt_v, moved, pulled


@compiled
def drive(parts: Any, drives: Array, dt_s: float, steps: int, regulated_current: bool) -> Array:
    """Drive a wire in place, each voltage (or regulated current) for some steps; return the columns of a path."""
    states, constants, grains, convection, load_n = parts
    state, c = states[0], constants[0]
    shown = np.empty((9, drives.shape[0]))
    for sample in range(drives.shape[0]):
        # The shakedown of a new wire is taken up from sample to sample.
        wire = Running(state, c, grains, convection, load_n, shakedown_of(c, state.cycles))
        ohm = resistance_ahead_ohm(state, dt_s)
        volts = drives[sample] * (ohm + c.series_resistance_ohm) if regulated_current else drives[sample]
        wire_v, shunt_v, moved, pulled = advance(wire, volts, dt_s, steps)
        shown[0, sample], shown[1, sample] = wire_v / steps, shunt_v / steps
        shown[2, sample], shown[3, sample] = moved / steps, pulled / steps
        shown[4, sample], shown[5, sample] = state.temperature_k, state.stress_pa
        shown[6, sample], shown[7, sample] = state.martensite_fraction, state.r_phase_fraction
        shown[8, sample] = state.resistance_ohm
    return shown


@compiled
def walk(parts: Any, temperature_k: Array, stress_pa: Array) -> Array:
    """Take the grains in place through temperatures and stresses; return strain, resistance and both fractions."""
    constants, grains = parts[1], parts[2]
    c = constants[0]
    shown = np.empty((4, temperature_k.shape[0]))
    for point in range(temperature_k.shape[0]):
        follow(grains, c, temperature_k[point], stress_pa[point], 1.0)
        martensite, r_phase = grains.martensite.mean(), grains.r_phase.mean()
        shown[0, point] = total_strain(c, stress_pa[point], martensite, r_phase, temperature_k[point])
        shown[1, point] = resistance_ohm(c, stress_pa[point], martensite, r_phase, temperature_k[point], 0.0)
        shown[2, point] = martensite
        shown[3, point] = r_phase
    return shown


@compiled
def at_table(table: Array, step_m: float, displacement_m: float) -> tuple[float, float]:
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
def connectors_m(first: Running, second: Running, direction: float) -> tuple[float, float]:
    """Return the displacements of both connectors, from the wire that is not slack."""
    own = first.state.contraction * first.constants.leg_length_m
    other = second.state.contraction * second.constants.leg_length_m
    if direction == SEPARATE:
        return own, other
    x = own if first.state.stress_pa > 0.0 or second.state.stress_pa <= 0.0 else direction * other
    return x, direction * x


@compiled
def shared_stresses(first: Running, second: Running, direction: float) -> tuple[float, float]:
    """Return the stresses of two wires on one connector: Newton on its displacement, either may be slack."""
    one, other = first.constants, second.constants
    section, other_section = one.legs * one.area_m2, other.legs * other.area_m2
    stress, other_stress = first.state.stress_pa, second.state.stress_pa
    x, _ = connectors_m(first, second, direction)
    low_m, high_m = -math.inf, math.inf
    for _ in range(MAX_NEWTON_STEPS):
        taken = compliance_per_pa(first, stress) / (1.0 + one.cold_strain)
        other_taken = compliance_per_pa(second, other_stress) / (1.0 + other.cold_strain)
        per_m, other_per_m = 1.0 / (one.leg_length_m * taken), 1.0 / (other.leg_length_m * other_taken)
        # Linear in the displacement x from here on: both stresses and the load.
        pulled = stress - (x - contraction_at(first, stress) * one.leg_length_m) * per_m
        other_shortened = contraction_at(second, other_stress)
        other_pulled = other_stress - (direction * x - other_shortened * other.leg_length_m) * other_per_m
        beyond_n, beyond_n_per_m = load_beyond_spring(first.load_n, one.load_step_m, x)
        stiffness = one.spring_stiffness_n_per_m + beyond_n_per_m
        load_n = one.pretension_n + direction * other.pretension_n + one.spring_stiffness_n_per_m * x + beyond_n
        missing_n = section * max(pulled, 0.0) + direction * other_section * max(other_pulled, 0.0)
        missing_n -= load_n + first.state.friction_n
        slack = pulled <= 0.0 and other_pulled <= 0.0
        holding = section * per_m if pulled > 0.0 or slack else 0.0
        other_holding = other_section * other_per_m if other_pulled > 0.0 or slack else 0.0
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
    first_ohm: float, second_ohm: float, series_ohm: float, drive_v: float, pair: Pair
) -> tuple[float, float, float, float]:
    """Return both currents [A], the voltage across the terminals and the current through the shunt."""
    if pair.feed == SERIES:
        current = drive_v / (first_ohm + second_ohm + series_ohm)
        return current, current, current * (first_ohm + second_ohm), current
    if pair.feed == PARALLEL:
        together = first_ohm * second_ohm / (first_ohm + second_ohm)
        current = drive_v / (together + series_ohm)
        voltage = current * together
        return voltage / first_ohm, voltage / second_ohm, voltage, current
    current = drive_v / (first_ohm + series_ohm)
    partner = pair.second_voltage_v / (second_ohm + pair.second_series_ohm)
    return current, partner, current * first_ohm, current


@compiled
def settle_against(wire: Running, rise_k: float, dt_s: float, push_n: float, push_n_per_m: float) -> None:
    """Bring a wire into balance with its load and a force known from the end of the step before."""
    moved_m = (contraction_at(wire, wire.state.stress_pa) - wire.state.contraction) * wire.constants.leg_length_m
    settle_at(wire, rise_k, dt_s, equilibrium_stress_pa(wire, push_n + push_n_per_m * moved_m, push_n_per_m))


@compiled
def settle_pair(
    first: Running, second: Running, rises_k: tuple[float, float], dt_s: float, pair: Pair, grip: Grip
) -> float:
    """Bring both wires into balance after a step; return the force between endpoint and object [N]."""
    if pair.direction != SEPARATE:
        stress, other_stress = shared_stresses(first, second, pair.direction)
        settle_at(first, rises_k[0], dt_s, stress)
        settle_at(second, rises_k[1], dt_s, other_stress)
        return 0.0
    x, y = connectors_m(first, second, SEPARATE)
    grip_n, push_n, push_n_per_m = grip_of(grip, x, y)
    _, other_push_n, other_push_n_per_m = grip_of(grip, y, x)
    settle_against(first, rises_k[0], dt_s, push_n, push_n_per_m)
    settle_against(second, rises_k[1], dt_s, other_push_n, other_push_n_per_m)
    return grip_n


@compiled
def drive_pair(parts: Any, partner_parts: Any, pair: Pair, grip: Grip, drives: Array, dt_s: float, steps: int) -> Array:
    """Drive two wires in place; return the means over each sample, (7, n_samples)."""
    state, c, other, d = parts[0][0], parts[1][0], partner_parts[0][0], partner_parts[1][0]
    shown = np.empty((7, drives.shape[0]))
    for sample in range(drives.shape[0]):
        first = Running(state, c, parts[2], parts[3], parts[4], shakedown_of(c, state.cycles))
        second = Running(other, d, partner_parts[2], partner_parts[3], partner_parts[4], shakedown_of(d, other.cycles))
        shown[:, sample] = advance_pair(first, second, pair, grip, drives[sample], dt_s, steps)
    return shown


@compiled
def advance_pair(
    first: Running, second: Running, pair: Pair, grip: Grip, drive_v: float, dt_s: float, steps: int
) -> Array:
    """Advance two wires at one drive voltage; return voltages, displacement and force of each, and the grip's force."""
    one, other = first.constants, second.constants
    sums = np.zeros(7)
    x, y = connectors_m(first, second, pair.direction)
    for _ in range(steps):
        stress, other_stress = first.state.stress_pa, second.state.stress_pa
        first_ohm, second_ohm = resistance_ahead_ohm(first.state, dt_s), resistance_ahead_ohm(second.state, dt_s)
        current, partner, voltage, through = currents_a(first_ohm, second_ohm, one.series_resistance_ohm, drive_v, pair)
        rise = heat_wire(first, current * current * first_ohm, dt_s)
        other_rise = heat_wire(second, partner * partner * second_ohm, dt_s)
        sums[0] += voltage
        sums[1] += through * one.shunt_resistance_ohm
        grip_n = settle_pair(first, second, (rise, other_rise), dt_s, pair, grip)
        x_before, y_before = x, y
        x, y = connectors_m(first, second, pair.direction)
        sums[2] += 0.5 * (x_before + x)
        sums[3] += 0.5 * (stress + first.state.stress_pa) * one.legs * one.area_m2
        sums[4] += 0.5 * (y_before + y)
        sums[5] += 0.5 * (other_stress + second.state.stress_pa) * other.legs * other.area_m2
        sums[6] += grip_n
    first.state.time_s += steps * dt_s
    second.state.time_s = first.state.time_s
    return sums / steps
