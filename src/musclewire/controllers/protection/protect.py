"""The protection's arithmetic: state in, state out, the same steps as the C library and the firmware.

It has no clock: how much time a reading stands for is told. It decides what may be out; whoever owns the output asks
``allowed_drive_v`` before every change. All voltages in volts, times in seconds.
"""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

from musclewire.controllers.protection.limits import ProtectionLimits
from musclewire.controllers.protection.table import Event, ProtectionTable, State, protection_table
from musclewire.physics.circuit import series_resistance_ohm

__all__ = [
    "ProtectionState",
    "allowed_drive_v",
    "armed",
    "closed",
    "protect_command",
    "protect_missing",
    "protect_reading",
    "rested",
    "tripped_by",
]

# A voltage counts as saturated from this share of its range.
SATURATED_SHARE = 0.999
# Driven means at least this share of the sense voltage: below it no current is expected.
DRIVEN_SHARE = 0.5
# Wire and shunt together may carry this share of the maximum voltage more than the drive: offsets and a filter's lag.
STUCK_SHARE = 0.1
# Less than this share of the drive at wire and shunt: the supply is missing, not merely sagging.
SUPPLY_SHARE = 0.5
# A resistance below this share of the window's lower end is a bridge, not a foreign wire.
SHORT_SHARE = 0.5
# The drive must move by this share of the maximum voltage before an unmoved channel without noise counts as frozen.
MOVED_SHARE = 0.05
# So many equal readings in a row, and for so long [s]: chance repeats a number once or twice.
FROZEN_READINGS = 8.0
FROZEN_S = 0.3
# A commanded maximum may have been rounded on its way.
MAXIMUM_ROUNDING = 1.0 + 1e-6
# Durations are sums of samples: this much less still counts as reached [s].
TIME_ROUNDING_S = 1e-6

# Events that must last, in the order in which they are judged; the first that has lasted long enough trips.
LASTING = (
    Event.CHANNEL_SATURATED,
    Event.CHANNELS_SWAPPED,
    Event.WIRE_SHORT,
    Event.OVER_CURRENT,
    Event.OVER_POWER,
    Event.OUTPUT_STUCK,
    Event.RESISTANCE_JUMP,
    Event.RESISTANCE_OUTSIDE_WINDOW,
    Event.CHANNEL_FROZEN,
    Event.OVER_TEMPERATURE,
)
NOTHING_LASTS = (0.0,) * len(LASTING)
HEALTHY = (False,) * len(LASTING)


class ProtectionState(NamedTuple):
    """All the protection remembers.

    ``lasting_s`` is for each of ``LASTING`` how long it has been seen; ``missing_s`` how long a reading or command has
    been missing; ``settled_ohm`` the last resistance that was no jump, 0 for none; ``wire_repeats`` and
    ``shunt_repeats`` how often in a row a channel gave the same number, ``repeats_drive_v`` the drive when that began.
    """

    state: State
    event: Event
    drive_voltage_v: float
    temperature_k: float
    missing_s: float = 0.0
    lasting_s: tuple[float, ...] = NOTHING_LASTS
    settled_ohm: float = 0.0
    wire_voltage_v: float = 0.0
    shunt_voltage_v: float = 0.0
    wire_repeats: float = 0.0
    shunt_repeats: float = 0.0
    repeats_drive_v: float = 0.0


def armed(limits: ProtectionLimits) -> ProtectionState:
    """Return the state in which a rig may be driven: a cold wire, nothing commanded yet."""
    return ProtectionState(State.SENSE, Event.NONE, limits.sense_voltage_v, limits.ambient_temperature_k)


def tripped_by(state: ProtectionState, event: Event) -> ProtectionState:
    """Return the state after an event that switches off at once; the first cause stays."""
    if state.state is State.TRIPPED:
        return state
    return state._replace(state=State.TRIPPED, event=event, drive_voltage_v=0.0)


def closed(state: ProtectionState) -> ProtectionState:
    """Return the state after the rig has let go of its output for good; what has tripped keeps saying why."""
    if state.state is State.TRIPPED:
        return state
    return state._replace(state=State.OFF, drive_voltage_v=0.0)


