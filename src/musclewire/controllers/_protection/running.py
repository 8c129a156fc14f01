"""The protection of one rig, sample by sample: what ``protect.py`` makes of its state, quickly while all is sound."""

from __future__ import annotations

import numpy as np

from musclewire.controllers._protection.protect import (
    MAXIMUM_ROUNDING,
    NOTHING_LASTS,
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
from musclewire.controllers._protection.sound import (
    REMEMBERED,
    Rows,
    fills_block,
    packed_limits,
    packed_memory,
    sound_sample,
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

__all__ = ["RunningProtection"]


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
