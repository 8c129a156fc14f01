"""The protection's arithmetic: state in, state out, the same steps as the C library and the firmware.

Which state follows which is in the table (``data/protection.toml``) and nowhere else: ``after`` is the only function
that changes the state. The others decide which signal applies. No function has a clock: the time that a reading
covers is an argument. The owner of the output calls ``allowed_drive_v`` before every change. All voltages in volts,
times in seconds.
"""

from __future__ import annotations

from math import isfinite
from typing import Generic, NamedTuple, TypeVar

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
from musclewire.physics import series_resistance_ohm

__all__ = [
    "CONDITION_EVENTS",
    "LastingConditions",
    "ProtectionState",
    "state_after",
    "allowed_drive_v",
    "armed",
    "closed",
    "protect_command",
    "protect_event",
    "protect_missing",
    "protect_reading",
    "rested",
    "tripped_by",
]

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
# A commanded maximum may have been rounded on its way.
MAXIMUM_ROUNDING = 1.0 + 1e-6
# Durations are sums of samples: this much less still counts as reached [s].
TIME_ROUNDING_S = 1e-6

# What every sample compares with: Python 3.11 takes longer to look up a member of an enumeration than to compare it.
NO_EVENT = Event.NONE
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
HEALTHY: LastingConditions[bool] = LastingConditions(*(False for _ in LastingConditions._fields))
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
        return with_drive(state, following, drive_voltage_v)
    if effect is Effect.BRIDGE:
        return state._replace(state=following, event=event, missing_s=missing_s)
    if effect is Effect.RESUME:
        return state._replace(state=following, event=Event.NONE, missing_s=0.0)
    if effect is Effect.LATCH:
        return state._replace(state=following, event=event, drive_voltage_v=0.0)
    if effect is Effect.PAUSE:
        drive_v = min(state.drive_voltage_v, drive_voltage_v)
        resting = with_drive(state, following, drive_v)
        return resting._replace(settled_ohm=0.0, wire_repeats=0.0, shunt_repeats=0.0)
    if effect is Effect.SWITCH_OFF:
        return state._replace(state=following, event=event or state.event, drive_voltage_v=0.0)
    return ProtectionState(following, Event.NONE, drive_voltage_v, state.temperature_k)  # Effect.ARM


def with_drive(state: ProtectionState, following: State, drive_voltage_v: float) -> ProtectionState:
    """Return the state with another drive; not by _replace, which takes twice as long, for a loop at 1 kHz."""
    return ProtectionState(
        following,
        state.event,
        drive_voltage_v,
        state.temperature_k,
        state.missing_s,
        state.lasting_s,
        state.settled_ohm,
        state.wire_voltage_v,
        state.shunt_voltage_v,
        state.wire_repeats,
        state.shunt_repeats,
        state.repeats_drive_v,
    )


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
    missing = missing_event(limits, drive_voltage_v, wire_voltage_v, shunt_voltage_v)
    if missing is not NO_EVENT:
        cooling = heated(state, limits, 0.0, dt_s)
        return protect_event(cooling, missing, state.missing_s + dt_s, rules)
    seen, state = conditions(state, limits, drive_voltage_v, wire_voltage_v, shunt_voltage_v, dt_s)
    state = state_after(state, PRESENT, rules)
    if seen is HEALTHY:
        return state if state.lasting_s is NOTHING_LASTS else state._replace(lasting_s=NOTHING_LASTS)
    return judged(state, seen, dt_s, rules)


def judged(
    state: ProtectionState, seen: LastingConditions[bool], dt_s: float, table: ProtectionTable
) -> ProtectionState:
    """Return the state after the conditions of a reading: the first that has lasted long enough acts."""
    lasting_s = LastingConditions(*(was + dt_s if now else 0.0 for was, now in zip(state.lasting_s, seen, strict=True)))
    state = state._replace(lasting_s=lasting_s)
    for event, now, lasted_s in zip(CONDITION_EVENTS, seen, lasting_s, strict=True):
        if now and lasted_s > table.lasts_s[event] - TIME_ROUNDING_S:
            return protect_event(state, event, lasted_s, table)
    return state


def missing_event(
    limits: ProtectionLimits, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float
) -> Event:
    """Return why a reading is missing: not finite, no supply, or no current in the wire; none otherwise."""
    if not (isfinite(wire_voltage_v) and isfinite(shunt_voltage_v)):
        return Event.READING_NOT_FINITE
    if drive_voltage_v < DRIVEN_FRACTION * limits.sense_voltage_v:
        return NO_EVENT
    if abs(wire_voltage_v) + abs(shunt_voltage_v) < SUPPLY_FRACTION * drive_voltage_v:
        return Event.SUPPLY_MISSING
    if abs(shunt_voltage_v) < limits.minimum_current_a * limits.shunt_resistance_ohm:
        return Event.WIRE_OPEN
    return NO_EVENT


def heated(state: ProtectionState, limits: ProtectionLimits, power_w: float, dt_s: float) -> ProtectionState:
    """Return the state with the temperature that a power in the wire explains (backward Euler: stable for any dt)."""
    return state._replace(temperature_k=temperature_after(state, limits, power_w, dt_s))


def temperature_after(state: ProtectionState, limits: ProtectionLimits, power_w: float, dt_s: float) -> float:
    """Return the temperature [K] of ``heated``."""
    rate = limits.heat_loss_w_per_k / limits.heat_capacity_j_per_k * dt_s
    rise = dt_s * power_w / limits.heat_capacity_j_per_k
    above = (state.temperature_k - limits.ambient_temperature_k + rise) / (1.0 + rate)
    return limits.ambient_temperature_k + above


