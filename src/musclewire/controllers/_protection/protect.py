"""The protection's decisions, compiled: one row of numbers, one table, the same steps as in C library and firmware.

Which state follows which is in the table (``data/protection.toml``) and nowhere else: ``follow`` alone changes the
state. What a reading shows (``conditions_in``) is one question, what follows from it another. A rig, loops in compiled
code, environments and the reference of the exported library judge by these functions. None has a clock: the time that a
reading covers is an argument. The owner of the output asks for the allowed drive before every change.
"""

from __future__ import annotations

import math

import numpy as np

from musclewire.compiled import compiled, compiled_inner
from musclewire.controllers._protection.row import (
    CONDITION_EVENTS,
    CONDITIONS,
    PROTECTION,
    ProtectionState,
    Row,
    Rows,
    rules_of,
)
from musclewire.controllers._protection.table import (
    AllowedDrive,
    Effect,
    Event,
    ProtectionLimits,
    ProtectionTable,
    Signal,
    State,
)
from musclewire.wire import warmed_k

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
# A block of samples counts as full from this much less than the period of readings [s]: its duration is a sum.
PERIOD_ROUNDING_S = 1e-9
# A sound reading makes up for this fraction of its time missing: readings of which more than a fifth keep missing, in
# any pattern, add up to the time after which the sense voltage is out.
MADE_UP_FRACTION = 0.25
MAX_OFTEN_MISSING = 2.0  # of that time: the sum grows no further
# A commanded maximum may have been rounded on its way.
MAXIMUM_ROUNDING = 1.0 + 1e-6

# Compiled code compares numbers.
NO_EVENT, NOT_FINITE, NO_SUPPLY = int(Event.NONE), int(Event.READING_NOT_FINITE), int(Event.SUPPLY_MISSING)
OPEN = int(Event.WIRE_OPEN)
REFUSED, TOO_HOT = int(Event.COMMAND_REFUSED), int(Event.OVER_TEMPERATURE)
ARM, COMMAND, PRESENT, FAULT = int(Signal.ARM), int(Signal.COMMAND), int(Signal.PRESENT), int(Signal.FAULT)
MISSING, MISSING_LONG, MISSING_TOO_LONG = (
    int(Signal.MISSING),
    int(Signal.MISSING_LONG),
    int(Signal.MISSING_TOO_LONG),
)
REST, CLOSE = int(Signal.REST), int(Signal.CLOSE)
BEGIN, FOLLOW, BRIDGE, RESUME = int(Effect.ARM), int(Effect.FOLLOW), int(Effect.BRIDGE), int(Effect.RESUME)
LATCH, PAUSE, SWITCH_OFF = int(Effect.LATCH), int(Effect.PAUSE), int(Effect.SWITCH_OFF)
NO_DRIVE, COMMANDED_DRIVE, SENSE_DRIVE = (
    int(AllowedDrive.NONE),
    int(AllowedDrive.COMMANDED),
    int(AllowedDrive.SENSE),
)
CONDITION_NUMBERS = tuple(int(event) for event in CONDITION_EVENTS)


@compiled_inner
def follow(row: Row, rules: Row, signal: int, drive_voltage_v: float, event: int, missing_s: float) -> None:
    """Change the state as the table says: by a signal with its drive, its cause and the time missing."""
    effect = rules["effects"][row["state"], signal]
    row["state"] = rules["following"][row["state"], signal]
    if effect == FOLLOW:
        row["drive_voltage_v"] = drive_voltage_v
    elif effect == BRIDGE:
        row["event"], row["missing_s"] = event, missing_s
    elif effect == RESUME:
        row["event"], row["missing_s"] = NO_EVENT, 0.0
    elif effect == LATCH:
        row["event"], row["drive_voltage_v"] = event, 0.0
    elif effect == SWITCH_OFF:
        row["drive_voltage_v"] = 0.0
        if event != NO_EVENT:
            row["event"] = event
    elif effect == PAUSE:
        row["drive_voltage_v"] = min(row["drive_voltage_v"], rules["sense_voltage_v"])
        row["settled_ohm"] = row["wire_repeats"] = row["shunt_repeats"] = 0.0
        empty_block(row)
    elif effect == BEGIN:
        forget(row)
        row["temperature_k"] = max(row["temperature_k"], rules["ambient_temperature_k"])
        row["drive_voltage_v"] = rules["sense_voltage_v"]


