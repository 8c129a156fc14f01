"""The tick of the feedforward controller, compiled; ``_feedforward`` says what each number is for.

``state`` is a record of ``STATE``, which is changed in place.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner, row_in
from musclewire.signals import Reason

SETTINGS = np.dtype(
    [
        (name, np.float64)
        for name in (
            "sense_voltage_v", "maximum_voltage_v", "shunt_resistance_ohm", "thermal_time_constant_s", "heat_per_unit",
            "response_s", "integral_time_s", "pulse_time_s", "tolerance", "gap_fraction", "maximum_steady_power_w",
            "lowest", "spacing",
        )
    ]
)  # fmt: skip
STATE = np.dtype(
    [
        (name, np.float64)
        for name in (
            "started", "drive_voltage_v", "power_w", "steady_w", "balance_w", "pulse_j", "target", "start_value",
            "place", "anchor", "still_s",
        )
    ]
)  # fmt: skip
TABLES = ("heating_power_w", "cooling_power_w", "resistance_ohm", "heating_slope", "cooling_slope")
N_TABLES = len(TABLES)
HEATING, COOLING, RESISTANCE, HEATING_SLOPE, COOLING_SLOPE = range(N_TABLES)
N_SETTINGS = len(SETTINGS.names or ())
NO_CURRENT, COLD, NOT_READY = float(Reason.NO_CURRENT), float(Reason.COLD), float(Reason.NOT_READY)
# A wire counts as still that has moved by less than half the tolerance for this long [s]: two samples of 50 ms, so
# motion that has just turned does not count as standing.
STILL_S = 0.09
PowerLimits = tuple[float, float, float]
# A record; mypy knows no fields of one.
Row = Any


class KnownWire(NamedTuple):
    """What is known of a wire: a record of ``SETTINGS``, and the tables, a row each with a number for every level."""

    settings: Row
    tables: FloatArray


@compiled_inner
def table_value(wire: KnownWire, table: int, value: float) -> float:
    """Return a table at a value of the quantity, linear between its levels and constant beyond them."""
    levels = wire.tables[table]
    last = levels.size - 1
    place = min(max((value - wire.settings["lowest"]) / wire.settings["spacing"], 0.0), float(last))
    left = min(int(place), last - 1)
    return float(levels[left] + (place - left) * (levels[left + 1] - levels[left]))


@compiled_inner
def edge_w(wire: KnownWire, place: float, value: float) -> float:
    """Return the power that holds a value at a place between the cooling branch (-1) and the heating branch (1)."""
    heating, cooling = table_value(wire, HEATING, value), table_value(wire, COOLING, value)
    return float(0.5 * ((1.0 + place) * heating + (1.0 - place) * cooling))


@compiled_inner
def power_w(wire: KnownWire, drive_voltage_v: float, value: float) -> float:
    """Return the electrical power in the wire at a drive voltage."""
    resistance = table_value(wire, RESISTANCE, value)
    current = drive_voltage_v / (resistance + wire.settings["shunt_resistance_ohm"])
    return float(current * current * resistance)


@compiled_inner
def power_limits_w(wire: KnownWire, value: float) -> PowerLimits:
    """Return the power of the lowest and of the highest drive, and the highest steady one of the temperature limit."""
    lowest_w = power_w(wire, wire.settings["sense_voltage_v"], value)
    highest_w = power_w(wire, wire.settings["maximum_voltage_v"], value)
    return lowest_w, highest_w, max(min(highest_w, wire.settings["maximum_steady_power_w"]), lowest_w)


@compiled_inner
def heat_per_value(wire: KnownWire, table: int, value: float) -> float:
    """Return the heat that moves the quantity by one on a branch: to warm the wire and to transform it."""
    return float(
        wire.settings["thermal_time_constant_s"] * table_value(wire, table, value) + wire.settings["heat_per_unit"]
    )


@compiled
def feedforward_tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Control by feedforward of power and heat, and by a PI on what that leaves."""
    state_row = row_in(state, STATE)
    wire = KnownWire(row_in(constants, SETTINGS), constants[N_SETTINGS:].reshape(N_TABLES, -1))
    target, value, valid, reason, dt_s = given[0], given[1], given[3], given[4], given[5]
    answer[0], answer[1] = state_row["drive_voltage_v"], 0.0
    answer[2], answer[3] = state_row["steady_w"], state_row["pulse_j"]
    if reason == NO_CURRENT:
        return
    if not math.isfinite(target - value) or not dt_s > 0.0 or not math.isfinite(dt_s):
        answer[1] = 1.0
        return
    if reason in (COLD, NOT_READY):
        value = min(value, wire.settings["lowest"])
    limits_w = power_limits_w(wire, value)
    first = state_row["started"] == 0.0
    if first:
        take_over(wire, state_row, value)
    if target != state_row["target"]:
        new_target(wire, state_row, target, value, first and valid == 0.0, limits_w)
    error = expected(wire, state_row, target) - value
    cross_the_gap(wire, state_row, value, error, dt_s, valid, limits_w)
    command(wire, state_row, value, error, dt_s, limits_w)
    answer[0], answer[2], answer[3] = state_row["drive_voltage_v"], state_row["steady_w"], state_row["pulse_j"]


@compiled_inner
def take_over(wire: KnownWire, state: Row, value: float) -> None:
    """Start from the drive that is applied, as one that has been there for long."""
    state["started"] = 1.0
    state["power_w"] = power_w(wire, state["drive_voltage_v"], value)
    state["steady_w"] = state["balance_w"] = state["power_w"]
    state["target"] = state["start_value"] = state["anchor"] = value


