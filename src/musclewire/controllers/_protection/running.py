"""The protection of one rig, sample by sample: what ``protect.py`` makes of its state, quickly while all is sound.

A reading is sound if nothing is missing and no condition of the protection table holds; compiled code judges that.
While every reading of a driven rig is sound, the state is ``run``, nothing lasts, and the protection changes only what
it remembers of readings and the estimated temperature. A rig (``RunningProtection``) and a loop in compiled code go on
as long as that is so; what ``protect.py`` does when it is not, is written there and nowhere else. The tests hold both
to the same verdicts and the same numbers.
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
    NOTHING_LASTS,
    SATURATED_FRACTION,
    STUCK_FRACTION,
    SUPPLY_FRACTION,
    TIME_ROUNDING_S,
    ProtectionState,
    allowed_drive_v,
    armed,
    closed,
    protect_command,
    protect_missing,
    protect_reading,
    rested,
    tripped_by,
)
from musclewire.controllers._protection.table import (
    AllowedDrive,
    Effect,
    Event,
    ProtectionLimits,
    ProtectionTable,
    Signal,
    State,
    protection_table,
)

__all__ = [
    "REMEMBERED",
    "Rows",
    "RunningProtection",
    "SOUND_LIMITS",
    "SOUND_MEMORY",
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


class RunningProtection:
    """The state of a rig's protection, and what its commands and samples make of it.

    While the state is ``run``, commands are within their range and readings sound, only numbers change: the drive, the
    estimated temperature, what is remembered of readings. They are kept apart and judged by compiled code; ``state``
    puts them together. Anything else is decided by the functions of ``protect.py``.

    Parameters
    ----------
    limits
        Limits of wire and circuit, checked.
    sample_period_s
        Time between samples [s].
    """

    def __init__(self, limits: ProtectionLimits, sample_period_s: float) -> None:
        """Arm the protection; compile what judges samples, before anything is driven."""
        self._table = protection_table()
        self._limits, self._packed = limits, packed_limits(limits)
        self._highest_v = limits.maximum_voltage_v * MAXIMUM_ROUNDING
        self._periods_s = (float(sample_period_s), self._table.reading_period_s)
        self._takes_numbers_only = takes_numbers_only(self._table)
        self._block = np.zeros(4)
        self.last_reading_v = (0.0, 0.0, 0.0)
        self._become(armed(limits))
        sound_sample(self._block.copy(), self._memory.copy(), self._packed, 0.0, 0.0, 0.0, *self._periods_s)
        fills_block(self._block.copy(), 0.0, 0.0, 0.0, *self._periods_s)

    def _become(self, state: ProtectionState) -> None:
        """Take a state as a whole."""
        self._state, self._memory, self._drive_voltage_v = state, packed_memory(state), state.drive_voltage_v
        self._quick = self._takes_numbers_only and state.state is State.RUN and state.lasting_s is NOTHING_LASTS
        self.tripped = state.state is State.TRIPPED

    @property
    def state(self) -> ProtectionState:
        """State of the protection, with the last event and the estimated temperature."""
        if not self._quick:
            return self._state
        remembered = dict(zip(REMEMBERED, self._memory[0].item(), strict=True))
        return self._state._replace(drive_voltage_v=self._drive_voltage_v, **remembered)

    def command(self, drive_voltage_v: float) -> bool:
        """Take a commanded drive voltage; whether it is what may be applied. If not, ``allowed`` says what may."""
        # Neither infinity nor NaN is between these bounds.
        if self._quick and 0.0 <= drive_voltage_v <= self._highest_v:
            self._drive_voltage_v = drive_voltage_v
            return True
        self._become(protect_command(self.state, self._limits, drive_voltage_v, self._table))
        return self._quick

    def allowed(self) -> tuple[float, bool]:
        """Return the only drive voltage [V] that may be applied now, and whether it is not the commanded one."""
        if self._quick:
            return self._drive_voltage_v, False
        return allowed_drive_v(self._state, self._limits), self._state.state is not State.RUN

    def sample(self, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float) -> None:
        """Take a sample; those that come faster than the table's readings are averaged first."""
        # Any other type than float would be compiled now, with the wire driven.
        volts = float(drive_voltage_v), float(wire_voltage_v), float(shunt_voltage_v)
        block, periods_s = self._block, self._periods_s
        if self._quick:
            if sound_sample(block, self._memory, self._packed, *volts, *periods_s):
                return
        elif not fills_block(block, *volts, *periods_s):
            return
        covered_s, drive_v, wire_v, shunt_v = block.tolist()
        block[:] = 0.0
        self.last_reading_v = (drive_v, wire_v, shunt_v)
        self._become(protect_reading(self.state, self._limits, drive_v, wire_v, shunt_v, covered_s, self._table))

    def adopt_compiled_samples(self, drive_voltage_v: float, memory: Rows) -> None:
        """Take over what sound samples in compiled code have made of the memory, and the last drive of theirs."""
        self.command(drive_voltage_v)
        remembered = dict(zip(REMEMBERED, memory[0].item(), strict=True))
        self._become(self.state._replace(**remembered))

    def missing(self, event: Event, missing_s: float) -> None:
        """Take note that something has been missing for so long in total [s]: hold, then sense, then trip."""
        self._become(protect_missing(self.state, event, missing_s, self._table))

    def trip(self, event: Event) -> None:
        """Switch off by an event; the first cause stays."""
        self._become(tripped_by(self.state, event))

    def close(self) -> None:
        """Close the output; a trip keeps its cause."""
        self._become(closed(self.state))

    def rest(self) -> None:
        """Begin again after a pause: the next reading is not compared with the last."""
        self._become(rested(self.state, self._limits))
        self._block[:] = 0.0


def takes_numbers_only(table: ProtectionTable) -> bool:
    """Whether by the table an allowed command and a sound reading leave the state ``run`` as it is."""
    run = table.transitions[State.RUN]
    return (
        run[Signal.COMMAND] == (State.RUN, Effect.FOLLOW)
        and run[Signal.PRESENT] == (State.RUN, Effect.NOTHING)
        and table.output_drives[State.RUN] is AllowedDrive.COMMANDED
    )
