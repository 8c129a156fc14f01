"""What the protection sees in a reading and remembers of it: its only arithmetic on the host, compiled.

A rig judges each of its readings by it, and so do loops and environments in compiled code. What follows from a reading
that is not sound is decided by the table, in ``protect.py``. The C library repeats it (``mw_protect.c``) and is held to
it. All voltages in volts, times in seconds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from musclewire.compiled import compiled, compiled_inner
from musclewire.controllers._protection.table import Event, ProtectionLimits

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

SOUND_LIMITS = np.dtype([(name, np.float64) for name in ProtectionLimits._fields])
# What the protection remembers of readings, by the names of its state: the estimated temperature, the last resistance
# that was no jump (0 for none), how often in a row a channel gave the same number, and the drive when that began.
REMEMBERED = (
    "temperature_k", "settled_ohm", "wire_voltage_v", "shunt_voltage_v", "wire_repeats", "shunt_repeats",
    "repeats_drive_v",
)  # fmt: skip
SOUND_MEMORY = np.dtype([(name, np.float64) for name in REMEMBERED])
NOT_FINITE, NO_SUPPLY, OPEN = int(Event.READING_NOT_FINITE), int(Event.SUPPLY_MISSING), int(Event.WIRE_OPEN)
# A structured array, and a row of one; mypy knows no fields of either.
Rows = NDArray[np.void]
Row = Any
Remembered = tuple[float, float, float, float, float, float, float]


def packed_limits(limits: ProtectionLimits) -> Rows:
    """Return the limits as a structured array of length 1."""
    return np.array([tuple(limits)], SOUND_LIMITS)


@compiled
def after_reading(
    memories: Rows, limits: Rows, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float, dt_s: float
) -> tuple[int, Remembered]:
    """Return what a reading of ``dt_s`` seconds shows, and what is remembered after it; the memory is left alone.

    0 for a sound reading; less for one that is missing, minus the number of the event; more for conditions of the
    table, a bit for each in the order of ``LastingConditions``. ``memories`` and ``limits`` are arrays of one row.
    """
    return seen_in(memories[0], limits[0], drive_voltage_v, wire_voltage_v, shunt_voltage_v, dt_s)


@compiled
def sound_reading(
    memory: Row, limits: Row, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float, dt_s: float
) -> bool:
    """Whether a reading of ``dt_s`` seconds is sound; if it is, ``memory`` has taken it."""
    seen, after = seen_in(memory, limits, drive_voltage_v, wire_voltage_v, shunt_voltage_v, dt_s)
    if seen != 0:
        return False
    memory["temperature_k"], memory["settled_ohm"] = after[0], after[1]
    memory["wire_voltage_v"], memory["shunt_voltage_v"] = after[2], after[3]
    memory["wire_repeats"], memory["shunt_repeats"], memory["repeats_drive_v"] = after[4], after[5], after[6]
    return True


@compiled_inner
def seen_in(
    memory: Row, limits: Row, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float, dt_s: float
) -> tuple[int, Remembered]:
    """Return what :func:`after_reading` returns, for rows."""
    shunt_ohm, settled_ohm = limits["shunt_resistance_ohm"], memory["settled_ohm"]
    driven = drive_voltage_v >= DRIVEN_FRACTION * limits["sense_voltage_v"]
    missing = missing_event(limits, driven, drive_voltage_v, wire_voltage_v, shunt_voltage_v)
    if missing != 0:  # without a reading the wire counts as cooling, and nothing else changes
        cooler_k = temperature_after(memory, limits, 0.0, dt_s)
        before = memory["wire_voltage_v"], memory["shunt_voltage_v"]
        repeats = memory["wire_repeats"], memory["shunt_repeats"], memory["repeats_drive_v"]
        return -missing, (cooler_k, settled_ohm, before[0], before[1], repeats[0], repeats[1], repeats[2])

    current_a = shunt_voltage_v / shunt_ohm
    power_w = wire_voltage_v * current_a
    temperature_k = temperature_after(memory, limits, power_w, dt_s)
    wire_repeats = memory["wire_repeats"] + 1.0 if wire_voltage_v == memory["wire_voltage_v"] else 0.0
    shunt_repeats = memory["shunt_repeats"] + 1.0 if shunt_voltage_v == memory["shunt_voltage_v"] else 0.0
    repeats_drive_v = memory["repeats_drive_v"] if wire_repeats + shunt_repeats > 0.0 else drive_voltage_v
    low_ohm, high_ohm = limits["resistance_low_ohm"], limits["resistance_high_ohm"]
    # A wire that is not driven has no resistance: a value inside the window then means "no fault".
    resistance_ohm = wire_voltage_v / shunt_voltage_v * shunt_ohm if driven else low_ohm
    outside = not low_ohm <= resistance_ohm <= high_ohm
    jump_ohm = limits["jump_share"] * settled_ohm
    jumped = driven and not outside and settled_ohm > 0.0 and abs(resistance_ohm - settled_ohm) > jump_ohm
    if driven and not outside and not jumped:
        settled_ohm = resistance_ohm
    saturated = (
        abs(wire_voltage_v) >= SATURATED_FRACTION * limits["wire_range_v"]
        or abs(shunt_voltage_v) >= SATURATED_FRACTION * limits["shunt_range_v"]
    )
    moved_v = abs(drive_voltage_v - repeats_drive_v)
    holds = (
        saturated,
        outside and is_swapped(limits, wire_voltage_v, shunt_voltage_v, resistance_ohm),
        resistance_ohm < SHORT_FRACTION * low_ohm,
        abs(current_a) > limits["maximum_current_a"],
        power_w > limits["maximum_power_w"],
        wire_voltage_v + shunt_voltage_v > drive_voltage_v + STUCK_FRACTION * limits["maximum_voltage_v"],
        jumped,
        outside,
        driven and is_frozen(limits, max(wire_repeats, shunt_repeats), moved_v, dt_s),
        temperature_k > limits["maximum_temperature_k"],
    )
    seen = 0
    for place in range(len(holds)):
        if holds[place]:
            seen += 1 << place
    return seen, (
        temperature_k, settled_ohm, wire_voltage_v, shunt_voltage_v, wire_repeats, shunt_repeats, repeats_drive_v,
    )  # fmt: skip


@compiled_inner
def missing_event(
    limits: Row, driven: bool, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float
) -> int:
    """Return why a reading is missing: not finite, no supply, or no current in the wire; 0 if it is there."""
    if not (math.isfinite(wire_voltage_v) and math.isfinite(shunt_voltage_v)):
        return NOT_FINITE
    if driven and abs(wire_voltage_v) + abs(shunt_voltage_v) < SUPPLY_FRACTION * drive_voltage_v:
        return NO_SUPPLY
    if driven and abs(shunt_voltage_v) < limits["minimum_current_a"] * limits["shunt_resistance_ohm"]:
        return OPEN
    return 0


@compiled_inner
def temperature_after(memory: Row, limits: Row, power_w: float, dt_s: float) -> float:
    """Return the temperature [K] that a power in the wire explains (backward Euler: stable for any ``dt_s``)."""
    rate = limits["heat_loss_w_per_k"] / limits["heat_capacity_j_per_k"] * dt_s
    rise = dt_s * power_w / limits["heat_capacity_j_per_k"]
    ambient_k = limits["ambient_temperature_k"]
    return ambient_k + (memory["temperature_k"] - ambient_k + rise) / (1.0 + rate)


@compiled_inner
def is_swapped(limits: Row, wire_voltage_v: float, shunt_voltage_v: float, resistance_ohm: float) -> bool:
    """Whether a channel is reversed, or the two would fit the window if they changed places."""
    if resistance_ohm < 0.0:
        return True
    if resistance_ohm >= limits["resistance_low_ohm"] or wire_voltage_v == 0.0:
        return False
    other_way = shunt_voltage_v / wire_voltage_v * limits["shunt_resistance_ohm"]
    return limits["resistance_low_ohm"] <= other_way <= limits["resistance_high_ohm"]


@compiled_inner
def is_frozen(limits: Row, repeats: float, moved_v: float, dt_s: float) -> bool:
    """Whether so many equal numbers in a row cannot be chance, after the drive has moved by ``moved_v``."""
    moved = moved_v > MOVED_FRACTION * limits["maximum_voltage_v"]
    long = repeats >= FROZEN_READINGS and repeats * dt_s > FROZEN_S - TIME_ROUNDING_S
    return long and (limits["readings_noisy"] > 0.0 or moved)