@compiled_inner
def forget(row: Row) -> None:
    """Forget all but the state and how warm the wire is."""
    row["event"], row["missing_s"] = NO_EVENT, 0.0
    row["often_missing_s"] = 0.0
    row["lasting_s"][:] = 0.0
    row["earlier_drive_v"] = row["recent_drive_v"] = row["recent_s"] = 0.0
    row["settled_ohm"] = row["wire_voltage_v"] = row["shunt_voltage_v"] = 0.0
    row["wire_repeats"] = row["shunt_repeats"] = row["repeats_drive_v"] = 0.0
    empty_block(row)


@compiled_inner
def empty_block(row: Row) -> None:
    """Begin a new reading."""
    row["block_s"] = row["block_drive_v"] = row["block_wire_v"] = row["block_shunt_v"] = 0.0
    row["block_ordered_v"] = 0.0


@compiled_inner
def miss(row: Row, rules: Row, event: int, missing_s: float) -> None:
    """Take note that something has been missing for so long in total: hold, then sense, then trip."""
    signal = MISSING
    if missing_s > rules["trip_after_s"] - TIME_ROUNDING_S:
        signal = MISSING_TOO_LONG
    elif max(missing_s, row["often_missing_s"]) > rules["sense_after_s"] - TIME_ROUNDING_S:
        signal = MISSING_LONG
    follow(row, rules, signal, 0.0, event, missing_s)


@compiled_inner
def happen(row: Row, rules: Row, event: int, seen_s: float) -> None:
    """Take note of an event that has been seen for so long: it trips or counts as missing, as the table says."""
    if rules["trips"][event]:
        follow(row, rules, FAULT, 0.0, event, 0.0)
    else:
        miss(row, rules, event, seen_s)


@compiled
def signalled(rows: Rows, rules: Rows, lane: int, signal: int, event: int, missing_s: float) -> tuple[float, int]:
    """Change a state by any signal but a command; return the only drive [V] allowed now, and the state."""
    if signal == MISSING:
        miss(rows[lane], rules[lane], event, missing_s)
    else:
        follow(rows[lane], rules[lane], signal, 0.0, event, 0.0)
    return allowed_drive_v(rows, rules, lane), rows[lane]["state"]


@compiled
def commanded(rows: Rows, rules: Rows, lane: int, drive_voltage_v: float) -> tuple[float, int]:
    """Take a commanded drive voltage; return the only one [V] that may be out now, and the state.

    One that is not finite or outside 0 to the maximum is the event ``command_refused``. While a reading is missing the
    command is not followed: ``hold`` and ``degraded`` end when readings are back.
    """
    row, rule = rows[lane], rules[lane]
    # Neither infinity nor NaN is between these bounds.
    if 0.0 <= drive_voltage_v <= rule["maximum_voltage_v"] * MAXIMUM_ROUNDING:
        follow(row, rule, COMMAND, drive_voltage_v, NO_EVENT, 0.0)
    else:
        happen(row, rule, REFUSED, 0.0)
    return allowed_drive_v(rows, rules, lane), row["state"]


@compiled
def allowed_drive_v(rows: Rows, rules: Rows, lane: int) -> float:
    """Return the only drive voltage [V] that may be out."""
    drive = rules[lane]["output_drives"][rows[lane]["state"]]
    if drive == COMMANDED_DRIVE:
        return float(rows[lane]["drive_voltage_v"])
    return float(rules[lane]["sense_voltage_v"]) if drive == SENSE_DRIVE else 0.0


@compiled_inner
def conditions_in(
    row: Row,
    rules: Row,
    driven: bool,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    highest_voltage_v: float,
    dt_s: float,
) -> tuple[bool, ...]:
    """Return which of ``CONDITION_EVENTS`` a reading shows, and remember it."""
    shunt_ohm, settled_ohm = rules["shunt_resistance_ohm"], row["settled_ohm"]
    current_a = shunt_voltage_v / shunt_ohm
    row["wire_repeats"] = row["wire_repeats"] + 1.0 if wire_voltage_v == row["wire_voltage_v"] else 0.0
    row["shunt_repeats"] = row["shunt_repeats"] + 1.0 if shunt_voltage_v == row["shunt_voltage_v"] else 0.0
    row["wire_voltage_v"], row["shunt_voltage_v"] = wire_voltage_v, shunt_voltage_v
    if row["wire_repeats"] + row["shunt_repeats"] == 0.0:
        row["repeats_drive_v"] = drive_voltage_v
    low_ohm, high_ohm = rules["resistance_low_ohm"], rules["resistance_high_ohm"]
    # A wire that is not driven has no resistance: a value inside the window then means "no fault".
    resistance_ohm = wire_voltage_v / shunt_voltage_v * shunt_ohm if driven else low_ohm
    outside = not low_ohm <= resistance_ohm <= high_ohm
    jump_ohm = rules["jump_share"] * settled_ohm
    jumped = driven and not outside and settled_ohm > 0.0 and abs(resistance_ohm - settled_ohm) > jump_ohm
    if driven and not outside and not jumped:
        row["settled_ohm"] = resistance_ohm
    saturated = (
        abs(wire_voltage_v) >= SATURATED_FRACTION * rules["wire_range_v"]
        or abs(shunt_voltage_v) >= SATURATED_FRACTION * rules["shunt_range_v"]
    )
    return (
        saturated,
        outside and is_swapped(rules, wire_voltage_v, shunt_voltage_v, resistance_ohm),
        resistance_ohm < SHORT_FRACTION * low_ohm,
        abs(current_a) > rules["maximum_current_a"],
        wire_voltage_v * current_a > rules["maximum_power_w"],
        wire_voltage_v + shunt_voltage_v > highest_voltage_v + STUCK_FRACTION * rules["maximum_voltage_v"],
        jumped,
        outside,
        driven and is_frozen(row, rules, drive_voltage_v, dt_s),
        row["temperature_k"] > rules["maximum_temperature_k"],
    )


