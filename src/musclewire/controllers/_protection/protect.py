"""The protection's decisions: state in, state out, the same steps as the C library and the firmware.

Which state follows which is in the table (``data/protection.toml``) and nowhere else: ``state_after`` is the only
function that changes the state. The others decide which signal applies; what a reading shows is computed in
``reading.py``. No function has a clock: the time that a reading covers is an argument. The owner of the output calls
``allowed_drive_v`` before every change. All voltages in volts, times in seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from musclewire.controllers._protection.reading import (
    REMEMBERED,
    SOUND_MEMORY,
    TIME_ROUNDING_S,
    Rows,
    after_reading,
    packed_limits,
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

# A commanded maximum may have been rounded on its way.
MAXIMUM_ROUNDING = 1.0 + 1e-6

# What every sample compares with: Python 3.11 takes longer to look up a member of an enumeration than to compare it.
NO_DRIVE, COMMANDED_DRIVE, SENSE_DRIVE = AllowedDrive.NONE, AllowedDrive.COMMANDED, AllowedDrive.SENSE
COMMAND, PRESENT = Signal.COMMAND, Signal.PRESENT
NOTHING, FOLLOW = Effect.NOTHING, Effect.FOLLOW

Each = TypeVar("Each")


class LastingConditions(NamedTuple, Generic[Each]):
    """One item for each event that is seen in a reading and must last, in the order of evaluation.

    The names are those of the events. This is their only list: whether each is seen, how long it has been seen, its
    event, and the order in the C library all follow from it.
    """

    channel_saturated: Each
    channels_swapped: Each
    wire_short: Each
    over_current: Each
    over_power: Each
    output_stuck: Each
    resistance_jump: Each
    resistance_outside_window: Each
    channel_frozen: Each
    over_temperature: Each


CONDITION_EVENTS: LastingConditions[Event] = LastingConditions(
    *(Event[name.upper()] for name in LastingConditions._fields)
)
NOTHING_LASTS: LastingConditions[float] = LastingConditions(*(0.0 for _ in LastingConditions._fields))


class ProtectionState(NamedTuple):
    """The state of the protection.

    ``lasting_s`` is how long each condition has been seen; ``missing_s`` how long a reading or command has been
    missing; ``settled_ohm`` the last resistance that was no jump, 0 for none; ``wire_repeats`` and ``shunt_repeats``
    how often in a row a channel gave the same number, ``repeats_drive_v`` the drive when that began.
    """

    state: State
    event: Event
    drive_voltage_v: float
    temperature_k: float
    missing_s: float = 0.0
    lasting_s: LastingConditions[float] = NOTHING_LASTS
    settled_ohm: float = 0.0
    wire_voltage_v: float = 0.0
    shunt_voltage_v: float = 0.0
    wire_repeats: float = 0.0
    shunt_repeats: float = 0.0
    repeats_drive_v: float = 0.0


def state_after(
    state: ProtectionState,
    signal: Signal,
    table: ProtectionTable,
    *,
    drive_voltage_v: float = 0.0,
    event: Event = Event.NONE,
    missing_s: float = 0.0,
) -> ProtectionState:
    """Return the state after a signal: as the table defines it, with its effect.

    A signal may carry a drive voltage (the commanded one; the sense voltage when arming or resting), the event that is
    its cause, and how long something has been missing.
    """
    following, effect = table.transitions[state.state][signal]
    if effect is NOTHING:
        return state
    if effect is FOLLOW:
        return state._replace(state=following, drive_voltage_v=drive_voltage_v)
    if effect is Effect.BRIDGE:
        return state._replace(state=following, event=event, missing_s=missing_s)
    if effect is Effect.RESUME:
        return state._replace(state=following, event=Event.NONE, missing_s=0.0)
    if effect is Effect.LATCH:
        return state._replace(state=following, event=event, drive_voltage_v=0.0)
    if effect is Effect.PAUSE:
        drive_v = min(state.drive_voltage_v, drive_voltage_v)
        paused = state._replace(state=following, drive_voltage_v=drive_v)
        return paused._replace(settled_ohm=0.0, wire_repeats=0.0, shunt_repeats=0.0)
    if effect is Effect.SWITCH_OFF:
        return state._replace(state=following, event=event or state.event, drive_voltage_v=0.0)
    return ProtectionState(following, Event.NONE, drive_voltage_v, state.temperature_k)  # Effect.ARM


def armed(limits: ProtectionLimits) -> ProtectionState:
    """Return the state in which a rig may be driven: a cold wire, nothing commanded yet."""
    cold = ProtectionState(State.OFF, Event.NONE, 0.0, limits.ambient_temperature_k)
    return state_after(cold, Signal.ARM, protection_table(), drive_voltage_v=limits.sense_voltage_v)


def tripped_by(state: ProtectionState, event: Event) -> ProtectionState:
    """Return the state after an event that switches off at once; the first cause stays."""
    return state_after(state, Signal.FAULT, protection_table(), event=event)


def closed(state: ProtectionState) -> ProtectionState:
    """Return the state after the rig has closed its output; a trip keeps its cause."""
    return state_after(state, Signal.CLOSE, protection_table())


def rested(state: ProtectionState, limits: ProtectionLimits) -> ProtectionState:
    """Return the state after a pause at the sense voltage or less, in which no reading was taken.

    A drive held before the pause is not applied again after it, and the resistance of a wire that has cooled meanwhile
    is no jump. Missing readings stay missing until one arrives; the temperature is kept, which is on the safe side.
    """
    return state_after(state, Signal.REST, protection_table(), drive_voltage_v=limits.sense_voltage_v)


def protect_command(
    state: ProtectionState, limits: ProtectionLimits, drive_voltage_v: float, table: ProtectionTable | None = None
) -> ProtectionState:
    """Return the state after a commanded drive voltage.

    A voltage that is not finite or outside 0 to the maximum is the event ``command_refused``. While a reading is
    missing the command is not followed: ``hold`` and ``degraded`` end when readings are back.
    """
    rules = table or protection_table()
    if not (isfinite(drive_voltage_v) and 0.0 <= drive_voltage_v <= limits.maximum_voltage_v * MAXIMUM_ROUNDING):
        return protect_event(state, Event.COMMAND_REFUSED, 0.0, rules)
    return state_after(state, COMMAND, rules, drive_voltage_v=drive_voltage_v)


def allowed_drive_v(state: ProtectionState, limits: ProtectionLimits) -> float:
    """Return the only drive voltage that may be applied in this state."""
    drive = protection_table().output_drives[state.state]
    if drive is COMMANDED_DRIVE:
        return state.drive_voltage_v
    return limits.sense_voltage_v if drive is SENSE_DRIVE else 0.0


def protect_event(
    state: ProtectionState, event: Event, seen_s: float, table: ProtectionTable | None = None
) -> ProtectionState:
    """Return the state after an event that has been seen for ``seen_s``: it trips or degrades, as the table says."""
    rules = table or protection_table()
    if rules.row(event).action == "trip":
        return state_after(state, Signal.FAULT, rules, event=event)
    return protect_missing(state, event, seen_s, rules)


def protect_missing(
    state: ProtectionState, event: Event, missing_s: float, table: ProtectionTable | None = None
) -> ProtectionState:
    """Return the state after something has been missing for ``missing_s`` in total: hold, then sense, then trip."""
    rules = table or protection_table()
    signal = Signal.MISSING
    if missing_s > rules.trip_after_s - TIME_ROUNDING_S:
        signal = Signal.MISSING_TOO_LONG
    elif missing_s > rules.sense_after_s - TIME_ROUNDING_S:
        signal = Signal.MISSING_LONG
    return state_after(state, signal, rules, event=event, missing_s=missing_s)


def protect_reading(
    state: ProtectionState,
    limits: ProtectionLimits,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    dt_s: float,
    table: ProtectionTable | None = None,
) -> ProtectionState:
    """Return the state after one reading that stands for ``dt_s`` seconds at ``drive_voltage_v``."""
    rules = table or protection_table()
    if rules.output_drives[state.state] is NO_DRIVE:
        return state
    volts = float(drive_voltage_v), float(wire_voltage_v), float(shunt_voltage_v)
    seen, remembered = after_reading(packed_memory(state), packed_limits(limits), *volts, float(dt_s))
    state = with_memory(state, remembered)
    if seen < 0:
        return protect_event(state, Event(-seen), state.missing_s + dt_s, rules)
    state = state_after(state, PRESENT, rules)
    if seen == 0:
        return state if state.lasting_s is NOTHING_LASTS else state._replace(lasting_s=NOTHING_LASTS)
    return judged(state, seen, dt_s, rules)


def packed_memory(state: ProtectionState) -> Rows:
    """Return what a state remembers of readings as a structured array of length 1."""
    return np.array([tuple(getattr(state, name) for name in REMEMBERED)], SOUND_MEMORY)


def with_memory(state: ProtectionState, remembered: Sequence[float]) -> ProtectionState:
    """Return a state that remembers other numbers of readings."""
    numbers: dict[str, Any] = dict(zip(REMEMBERED, remembered, strict=True))
    return state._replace(**numbers)


def judged(state: ProtectionState, seen: int, dt_s: float, table: ProtectionTable) -> ProtectionState:
    """Return the state after the conditions of a reading, a bit each: the first that has lasted long enough acts."""
    holds = [seen >> place & 1 for place in range(len(CONDITION_EVENTS))]
    lasting_s = LastingConditions(
        *(was + dt_s if now else 0.0 for was, now in zip(state.lasting_s, holds, strict=True))
    )
    state = state._replace(lasting_s=lasting_s)
    for event, now, lasted_s in zip(CONDITION_EVENTS, holds, lasting_s, strict=True):
        if now and lasted_s > table.lasts_s[event] - TIME_ROUNDING_S:
            return protect_event(state, event, lasted_s, table)
    return state