def conditions(
    state: ProtectionState,
    limits: ProtectionLimits,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    dt_s: float,
) -> tuple[LastingConditions[bool], ProtectionState]:
    """Return which conditions hold for a reading (``HEALTHY`` if none does), and the updated state."""
    measured, resistance = measured_resistance(limits, drive_voltage_v, wire_voltage_v, shunt_voltage_v)
    outside = not limits.resistance_low_ohm <= resistance <= limits.resistance_high_ohm
    settled = state.settled_ohm
    jumped = measured and not outside and settled > 0.0 and abs(resistance - settled) > limits.jump_share * settled
    if measured and not (outside or jumped):
        settled = resistance
    state = with_reading(state, limits, drive_voltage_v, wire_voltage_v, shunt_voltage_v, dt_s, settled)
    saturated = is_saturated(limits, wire_voltage_v, shunt_voltage_v)
    reversed_ = outside and measured and swapped(limits, wire_voltage_v, shunt_voltage_v, resistance)
    current_a = shunt_voltage_v / limits.shunt_resistance_ohm
    short = resistance < SHORT_FRACTION * limits.resistance_low_ohm
    current = abs(current_a) > limits.maximum_current_a
    power = wire_voltage_v * current_a > limits.maximum_power_w
    stuck = wire_voltage_v + shunt_voltage_v > drive_voltage_v + STUCK_FRACTION * limits.maximum_voltage_v
    repeated = state.wire_repeats > 0.0 or state.shunt_repeats > 0.0
    frozen = repeated and measured and is_frozen(state, limits, drive_voltage_v, dt_s)
    hot = state.temperature_k > limits.maximum_temperature_k
    # The record costs as much as all of the above: it is built only if a condition holds.
    if not (saturated or reversed_ or short or current or power or stuck or jumped or outside or frozen or hot):
        return HEALTHY, state
    seen = LastingConditions(
        channel_saturated=saturated,
        channels_swapped=reversed_,
        wire_short=short,
        over_current=current,
        over_power=power,
        output_stuck=stuck,
        resistance_jump=jumped,
        resistance_outside_window=outside,
        channel_frozen=frozen,
        over_temperature=hot,
    )
    return seen, state


def measured_resistance(
    limits: ProtectionLimits, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float
) -> tuple[bool, float]:
    """Return whether a reading has a resistance, and the resistance [ohm].

    A reading without current has none: a value inside the window then means "no fault".
    """
    minimum_v = limits.minimum_current_a * limits.shunt_resistance_ohm
    if not (drive_voltage_v >= DRIVEN_FRACTION * limits.sense_voltage_v and abs(shunt_voltage_v) >= minimum_v):
        return False, limits.resistance_low_ohm
    return True, series_resistance_ohm(wire_voltage_v, shunt_voltage_v, limits.shunt_resistance_ohm)


def with_reading(
    state: ProtectionState,
    limits: ProtectionLimits,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    dt_s: float,
    settled_ohm: float,
) -> ProtectionState:
    """Return the state updated by a reading: the temperature from its power, and repeated values."""
    power_w = wire_voltage_v * (shunt_voltage_v / limits.shunt_resistance_ohm)
    wire_repeats = state.wire_repeats + 1.0 if wire_voltage_v == state.wire_voltage_v else 0.0
    shunt_repeats = state.shunt_repeats + 1.0 if shunt_voltage_v == state.shunt_voltage_v else 0.0
    return ProtectionState(
        state.state,
        state.event,
        state.drive_voltage_v,
        temperature_after(state, limits, power_w, dt_s),
        state.missing_s,
        state.lasting_s,
        settled_ohm,
        wire_voltage_v,
        shunt_voltage_v,
        wire_repeats,
        shunt_repeats,
        state.repeats_drive_v if wire_repeats + shunt_repeats > 0.0 else drive_voltage_v,
    )


def is_saturated(limits: ProtectionLimits, wire_voltage_v: float, shunt_voltage_v: float) -> bool:
    """Return whether a voltage is at the end of its channel's range."""
    return (
        abs(wire_voltage_v) >= SATURATED_FRACTION * limits.wire_range_v
        or abs(shunt_voltage_v) >= SATURATED_FRACTION * limits.shunt_range_v
    )


def swapped(limits: ProtectionLimits, wire_voltage_v: float, shunt_voltage_v: float, resistance_ohm: float) -> bool:
    """Return whether a channel is reversed, or the two would fit the window if they changed places."""
    if resistance_ohm < 0.0:
        return True
    if resistance_ohm >= limits.resistance_low_ohm or wire_voltage_v == 0.0:
        return False
    other_way = series_resistance_ohm(shunt_voltage_v, wire_voltage_v, limits.shunt_resistance_ohm)
    return limits.resistance_low_ohm <= other_way <= limits.resistance_high_ohm


def is_frozen(state: ProtectionState, limits: ProtectionLimits, drive_voltage_v: float, dt_s: float) -> bool:
    """Return whether equal numbers in a row cannot be chance: noise or a moved drive should have changed them."""
    repeats = max(state.wire_repeats, state.shunt_repeats)
    moved = abs(drive_voltage_v - state.repeats_drive_v) > MOVED_FRACTION * limits.maximum_voltage_v
    long = repeats >= FROZEN_READINGS and repeats * dt_s > FROZEN_S - TIME_ROUNDING_S
    return long and (limits.readings_noisy > 0.0 or moved)
