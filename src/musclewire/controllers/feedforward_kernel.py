"""The tick of the feedforward controller, compiled; ``feedforward`` says what each number is for."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.signals.exchange import Reason

__all__ = ["NUMBERS", "STATE", "TABLES", "feedforward_tick"]

NUMBERS = np.dtype(
    [
        (name, np.float64)
        for name in (
            "sense_voltage_v", "maximum_voltage_v", "shunt_resistance_ohm", "thermal_time_constant_s", "heat_per_unit",
            "response_s", "integral_time_s", "pulse_time_s", "tolerance", "gap_fraction", "maximum_steady_power_w",
            "lowest", "spacing", "n_levels",
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
# The tables follow the numbers, each with a value for every level.
TABLES = ("heating_power_w", "cooling_power_w", "resistance_ohm", "heating_slope", "cooling_slope")
HEATING, COOLING, RESISTANCE, HEATING_SLOPE, COOLING_SLOPE = range(len(TABLES))
N_NUMBERS = len(NUMBERS.names or ())
NO_CURRENT, COLD, NOT_READY = float(Reason.NO_CURRENT), float(Reason.COLD), float(Reason.NOT_READY)
# A wire counts as still that has moved by less than half the tolerance for this long [s]: two samples of 50 ms, so
# motion that has just turned does not count as standing.
STILL_S = 0.09
PowerLimits = tuple[float, float, float]


@compiled
def at(constants: FloatArray, table: int, value: float) -> float:
    """Return a table at a value of the quantity, linear between its levels and constant beyond them."""
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    last = int(of["n_levels"]) - 1
    place = min(max((value - of["lowest"]) / of["spacing"], 0.0), float(last))
    left = min(int(place), last - 1)
    first = N_NUMBERS + table * (last + 1) + left
    return float(constants[first] + (place - left) * (constants[first + 1] - constants[first]))


@compiled
def edge_w(constants: FloatArray, place: float, value: float) -> float:
    """Return the power that holds a value at a place between the cooling branch (-1) and the heating branch (1)."""
    heating, cooling = at(constants, HEATING, value), at(constants, COOLING, value)
    return float(0.5 * ((1.0 + place) * heating + (1.0 - place) * cooling))


@compiled
def power_w(constants: FloatArray, drive_voltage_v: float, value: float) -> float:
    """Return the electrical power in the wire at a drive voltage."""
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    resistance = at(constants, RESISTANCE, value)
    current = drive_voltage_v / (resistance + of["shunt_resistance_ohm"])
    return float(current * current * resistance)


@compiled
def power_limits_w(constants: FloatArray, value: float) -> PowerLimits:
    """Return the power of the lowest and of the highest drive, and the highest steady one of the temperature limit."""
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    lowest_w = power_w(constants, of["sense_voltage_v"], value)
    highest_w = power_w(constants, of["maximum_voltage_v"], value)
    return lowest_w, highest_w, max(min(highest_w, of["maximum_steady_power_w"]), lowest_w)


@compiled
def heat_per_value(constants: FloatArray, table: int, value: float) -> float:
    """Return the heat that moves the quantity by one on a branch: to warm the wire and to transform it."""
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    return float(of["thermal_time_constant_s"] * at(constants, table, value) + of["heat_per_unit"])


@compiled
def feedforward_tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Control by feedforward of power and heat, and by a PI on what that leaves."""
    now = state.view(STATE)[0]
    target, value, valid, reason, dt_s = given[0], given[1], given[3], given[4], given[5]
    answer[0], answer[1], answer[2], answer[3] = now["drive_voltage_v"], 0.0, now["steady_w"], now["pulse_j"]
    if reason == NO_CURRENT:
        return
    if not math.isfinite(target - value) or not dt_s > 0.0 or not math.isfinite(dt_s):
        answer[1] = 1.0
        return
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    if reason in (COLD, NOT_READY):
        value = min(value, of["lowest"])
    limits_w = power_limits_w(constants, value)
    first = now["started"] == 0.0
    if first:
        take_over(constants, now, value)
    if target != now["target"]:
        new_target(constants, now, target, value, first and valid == 0.0, limits_w)
    error = expected(constants, now, target) - value
    cross_the_gap(constants, now, value, error, dt_s, valid, limits_w)
    command(constants, now, value, error, dt_s, limits_w)
    answer[0], answer[2], answer[3] = now["drive_voltage_v"], now["steady_w"], now["pulse_j"]


@compiled
def take_over(constants: FloatArray, now: Any, value: float) -> None:
    """Start from the drive that is applied, as one that has been there for long."""
    now["started"] = 1.0
    now["power_w"] = power_w(constants, now["drive_voltage_v"], value)
    now["steady_w"] = now["balance_w"] = now["power_w"]
    now["target"] = now["start_value"] = now["anchor"] = value


