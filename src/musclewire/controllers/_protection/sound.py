"""Whether a reading is sound, compiled: nothing is missing and no condition of the protection table holds.

While every reading of a driven rig is sound, the state is ``run``, nothing lasts, and the protection changes only what
it remembers of readings and the estimated temperature. A rig (``running.py``) and a loop in compiled code go on as
long as that is so; what ``protect.py`` does when it is not, is written there and nowhere else. The tests hold both to
the same verdicts and the same numbers.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.controllers._protection.protect import (
    DRIVEN_FRACTION,
    FROZEN_READINGS,
    FROZEN_S,
    MAXIMUM_ROUNDING,
    MOVED_FRACTION,
    SATURATED_FRACTION,
    STUCK_FRACTION,
    SUPPLY_FRACTION,
    TIME_ROUNDING_S,
    ProtectionState,
)
from musclewire.controllers._protection.table import ProtectionLimits

__all__ = [
    "SOUND_LIMITS",
    "SOUND_MEMORY",
    "REMEMBERED",
    "Rows",
    "fills_block",
    "packed_limits",
    "packed_memory",
    "sound_command",
    "sound_reading",
    "sound_sample",
]

SOUND_LIMITS = np.dtype([(name, np.float64) for name in ProtectionLimits._fields])
# What the protection remembers of readings, by the names of its state.
REMEMBERED = (
    "temperature_k", "settled_ohm", "wire_voltage_v", "shunt_voltage_v", "wire_repeats", "shunt_repeats",
    "repeats_drive_v",
)  # fmt: skip
SOUND_MEMORY = np.dtype([(name, np.float64) for name in REMEMBERED])
# A block of samples counts as full from this much less than the period of readings [s]: its duration is a sum.
PERIOD_ROUNDING_S = 1e-9
# A structured array, and a row of one; mypy knows no fields of either.
Rows = NDArray[np.void]
Row = Any


def packed_limits(limits: ProtectionLimits) -> Rows:
    """Return the limits as a structured array of length 1."""
    return np.array([tuple(limits)], SOUND_LIMITS)


def packed_memory(state: ProtectionState) -> Rows:
    """Return what a state remembers of readings as a structured array of length 1."""
    return np.array([tuple(getattr(state, name) for name in REMEMBERED)], SOUND_MEMORY)


@compiled
def sound_command(limits: Row, drive_voltage_v: float) -> bool:
    """Whether a commanded drive voltage is one that the protection follows."""
    return math.isfinite(drive_voltage_v) and 0.0 <= drive_voltage_v <= limits["maximum_voltage_v"] * MAXIMUM_ROUNDING


@compiled
def sound_reading(
    memory: Row, limits: Row, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float, dt_s: float
) -> bool:
    """Whether a reading of ``dt_s`` seconds is sound; if it is, ``memory`` has taken it."""
    shunt_ohm = limits["shunt_resistance_ohm"]
    minimum_v = limits["minimum_current_a"] * shunt_ohm
    driven = drive_voltage_v >= DRIVEN_FRACTION * limits["sense_voltage_v"]
    if not (math.isfinite(wire_voltage_v) and math.isfinite(shunt_voltage_v)):
        return False
    if driven and abs(wire_voltage_v) + abs(shunt_voltage_v) < SUPPLY_FRACTION * drive_voltage_v:
        return False
    if driven and abs(shunt_voltage_v) < minimum_v:
        return False
    current_a = shunt_voltage_v / shunt_ohm
    power_w = wire_voltage_v * current_a
    settled_ohm = memory["settled_ohm"]
    if driven:
        resistance_ohm = wire_voltage_v / shunt_voltage_v * shunt_ohm
        if not limits["resistance_low_ohm"] <= resistance_ohm <= limits["resistance_high_ohm"]:
            return False
        if settled_ohm > 0.0 and abs(resistance_ohm - settled_ohm) > limits["jump_share"] * settled_ohm:
            return False
        settled_ohm = resistance_ohm
    if (
        abs(wire_voltage_v) >= SATURATED_FRACTION * limits["wire_range_v"]
        or abs(shunt_voltage_v) >= SATURATED_FRACTION * limits["shunt_range_v"]
        or abs(current_a) > limits["maximum_current_a"]
        or power_w > limits["maximum_power_w"]
        or wire_voltage_v + shunt_voltage_v > drive_voltage_v + STUCK_FRACTION * limits["maximum_voltage_v"]
    ):
        return False
    temperature_k = temperature_after(memory, limits, power_w, dt_s)
    wire_repeats = memory["wire_repeats"] + 1.0 if wire_voltage_v == memory["wire_voltage_v"] else 0.0
    shunt_repeats = memory["shunt_repeats"] + 1.0 if shunt_voltage_v == memory["shunt_voltage_v"] else 0.0
    repeats_drive_v = memory["repeats_drive_v"] if wire_repeats + shunt_repeats > 0.0 else drive_voltage_v
    moved_v = abs(drive_voltage_v - repeats_drive_v)
    if temperature_k > limits["maximum_temperature_k"]:
        return False
    if driven and is_frozen(limits, max(wire_repeats, shunt_repeats), moved_v, dt_s):
        return False
    memory["temperature_k"], memory["settled_ohm"] = temperature_k, settled_ohm
    memory["wire_voltage_v"], memory["shunt_voltage_v"] = wire_voltage_v, shunt_voltage_v
    memory["wire_repeats"], memory["shunt_repeats"] = wire_repeats, shunt_repeats
    memory["repeats_drive_v"] = repeats_drive_v
    return True


@compiled
def temperature_after(memory: Row, limits: Row, power_w: float, dt_s: float) -> float:
    """Return the estimated temperature [K] after a power in the wire."""
    rate = limits["heat_loss_w_per_k"] / limits["heat_capacity_j_per_k"] * dt_s
    rise = dt_s * power_w / limits["heat_capacity_j_per_k"]
    ambient_k = limits["ambient_temperature_k"]
    return ambient_k + (memory["temperature_k"] - ambient_k + rise) / (1.0 + rate)


@compiled
def is_frozen(limits: Row, repeats: float, moved_v: float, dt_s: float) -> bool:
    """Whether so many equal numbers in a row cannot be chance, after the drive has moved by ``moved_v``."""
    moved = moved_v > MOVED_FRACTION * limits["maximum_voltage_v"]
    long = repeats >= FROZEN_READINGS and repeats * dt_s > FROZEN_S - TIME_ROUNDING_S
    return long and (limits["readings_noisy"] > 0.0 or moved)


@compiled
def fills_block(
    block: FloatArray,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    period_s: float,
    reading_period_s: float,
) -> bool:
    """Add a sample to a block, (4,): the time that it covers [s], means of the three voltages; whether it is full."""
    weight = period_s / (block[0] + period_s)
    block[0] += period_s
    block[1] += weight * (drive_voltage_v - block[1])
    block[2] += weight * (wire_voltage_v - block[2])
    block[3] += weight * (shunt_voltage_v - block[3])
    return block[0] >= reading_period_s - PERIOD_ROUNDING_S


@compiled
def sound_sample(
    block: FloatArray,
    memories: Rows,
    limits: Rows,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    period_s: float,
    reading_period_s: float,
) -> bool:
    """Whether a sample is sound; those that come faster than readings are judged are averaged first.

    ``memories`` and ``limits`` are arrays of one row. A full block is empty afterwards, unless its reading is not
    sound: then it still holds the reading, and the memory has not taken it.
    """
    if not fills_block(block, drive_voltage_v, wire_voltage_v, shunt_voltage_v, period_s, reading_period_s):
        return True
    if not sound_reading(memories[0], limits[0], block[1], block[2], block[3], block[0]):
        return False
    block[:] = 0.0
    return True
