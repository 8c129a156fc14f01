"""The protection of one rig, sample by sample: what ``protect.py`` makes of its state, quickly while all is sound.

A reading is sound if nothing is missing and no condition of the protection table holds. While every reading of a driven
rig is sound, the state is ``run``, nothing lasts, and the protection changes only what it remembers of readings. A rig
(``RunningProtection``) and a loop in compiled code go on as long as that is so; anything else is decided in
``protect.py``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.controllers._protection.protect import (
    MAXIMUM_ROUNDING,
    NOTHING_LASTS,
    ProtectionState,
    allowed_drive_v,
    armed,
    closed,
    packed_memory,
    protect_command,
    protect_missing,
    protect_reading,
    rested,
    tripped_by,
    with_memory,
)
from musclewire.controllers._protection.reading import Rows, after_reading, packed_limits, sound_reading
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

# A block of samples counts as full from this much less than the period of readings [s]: its duration is a sum.
PERIOD_ROUNDING_S = 1e-9


@compiled
def sound_command(limits: Any, drive_voltage_v: float) -> bool:
    """Whether a commanded drive voltage is one that the protection follows."""
    return math.isfinite(drive_voltage_v) and 0.0 <= drive_voltage_v <= limits["maximum_voltage_v"] * MAXIMUM_ROUNDING


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
        after_reading(self._memory, self._packed, 0.0, 0.0, 0.0, self._periods_s[0])

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
        return with_memory(self._state, self._memory[0].item())._replace(drive_voltage_v=self._drive_voltage_v)

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
        self._become(with_memory(self.state, memory[0].item()))

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