@compiled
def new_target(constants: FloatArray, now: Any, target: float, value: float, cold: bool, limits_w: PowerLimits) -> None:
    """Add what a new target takes: steady power of its branch, and the heat for the way there."""
    lowest_w, _, steady_limit_w = limits_w
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    side = 1.0 if target > now["target"] else -1.0
    place = now["place"] if now["place"] != 0.0 else side
    if cold:  # no branch is known of a cold wire: all that the target takes
        change_w = edge_w(constants, 1.0, target) - now["steady_w"]
    else:
        here_w = edge_w(constants, side, now["target"])
        gap_w = here_w - edge_w(constants, place, now["target"])
        change_w = edge_w(constants, side, target) - here_w + gap_w
    steady_w = min(max(now["steady_w"] + change_w, lowest_w), steady_limit_w)
    warming_j = of["thermal_time_constant_s"] * (steady_w - now["steady_w"])
    now["pulse_j"] += warming_j + of["heat_per_unit"] * (target - now["target"])
    now["steady_w"], now["start_value"], now["place"], now["target"] = steady_w, value, side, target


@compiled
def expected(constants: FloatArray, now: Any, target: float) -> float:
    """Return where the wire should be by now: short of its target by the heat that is still to come."""
    table = HEATING_SLOPE if now["place"] >= 0.0 else COOLING_SLOPE
    short = target - now["pulse_j"] / heat_per_value(constants, table, target)
    return float(min(max(short, min(now["start_value"], target)), max(now["start_value"], target)))


@compiled
def cross_the_gap(
    constants: FloatArray, now: Any, value: float, error: float, dt_s: float, valid: float, limits_w: PowerLimits
) -> None:
    """Let a wire that stands on the wrong side of its target jump over most of the gap between the branches."""
    lowest_w, _, steady_limit_w = limits_w
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    watch(constants, now, value, dt_s)
    side = 1.0 if error > 0.0 else -1.0
    table = HEATING_SLOPE if now["place"] >= 0.0 else COOLING_SLOPE
    pulse_over = abs(now["pulse_j"]) < of["tolerance"] * heat_per_value(constants, table, now["target"])
    still = now["still_s"] >= STILL_S
    if valid != 0.0 and pulse_over and still and abs(error) > of["tolerance"] and now["place"] * side <= 0.0:
        gap_w = of["gap_fraction"] * (edge_w(constants, side, value) - edge_w(constants, now["place"], value))
        now["steady_w"] = min(max(now["balance_w"] + gap_w, lowest_w), steady_limit_w)
        now["pulse_j"] += of["thermal_time_constant_s"] * gap_w
        now["place"] = side


@compiled
def watch(constants: FloatArray, now: Any, value: float, dt_s: float) -> None:
    """Measure for how long the wire has stood still."""
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    if abs(value - now["anchor"]) > 0.5 * of["tolerance"]:
        now["anchor"], now["still_s"] = value, 0.0
    else:
        now["still_s"] += dt_s


@compiled
def command(constants: FloatArray, now: Any, value: float, error: float, dt_s: float, limits_w: PowerLimits) -> None:
    """Set the drive voltage, then advance integral, pulse and heat balance with the power within the limits."""
    lowest_w, highest_w, steady_limit_w = limits_w
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    tau_s = of["thermal_time_constant_s"]
    gain = heat_per_value(constants, HEATING_SLOPE if error > 0.0 else COOLING_SLOPE, value) / of["response_s"]
    # With this power the heat balance is at the limit after this sample, not above it.
    warmest_w = steady_limit_w + max(0.0, steady_limit_w - now["balance_w"]) * tau_s / dt_s
    limit_w = max(min(highest_w, warmest_w), lowest_w)
    without_pulse_w = now["steady_w"] + gain * error
    wanted_w = without_pulse_w + now["pulse_j"] / of["pulse_time_s"]
    given_w = min(max(wanted_w, lowest_w), limit_w)
    by_pulse_w = given_w - min(max(without_pulse_w, lowest_w), limit_w)
    now["pulse_j"] -= dt_s * (by_pulse_w + now["pulse_j"] / tau_s)
    integral_w = gain * error * dt_s / of["integral_time_s"]
    if not ((wanted_w > limit_w and integral_w > 0.0) or (wanted_w < lowest_w and integral_w < 0.0)):
        now["steady_w"] = min(max(now["steady_w"] + integral_w, lowest_w), steady_limit_w)
    now["balance_w"] += min(dt_s / tau_s, 1.0) * (given_w - now["balance_w"])
    set_drive(constants, now, value, given_w, lowest_w, highest_w)


@compiled
def set_drive(constants: FloatArray, now: Any, value: float, given_w: float, lowest_w: float, highest_w: float) -> None:
    """Set the drive voltage of a power; at a limit of the power exactly that of the drive."""
    of = constants[:N_NUMBERS].view(NUMBERS)[0]
    if given_w == lowest_w:
        now["drive_voltage_v"] = of["sense_voltage_v"]
    elif given_w == highest_w:
        now["drive_voltage_v"] = of["maximum_voltage_v"]
    elif given_w != now["power_w"]:
        resistance = at(constants, RESISTANCE, value)
        drive_v = math.sqrt(given_w / resistance) * (resistance + of["shunt_resistance_ohm"])
        now["drive_voltage_v"] = min(max(drive_v, of["sense_voltage_v"]), of["maximum_voltage_v"])
    now["power_w"] = given_w