@compiled_inner
def new_target(wire: KnownWire, state: Row, target: float, value: float, cold: bool, limits_w: PowerLimits) -> None:
    """Add what a new target takes: steady power of its branch, and the heat for the way there."""
    lowest_w, _, steady_limit_w = limits_w
    side = 1.0 if target > state["target"] else -1.0
    place = state["place"] if state["place"] != 0.0 else side
    if cold:  # no branch is known of a cold wire: all that the target takes
        change_w = edge_w(wire, 1.0, target) - state["steady_w"]
    else:
        here_w = edge_w(wire, side, state["target"])
        gap_w = here_w - edge_w(wire, place, state["target"])
        change_w = edge_w(wire, side, target) - here_w + gap_w
    steady_w = min(max(state["steady_w"] + change_w, lowest_w), steady_limit_w)
    warming_j = wire.settings["thermal_time_constant_s"] * (steady_w - state["steady_w"])
    state["pulse_j"] += warming_j + wire.settings["heat_per_unit"] * (target - state["target"])
    state["steady_w"], state["start_value"], state["place"], state["target"] = steady_w, value, side, target


@compiled_inner
def expected(wire: KnownWire, state: Row, target: float) -> float:
    """Return where the wire should be by now: short of its target by the heat that is still to come."""
    table = HEATING_SLOPE if state["place"] >= 0.0 else COOLING_SLOPE
    short = target - state["pulse_j"] / heat_per_value(wire, table, target)
    return float(min(max(short, min(state["start_value"], target)), max(state["start_value"], target)))


@compiled_inner
def cross_the_gap(
    wire: KnownWire, state: Row, value: float, error: float, dt_s: float, valid: float, limits_w: PowerLimits
) -> None:
    """Let a wire that stands on the wrong side of its target jump over most of the gap between the branches."""
    lowest_w, _, steady_limit_w = limits_w
    watch(wire, state, value, dt_s)
    side = 1.0 if error > 0.0 else -1.0
    table = HEATING_SLOPE if state["place"] >= 0.0 else COOLING_SLOPE
    pulse_over = abs(state["pulse_j"]) < wire.settings["tolerance"] * heat_per_value(wire, table, state["target"])
    still = state["still_s"] >= STILL_S
    far = abs(error) > wire.settings["tolerance"]
    if valid != 0.0 and pulse_over and still and far and state["place"] * side <= 0.0:
        gap_w = wire.settings["gap_fraction"] * (edge_w(wire, side, value) - edge_w(wire, state["place"], value))
        state["steady_w"] = min(max(state["balance_w"] + gap_w, lowest_w), steady_limit_w)
        state["pulse_j"] += wire.settings["thermal_time_constant_s"] * gap_w
        state["place"] = side


@compiled_inner
def watch(wire: KnownWire, state: Row, value: float, dt_s: float) -> None:
    """Measure for how long the wire has stood still."""
    if abs(value - state["anchor"]) > 0.5 * wire.settings["tolerance"]:
        state["anchor"], state["still_s"] = value, 0.0
    else:
        state["still_s"] += dt_s


@compiled_inner
def command(wire: KnownWire, state: Row, value: float, error: float, dt_s: float, limits_w: PowerLimits) -> None:
    """Set the drive voltage, then advance integral, pulse and heat balance with the power within the limits."""
    lowest_w, highest_w, steady_limit_w = limits_w
    tau_s = wire.settings["thermal_time_constant_s"]
    gain = heat_per_value(wire, HEATING_SLOPE if error > 0.0 else COOLING_SLOPE, value) / wire.settings["response_s"]
    # With this power the heat balance is at the limit after this sample, not above it.
    warmest_w = steady_limit_w + max(0.0, steady_limit_w - state["balance_w"]) * tau_s / dt_s
    limit_w = max(min(highest_w, warmest_w), lowest_w)
    without_pulse_w = state["steady_w"] + gain * error
    wanted_w = without_pulse_w + state["pulse_j"] / wire.settings["pulse_time_s"]
    given_w = min(max(wanted_w, lowest_w), limit_w)
    by_pulse_w = given_w - min(max(without_pulse_w, lowest_w), limit_w)
    state["pulse_j"] -= dt_s * (by_pulse_w + state["pulse_j"] / tau_s)
    integral_w = gain * error * dt_s / wire.settings["integral_time_s"]
    if not ((wanted_w > limit_w and integral_w > 0.0) or (wanted_w < lowest_w and integral_w < 0.0)):
        state["steady_w"] = min(max(state["steady_w"] + integral_w, lowest_w), steady_limit_w)
    state["balance_w"] += min(dt_s / tau_s, 1.0) * (given_w - state["balance_w"])
    set_drive(wire, state, value, given_w, lowest_w, highest_w)


@compiled_inner
def set_drive(wire: KnownWire, state: Row, value: float, given_w: float, lowest_w: float, highest_w: float) -> None:
    """Set the drive voltage of a power; at a limit of the power exactly that of the drive."""
    if given_w == lowest_w:
        state["drive_voltage_v"] = wire.settings["sense_voltage_v"]
    elif given_w == highest_w:
        state["drive_voltage_v"] = wire.settings["maximum_voltage_v"]
    elif given_w != state["power_w"]:
        resistance = table_value(wire, RESISTANCE, value)
        drive_v = math.sqrt(given_w / resistance) * (resistance + wire.settings["shunt_resistance_ohm"])
        state["drive_voltage_v"] = min(
            max(drive_v, wire.settings["sense_voltage_v"]), wire.settings["maximum_voltage_v"]
        )
    state["power_w"] = given_w