@compiled_inner
def missing_event(
    rules: Row, driven: bool, drive_voltage_v: float, wire_voltage_v: float, shunt_voltage_v: float
) -> int:
    """Return why a reading is missing: not finite, no supply, or no current in the wire; 0 if it is there."""
    if not (math.isfinite(wire_voltage_v) and math.isfinite(shunt_voltage_v)):
        return NOT_FINITE
    if driven and abs(wire_voltage_v) + abs(shunt_voltage_v) < SUPPLY_FRACTION * drive_voltage_v:
        return NO_SUPPLY
    if driven and abs(shunt_voltage_v) < rules["minimum_current_a"] * rules["shunt_resistance_ohm"]:
        return OPEN
    return NO_EVENT


@compiled_inner
def highest_within_delay_v(row: Row, rules: Row, ordered_voltage_v: float, dt_s: float) -> float:
    """Return the highest drive [V] ordered in this reading or within the table's delay before it, and remember it.

    A reading may come late, or be of a drive before the last change. Two stretches of the delay are kept, the last and
    the present one: what is returned was ordered no longer ago than both together.
    """
    row["recent_drive_v"] = max(row["recent_drive_v"], ordered_voltage_v)
    highest_v = max(row["earlier_drive_v"], row["recent_drive_v"])
    row["recent_s"] += dt_s
    if row["recent_s"] > rules["delay_s"] - TIME_ROUNDING_S:
        row["earlier_drive_v"], row["recent_drive_v"], row["recent_s"] = row["recent_drive_v"], 0.0, 0.0
    return float(highest_v)


@compiled_inner
def is_swapped(rules: Row, wire_voltage_v: float, shunt_voltage_v: float, resistance_ohm: float) -> bool:
    """Whether a channel is reversed, or the two would fit the window if they changed places."""
    if resistance_ohm < 0.0:
        return True
    if resistance_ohm >= rules["resistance_low_ohm"] or wire_voltage_v == 0.0:
        return False
    other_way = shunt_voltage_v / wire_voltage_v * rules["shunt_resistance_ohm"]
    return bool(rules["resistance_low_ohm"] <= other_way <= rules["resistance_high_ohm"])


@compiled_inner
def is_frozen(row: Row, rules: Row, drive_voltage_v: float, dt_s: float) -> bool:
    """Whether so many equal numbers in a row cannot be chance: noise or a changed drive should have changed them."""
    repeats = max(row["wire_repeats"], row["shunt_repeats"])
    moved = abs(drive_voltage_v - row["repeats_drive_v"]) > MOVED_FRACTION * rules["maximum_voltage_v"]
    long = repeats >= FROZEN_READINGS and repeats * dt_s > FROZEN_S - TIME_ROUNDING_S
    return bool(long and (rules["readings_noisy"] > 0.0 or moved))


