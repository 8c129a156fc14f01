"""The protection of those of many wires whose readings are not sound: the functions of every rig, lane by lane."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.controllers import (
    NOTHING_LASTS,
    SOUND_MEMORY,
    Event,
    ProtectionLimits,
    ProtectionState,
    State,
    allowed_drive_v,
    armed,
    protect_command,
    protect_reading,
)

NAMES = SOUND_MEMORY.names or ()


class ProtectionWatch:
    """Lanes whose protection is in another state than ``run`` with nothing that lasts; as a rule there are none."""

    def __init__(self, limits: list[ProtectionLimits], facts: NDArray[np.void], memory: NDArray[np.void]) -> None:
        """Take the limits of each lane, and the arrays of records that the compiled code works in."""
        self._limits, self._facts, self._memory = limits, facts, memory
        self._states: dict[int, ProtectionState] = {}

    def rest(self, lanes: NDArray[np.bool_]) -> None:
        """Forget the readings of some lanes: they are armed again, cold."""
        for lane in [lane for lane in self._states if lanes[lane]]:
            del self._states[lane]
        for name in NAMES:
            self._memory[name][lanes] = 0.0
        self._memory["temperature_k"][lanes] = self._facts["ambient_temperature_k"][lanes]

    def command(self, drive_v: FloatArray) -> None:
        """Replace the drives of watched lanes by those that are allowed, in place."""
        for lane, state in self._states.items():
            commanded = commanded_state(state, self._limits[lane], float(drive_v[lane]))
            self._states[lane] = commanded
            self._memory["drive_voltage_v"][lane] = drive_v[lane] = allowed_drive_v(commanded, self._limits[lane])

    def judge(self, ends: NDArray[np.void]) -> None:
        """Judge the readings that are not sound, and all of watched lanes; write the events of those that trip."""
        ends["event"] = Event.NONE
        if self._states or not ends["sound"].all():
            self._judge({*self._states, *np.flatnonzero(~ends["sound"]).tolist()}, ends)

    def _judge(self, lanes: Iterable[int], ends: NDArray[np.void]) -> None:
        for lane in lanes:
            kept, limits = self._memory[lane], self._limits[lane]
            before = self._states.pop(lane, None) or running(kept, limits)
            wire_v, shunt_v = float(ends["wire_voltage_v"][lane]), float(ends["shunt_voltage_v"][lane])
            period_s = float(self._facts["sample_period_s"][lane])
            state = protect_reading(before, limits, float(kept["drive_voltage_v"]), wire_v, shunt_v, period_s)
            if state.state is State.TRIPPED:
                ends["event"][lane] = state.event
            elif state.state is not State.RUN or state.lasting_s is not NOTHING_LASTS:
                self._states[lane] = state
            for name in NAMES:
                kept[name] = getattr(state, name)


def running(kept: np.void, limits: ProtectionLimits) -> ProtectionState:
    """Return the state of a lane that is driven and has had sound readings only."""
    remembered: dict[str, Any] = {name: float(kept[name]) for name in NAMES}
    driven = commanded_state(armed(limits), limits, float(kept["drive_voltage_v"]))
    return driven._replace(**remembered)


def commanded_state(state: ProtectionState, limits: ProtectionLimits, drive_voltage_v: float) -> ProtectionState:
    """Return the state after a command, which the amplifier's steps may have rounded to above the maximum."""
    return protect_command(state, limits, min(drive_voltage_v, limits.maximum_voltage_v))