def rested(state: ProtectionState, limits: ProtectionLimits) -> ProtectionState:
    """Return the state after a pause at the sense voltage or less, in which no reading was taken.

    What was held before the pause is not put out again after it, and a wire that has cooled meanwhile has not jumped.
    What was missing stays missing until a reading is back; the temperature is kept, which errs on the hot side.
    """
    if state.state in (State.TRIPPED, State.OFF):
        return state
    drive_v = min(state.drive_voltage_v, limits.sense_voltage_v)
    return state._replace(
        state=State.SENSE, drive_voltage_v=drive_v, settled_ohm=0.0, wire_repeats=0.0, shunt_repeats=0.0
    )


def protect_command(state: ProtectionState, limits: ProtectionLimits, drive_voltage_v: float) -> ProtectionState:
    """Return the state after a commanded drive voltage.

    A voltage that is not finite or outside 0 to the maximum trips. While a reading is missing the command is not
    followed: ``hold`` and ``sense`` end when readings are back.
    """
    if not (isfinite(drive_voltage_v) and 0.0 <= drive_voltage_v <= limits.maximum_voltage_v * MAXIMUM_ROUNDING):
        return tripped_by(state, Event.COMMAND_REFUSED)
    if state.state is State.RUN or (state.state is State.SENSE and state.event is Event.NONE):
        # Not by _replace, which takes twice as long: this runs in every tick of a loop at 1 kHz.
        return ProtectionState(State.RUN, state.event, drive_voltage_v, *state[3:])
    return state


def allowed_drive_v(state: ProtectionState, limits: ProtectionLimits) -> float:
    """Return the only drive voltage that may be out in this state."""
    if state.state is State.SENSE:
        return limits.sense_voltage_v
    return state.drive_voltage_v if state.state in (State.RUN, State.HOLD) else 0.0


def protect_missing(
    state: ProtectionState, event: Event, missing_s: float, table: ProtectionTable | None = None
) -> ProtectionState:
    """Return the state after something has been missing for ``missing_s`` in all: hold, then sense, then trip."""
    rules = table or protection_table()
    if state.state in (State.TRIPPED, State.OFF):
        return state
    if missing_s > rules.trip_after_s - TIME_ROUNDING_S:
        return tripped_by(state, event)
    late = missing_s > rules.sense_after_s - TIME_ROUNDING_S
    following = State.SENSE if late or state.state is State.SENSE else State.HOLD
    return state._replace(state=following, event=event, missing_s=missing_s)


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
    if state.state is State.TRIPPED or state.state is State.OFF:
        return state
    missing = missing_event(limits, drive_voltage_v, wire_voltage_v, shunt_voltage_v)
    if missing is not Event.NONE:
        cooling = heated(state, limits, 0.0, dt_s)
        return protect_missing(cooling, missing, state.missing_s + dt_s, rules)
    seen, state = conditions(state, limits, drive_voltage_v, wire_voltage_v, shunt_voltage_v, dt_s)
    state = recovered(state)
    if seen == HEALTHY:
        return state if state.lasting_s is NOTHING_LASTS else state._replace(lasting_s=NOTHING_LASTS)
    lasting = tuple(was + dt_s if now else 0.0 for was, now in zip(state.lasting_s, seen, strict=True))
    state = state._replace(lasting_s=lasting)
    must_last_s = rules.lasts_s()
    for event, now, lasted in zip(LASTING, seen, lasting, strict=True):
        if now and lasted > must_last_s[event] - TIME_ROUNDING_S:
            return tripped_by(state, event)
    return state


def missing_event(
    limits: ProtectionLimits, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float
) -> Event:
    """Return why a reading is none: not finite, a drive that does not arrive, a wire without current; else none."""
    if not (isfinite(wire_voltage_v) and isfinite(shunt_voltage_v)):
        return Event.READING_NOT_FINITE
    if drive_voltage_v < DRIVEN_SHARE * limits.sense_voltage_v:
        return Event.NONE
    if abs(wire_voltage_v) + abs(shunt_voltage_v) < SUPPLY_SHARE * drive_voltage_v:
        return Event.SUPPLY_MISSING
    if abs(shunt_voltage_v) < limits.minimum_current_a * limits.shunt_resistance_ohm:
        return Event.WIRE_OPEN
    return Event.NONE