@compiled
def judged_reading(
    rows: Rows,
    rules: Rows,
    lane: int,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    ordered_voltage_v: float,
    dt_s: float,
) -> bool:
    """Take one reading that stands for ``dt_s``; whether nothing is missing and no condition of the table holds.

    ``ordered_voltage_v``, the highest drive ordered in this time, is the one that heats.
    """
    row, rule = rows[lane], rules[lane]
    if rule["output_drives"][row["state"]] == NO_DRIVE:
        return False
    highest_v = highest_within_delay_v(row, rule, ordered_voltage_v, dt_s)
    driven = drive_voltage_v >= DRIVEN_FRACTION * rule["sense_voltage_v"]
    missing = missing_event(rule, driven, drive_voltage_v, wire_voltage_v, shunt_voltage_v)
    # The larger of two powers heats the wire, as either source may be wrong: what the ordered drive gives the smallest
    # resistance that it can have, and what was read. A channel that is reversed heats it all the same.
    power_w = rule["largest_w_per_v2"] * ordered_voltage_v * ordered_voltage_v
    if missing == NO_EVENT:
        power_w = max(abs(wire_voltage_v * (shunt_voltage_v / rule["shunt_resistance_ohm"])), power_w)
    air_k, capacity, loss = rule["ambient_temperature_k"], rule["heat_capacity_j_per_k"], rule["heat_loss_w_per_k"]
    row["temperature_k"] = air_k + warmed_k(row["temperature_k"] - air_k, power_w, dt_s, capacity, loss)
    if missing != NO_EVENT:
        miss_reading(row, rule, missing, dt_s)
        return False
    row["often_missing_s"] = max(0.0, row["often_missing_s"] - MADE_UP_FRACTION * dt_s)
    seen = conditions_in(row, rule, driven, drive_voltage_v, wire_voltage_v, shunt_voltage_v, highest_v, dt_s)
    if row["often_missing_s"] > rule["sense_after_s"] - TIME_ROUNDING_S:
        row["missing_s"] = 0.0  # this one is there, but too many have been missing to drive by them
    else:
        follow(row, rule, PRESENT, 0.0, NO_EVENT, 0.0)
    return act_on_conditions(row, rule, seen, dt_s)


@compiled_inner
def miss_reading(row: Row, rules: Row, event: int, dt_s: float) -> None:
    """Take a reading that is missing: of the wire nothing else is known than its ordered drive."""
    # A gap that lasts counts until the sense voltage is out; then only further gaps do.
    if row["missing_s"] < rules["sense_after_s"] - TIME_ROUNDING_S:
        max_s = MAX_OFTEN_MISSING * rules["sense_after_s"]
        row["often_missing_s"] = min(row["often_missing_s"] + dt_s, max_s)
    if row["temperature_k"] > rules["maximum_temperature_k"]:
        happen(row, rules, TOO_HOT, dt_s)
    happen(row, rules, event, row["missing_s"] + dt_s)


@compiled_inner
def act_on_conditions(row: Row, rules: Row, seen: tuple[bool, ...], dt_s: float) -> bool:
    """Let the first condition that has lasted long enough act; whether none is seen."""
    acting, sound = -1, True
    for place in range(CONDITIONS):
        if not seen[place]:
            row["lasting_s"][place] = 0.0
            continue
        sound = False
        row["lasting_s"][place] += dt_s
        must_last_s = rules["lasts_s"][CONDITION_NUMBERS[place]]
        if acting < 0 and row["lasting_s"][place] > must_last_s - TIME_ROUNDING_S:
            acting = place
    if acting >= 0:
        happen(row, rules, CONDITION_NUMBERS[acting], row["lasting_s"][acting])
    return sound


@compiled
def judged_sample(
    rows: Rows,
    rules: Rows,
    lane: int,
    drive_voltage_v: float,
    wire_voltage_v: float,
    shunt_voltage_v: float,
    ordered_voltage_v: float,
    dt_s: float,
) -> bool:
    """Take a sample, of which several may make one reading; whether nothing is wrong with a completed one."""
    row, full_s = rows[lane], rules[lane]["reading_period_s"] - PERIOD_ROUNDING_S
    if row["block_s"] >= full_s:
        empty_block(row)
    weight = dt_s / (row["block_s"] + dt_s)
    row["block_s"] += dt_s
    row["block_ordered_v"] = max(row["block_ordered_v"], ordered_voltage_v)
    row["block_drive_v"] += weight * (drive_voltage_v - row["block_drive_v"])
    row["block_wire_v"] += weight * (wire_voltage_v - row["block_wire_v"])
    row["block_shunt_v"] += weight * (shunt_voltage_v - row["block_shunt_v"])
    if row["block_s"] < full_s:
        return True
    volts = row["block_drive_v"], row["block_wire_v"], row["block_shunt_v"], row["block_ordered_v"]
    return judged_reading(rows, rules, lane, volts[0], volts[1], volts[2], volts[3], row["block_s"])


