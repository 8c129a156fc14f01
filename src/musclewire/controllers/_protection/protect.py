"""The protection's decisions: state in, state out, the same steps as the C library and the firmware.

What a reading shows and what is remembered of it is one compiled function, ``after_reading``: a rig judges each of its
readings by it, and so do loops and environments in compiled code. Which state follows which is in the table
(``data/protection.toml``) and nowhere else: ``state_after`` is the only function that changes the state. A reading is
sound if nothing is missing and no condition of the table holds; while every reading of a driven rig is sound, the state
is ``run``, and ``RunningProtection`` and compiled loops go on without asking the table. No function has a clock: the
time that a reading covers is an argument. The owner of the output calls ``allowed_drive_v`` before every change. All
voltages in volts, times in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import isfinite
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner
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
