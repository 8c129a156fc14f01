"""What one reading shows, compiled: whether it is there, which conditions it meets, and how warm it leaves the wire."""

from __future__ import annotations

import math

from musclewire.compiled import compiled_inner
from musclewire.controllers._protection.row import Row
from musclewire.controllers._protection.table import Event

# A voltage counts as saturated from this fraction of its range.
SATURATED_FRACTION = 0.999
# Driven means at least this fraction of the sense voltage: below it no current is expected.
DRIVEN_FRACTION = 0.5
# Wire and shunt together may carry more than the drive by this fraction of the maximum voltage: offsets, a filter.
STUCK_FRACTION = 0.1
# Less than this fraction of the drive at wire and shunt: the supply is missing, not merely sagging.
SUPPLY_FRACTION = 0.5
# A resistance below this fraction of the window's lower end is a short circuit, not another wire.
SHORT_FRACTION = 0.5
# The drive must move by this fraction of the maximum voltage before an unmoved channel without noise counts as frozen.
MOVED_FRACTION = 0.05
# Number of equal readings in a row, and their duration [s]: by chance a number repeats only once or twice.
FROZEN_READINGS = 8.0
FROZEN_S = 0.3
# Durations are sums of samples: this much less still counts as reached [s].
TIME_ROUNDING_S = 1e-6

# Compiled code compares numbers.
NO_EVENT, NOT_FINITE, NO_SUPPLY = int(Event.NONE), int(Event.READING_NOT_FINITE), int(Event.SUPPLY_MISSING)
OPEN = int(Event.WIRE_OPEN)


@compiled_inner
def conditions_in(
    row: Row,
    rules: Row,
    driven: bool,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    dt_s: float,
) -> tuple[bool, ...]:
    """Return which of ``CONDITION_EVENTS`` a reading shows, and remember it."""
    shunt_ohm, settled_ohm = rules["shunt_resistance_ohm"], row["settled_ohm"]
    current_a = shunt_voltage_v / shunt_ohm
    row["wire_repeats"] = row["wire_repeats"] + 1.0 if wire_voltage_v == row["wire_voltage_v"] else 0.0
    row["shunt_repeats"] = row["shunt_repeats"] + 1.0 if shunt_voltage_v == row["shunt_voltage_v"] else 0.0
    row["wire_voltage_v"], row["shunt_voltage_v"] = wire_voltage_v, shunt_voltage_v
    if row["wire_repeats"] + row["shunt_repeats"] == 0.0:
        row["repeats_drive_v"] = drive_voltage_v
    low_ohm, high_ohm = rules["resistance_low_ohm"], rules["resistance_high_ohm"]
    # A wire that is not driven has no resistance: a value inside the window then means "no fault".
    resistance_ohm = wire_voltage_v / shunt_voltage_v * shunt_ohm if driven else low_ohm
    outside = not low_ohm <= resistance_ohm <= high_ohm
    jump_ohm = rules["jump_share"] * settled_ohm
    jumped = driven and not outside and settled_ohm > 0.0 and abs(resistance_ohm - settled_ohm) > jump_ohm
    if driven and not outside and not jumped:
        row["settled_ohm"] = resistance_ohm
    saturated = (
        abs(wire_voltage_v) >= SATURATED_FRACTION * rules["wire_range_v"]
        or abs(shunt_voltage_v) >= SATURATED_FRACTION * rules["shunt_range_v"]
    )
    return (
        saturated,
        outside and is_swapped(rules, wire_voltage_v, shunt_voltage_v, resistance_ohm),
        resistance_ohm < SHORT_FRACTION * low_ohm,
        abs(current_a) > rules["maximum_current_a"],
        wire_voltage_v * current_a > rules["maximum_power_w"],
        wire_voltage_v + shunt_voltage_v > drive_voltage_v + STUCK_FRACTION * rules["maximum_voltage_v"],
        jumped,
        outside,
        driven and is_frozen(row, rules, drive_voltage_v, dt_s),
        row["temperature_k"] > rules["maximum_temperature_k"],
    )


@compiled_inner
def missing_event(
    rules: Row, driven: bool, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float
) -> int:
    """Return why a reading is missing: not finite, no supply, or no current in the wire; 0 if it is there."""
    if not (math.isfinite(wire_voltage_v) and math.isfinite(shunt_voltage_v)):
        return NOT_FINITE
    if driven and abs(wire_voltage_v) + abs(shunt_voltage_v) < SUPPLY_FRACTION * drive_voltage_v:
        return NO_SUPPLY
    if driven and abs(shunt_voltage_v) < rules["minimum_current_a"] * rules["shunt_resistance_ohm"]:
        return OPEN
    return NO_EVENT


@compiled_inner
def heat(row: Row, rules: Row, power_w: float, dt_s: float) -> None:
    """Let a power in the wire act on the estimated temperature (backward Euler: stable for any ``dt_s``)."""
    rate = rules["heat_loss_w_per_k"] / rules["heat_capacity_j_per_k"] * dt_s
    rise = dt_s * power_w / rules["heat_capacity_j_per_k"]
    ambient_k = rules["ambient_temperature_k"]
    row["temperature_k"] = ambient_k + (row["temperature_k"] - ambient_k + rise) / (1.0 + rate)


@compiled_inner
def is_swapped(rules: Row, wire_voltage_v: float, shunt_voltage_v: float, resistance_ohm: float) -> bool:
    """Whether a channel is reversed, or the two would fit the window if they changed places."""
    if resistance_ohm < 0.0:
        return True
    if resistance_ohm >= rules["resistance_low_ohm"] or wire_voltage_v == 0.0:
        return False
    other_way = shunt_voltage_v / wire_voltage_v * rules["shunt_resistance_ohm"]
    return bool(rules["resistance_low_ohm"] <= other_way <= rules["resistance_high_ohm"])


@compiled_inner
def is_frozen(row: Row, rules: Row, drive_voltage_v: float, dt_s: float) -> bool:
    """Whether so many equal numbers in a row cannot be chance: noise or a changed drive should have changed them."""
    repeats = max(row["wire_repeats"], row["shunt_repeats"])
    moved = abs(drive_voltage_v - row["repeats_drive_v"]) > MOVED_FRACTION * rules["maximum_voltage_v"]
    long = repeats >= FROZEN_READINGS and repeats * dt_s > FROZEN_S - TIME_ROUNDING_S
    return bool(long and (rules["readings_noisy"] > 0.0 or moved))