class Protection:
    """The protection of one wire, by default a cold one: its row, and what commands and samples make of it."""

    def __init__(
        self, limits: ProtectionLimits, temperature_k: float | None = None, table: ProtectionTable | None = None
    ) -> None:
        """Arm the protection; compile all that runs with a wire driven."""
        self.rules = rules_of(limits, table)
        self.row = np.zeros(1, PROTECTION)
        self.row["temperature_k"] = limits.ambient_temperature_k if temperature_k is None else temperature_k
        commanded(self.row.copy(), self.rules, 0, 0.0)
        judged_sample(self.row.copy(), self.rules, 0, 0.0, 0.0, 0.0, 0.0, 0.01)
        self.arm()

    @property
    def state(self) -> ProtectionState:
        """State of the protection, with the last event and the estimated temperature."""
        known = ProtectionState(*self.row[0].item())
        lasting_s = tuple(self.row["lasting_s"][0].tolist())
        return known._replace(state=State(known.state), event=Event(known.event), lasting_s=lasting_s)

    @property
    def tripped(self) -> bool:
        """Whether it has switched off for good."""
        return bool(self.row["state"][0] == State.TRIPPED)

    @property
    def temperature_k(self) -> float:
        """Estimated temperature of the wire [K]."""
        return float(self.row["temperature_k"][0])

    @property
    def last_reading_v(self) -> tuple[float, float, float]:
        """Drive, wire and shunt voltage of the last reading, if it is complete."""
        drive_v, wire_v, shunt_v = self.state[-3:]
        return drive_v, wire_v, shunt_v

    @property
    def allowed_drive_v(self) -> float:
        """The only drive voltage [V] that may be out now."""
        return float(allowed_drive_v(self.row, self.rules, 0))

    def command(self, drive_voltage_v: float) -> tuple[float, int]:
        """Take a commanded drive voltage; return the only one [V] that may be out now, and the state's number."""
        # Any other type than float would be compiled now, with the wire driven.
        return commanded(self.row, self.rules, 0, float(drive_voltage_v))

    def sample(
        self,
        drive_voltage_v: float,
        wire_voltage_v: float,
        shunt_voltage_v: float,
        dt_s: float,
        ordered_voltage_v: float | None = None,
    ) -> bool:
        """Take a sample; whether all is well. The highest drive ordered in it is by default its own."""
        ordered_v = drive_voltage_v if ordered_voltage_v is None else ordered_voltage_v
        volts = float(drive_voltage_v), float(wire_voltage_v), float(shunt_voltage_v), float(ordered_v)
        return judged_sample(self.row, self.rules, 0, *volts, float(dt_s))

    def reading(
        self,
        drive_voltage_v: float,
        wire_voltage_v: float,
        shunt_voltage_v: float,
        dt_s: float,
        ordered_voltage_v: float | None = None,
    ) -> None:
        """Take a reading that stands for ``dt_s`` seconds, whose samples the caller has averaged; as ``sample``."""
        ordered_v = drive_voltage_v if ordered_voltage_v is None else ordered_voltage_v
        volts = float(drive_voltage_v), float(wire_voltage_v), float(shunt_voltage_v), float(ordered_v)
        judged_reading(self.row, self.rules, 0, *volts, float(dt_s))

    def temperature_after_k(self, ordered_voltage_v: float, dt_s: float) -> float:
        """Return the temperature [K] that the wire will count as having after so long at an ordered drive."""
        ahead = self.row.copy()
        # Nothing was read yet: without readings the ordered drive alone counts.
        judged_reading(ahead, self.rules, 0, ordered_voltage_v, math.nan, math.nan, ordered_voltage_v, dt_s)
        return float(ahead["temperature_k"][0])

    def missing(self, event: Event, missing_s: float) -> tuple[float, int]:
        """Hold, then sense, then trip, by the total time missing; return the allowed drive [V] and the state."""
        return signalled(self.row, self.rules, 0, MISSING, int(event), float(missing_s))

    def trip(self, event: Event) -> None:
        """Switch off by an event; the first cause stays."""
        signalled(self.row, self.rules, 0, FAULT, int(event), 0.0)

    def close(self) -> None:
        """Close the output; a trip keeps its cause."""
        signalled(self.row, self.rules, 0, CLOSE, NO_EVENT, 0.0)

    def rest(self) -> None:
        """Begin again after a pause at the sense voltage or less, in which no reading was taken.

        A drive held before the pause is not applied again, and the resistance of a wire that has cooled meanwhile is no
        jump. Missing readings stay missing until one arrives; the temperature is kept, which is on the safe side.
        """
        signalled(self.row, self.rules, 0, REST, NO_EVENT, 0.0)

    def arm(self) -> None:
        """Let the rig be driven, from any state: all but the wire's warmth is forgotten."""
        signalled(self.row, self.rules, 0, ARM, NO_EVENT, 0.0)