def recovered(state: ProtectionState) -> ProtectionState:
    """Return the state after a reading: what was missing is back."""
    if state.missing_s == 0.0 and state.event is Event.NONE:
        return state
    following = State.RUN if state.state in (State.HOLD, State.SENSE) else state.state
    return state._replace(state=following, event=Event.NONE, missing_s=0.0)


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
) -> tuple[tuple[bool, ...], ProtectionState]:
    """Return which of ``LASTING`` hold for a reading, and the state with what has been learned from it."""
    current_a = shunt_voltage_v / limits.shunt_resistance_ohm
    power_w = wire_voltage_v * current_a
    least_v = limits.minimum_current_a * limits.shunt_resistance_ohm
    measured = drive_voltage_v >= DRIVEN_SHARE * limits.sense_voltage_v and abs(shunt_voltage_v) >= least_v
    # A reading without current has no resistance: any in the window stands for "not wrong".
    shunt_ohm = limits.shunt_resistance_ohm
    resistance = (
        series_resistance_ohm(wire_voltage_v, shunt_voltage_v, shunt_ohm) if measured else limits.resistance_low_ohm
    )
    settled = state.settled_ohm
    inside = limits.resistance_low_ohm <= resistance <= limits.resistance_high_ohm
    jumped = measured and inside and settled > 0.0 and abs(resistance - settled) > limits.jump_share * settled
    if measured and inside and not jumped:
        settled = resistance
    temperature_k = temperature_after(state, limits, power_w, dt_s)
    repeats = repeats_after(state, drive_voltage_v, wire_voltage_v, shunt_voltage_v)
    # All at once, in the order of ProtectionState's fields: three copies of it cost more than everything else here.
    state = ProtectionState(*state[:3], temperature_k, *state[4:6], settled, wire_voltage_v, shunt_voltage_v, *repeats)
    seen = (
        abs(wire_voltage_v) >= SATURATED_SHARE * limits.wire_range_v
        or abs(shunt_voltage_v) >= SATURATED_SHARE * limits.shunt_range_v,
        measured and swapped(limits, wire_voltage_v, shunt_voltage_v, resistance),
        resistance < SHORT_SHARE * limits.resistance_low_ohm,
        abs(current_a) > limits.maximum_current_a,
        power_w > limits.maximum_power_w,
        wire_voltage_v + shunt_voltage_v > drive_voltage_v + STUCK_SHARE * limits.maximum_voltage_v,
        jumped,
        not inside,
        measured and is_frozen(state, limits, drive_voltage_v, dt_s),
        state.temperature_k > limits.maximum_temperature_k,
    )
    return seen, state


def swapped(limits: ProtectionLimits, wire_voltage_v: float, shunt_voltage_v: float, resistance_ohm: float) -> bool:
    """Tell whether a channel is reversed, or the two would fit the window if they changed places."""
    if resistance_ohm < 0.0:
        return True
    if resistance_ohm >= limits.resistance_low_ohm or wire_voltage_v == 0.0:
        return False
    other_way = series_resistance_ohm(shunt_voltage_v, wire_voltage_v, limits.shunt_resistance_ohm)
    return limits.resistance_low_ohm <= other_way <= limits.resistance_high_ohm


def repeats_after(
    state: ProtectionState, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float
) -> tuple[float, float, float]:
    """Return how often in a row each channel has given the very same number, and the drive when that began."""
    wire_repeats = state.wire_repeats + 1.0 if wire_voltage_v == state.wire_voltage_v else 0.0
    shunt_repeats = state.shunt_repeats + 1.0 if shunt_voltage_v == state.shunt_voltage_v else 0.0
    began_v = state.repeats_drive_v if wire_repeats + shunt_repeats > 0.0 else drive_voltage_v
    return wire_repeats, shunt_repeats, began_v


def is_frozen(state: ProtectionState, limits: ProtectionLimits, drive_voltage_v: float, dt_s: float) -> bool:
    """Tell whether equal numbers in a row cannot be chance: noise or a moved drive should have changed them."""
    repeats = max(state.wire_repeats, state.shunt_repeats)
    moved = abs(drive_voltage_v - state.repeats_drive_v) > MOVED_SHARE * limits.maximum_voltage_v
    long = repeats >= FROZEN_READINGS and repeats * dt_s > FROZEN_S - TIME_ROUNDING_S
    return long and (limits.readings_noisy > 0.0 or moved)
