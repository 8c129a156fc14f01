"""What a protection knows, one row of numbers, and what it goes by, another, limits and table; arrays of such rows."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.controllers._protection.table import (
    Event,
    ProtectionLimits,
    ProtectionTable,
    Signal,
    State,
    protection_table,
)

# Events that are seen in a reading and must last, in the order of evaluation, here and in the C library.
CONDITION_EVENTS = (
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
CONDITIONS = len(CONDITION_EVENTS)


class ProtectionState(NamedTuple):
    """The state of a protection as it stands: a copy of its row."""

    state: State
    event: Event
    drive_voltage_v: float
    temperature_k: float
    missing_s: float = 0.0  # how long a reading or command has been missing
    often_missing_s: float = 0.0  # the same with interruptions, less what sound readings have made up for
    lasting_s: tuple[float, ...] = CONDITIONS * (0.0,)  # how long each of CONDITION_EVENTS has been seen
    earlier_drive_v: float = 0.0  # highest drive ordered in the last stretch of the table's delay
    recent_drive_v: float = 0.0  # the same in the present stretch
    recent_s: float = 0.0  # how long the present stretch has lasted
    settled_ohm: float = 0.0  # last resistance that was no jump, 0 for none
    wire_voltage_v: float = 0.0
    shunt_voltage_v: float = 0.0
    wire_repeats: float = 0.0  # how often in a row the channel gave the same number
    shunt_repeats: float = 0.0
    repeats_drive_v: float = 0.0  # drive when a repetition began
    # Time that the unfinished reading covers, whose means follow: samples may come faster than readings.
    block_s: float = 0.0
    block_ordered_v: float = 0.0  # highest drive ordered in it
    block_drive_v: float = 0.0
    block_wire_v: float = 0.0
    block_shunt_v: float = 0.0


INTEGERS, SEVERAL = ("state", "event"), {"lasting_s": (CONDITIONS,)}
PROTECTION = np.dtype(
    [
        (name, np.int64 if name in INTEGERS else np.float64, SEVERAL.get(name, ()))
        for name in ProtectionState._fields
    ]
)  # fmt: skip
STATES = len(State)
SIGNALS = len(Signal)
EVENTS = max(Event) + 1
RULES = np.dtype(
    [
        *((name, np.float64) for name in ProtectionLimits._fields),
        ("following", np.int64, (STATES, SIGNALS)),
        ("effects", np.int64, (STATES, SIGNALS)),
        ("output_drives", np.int64, (STATES,)),
        ("trips", np.int64, (EVENTS,)),
        ("lasts_s", np.float64, (EVENTS,)),
        ("sense_after_s", np.float64),
        ("trip_after_s", np.float64),
        ("reading_period_s", np.float64),
        ("delay_s", np.float64),
        ("largest_w_per_v2", np.float64),
    ]
)
# Arrays of such records, (1,) for one protection; and one of them. mypy knows no fields of either.
Rows = NDArray[np.void]
Row = Any


def rules_of(limits: ProtectionLimits, table: ProtectionTable | None = None) -> Rows:
    """Return limits and table as one record, (1,): all that decisions go by."""
    table = table or protection_table()
    rules = np.zeros(1, RULES)
    for name, value in limits._asdict().items():
        rules[name] = value
    for state in State:
        for signal in Signal:
            rules["following"][0, state, signal], rules["effects"][0, state, signal] = table.transitions[state][signal]
    rules["output_drives"] = table.output_drives
    rules["lasts_s"] = table.lasts_s
    for row in table.event:
        rules["trips"][0, row.number] = row.action == "trip"
    for name in ("sense_after_s", "trip_after_s", "reading_period_s", "delay_s"):
        rules[name] = getattr(table, name)
    rules["largest_w_per_v2"] = largest_power_w_per_v2(limits)
    return rules


def largest_power_w_per_v2(limits: ProtectionLimits) -> float:
    """Return a wire's largest power per squared drive [W/V2]: where wire and shunt have one resistance."""
    shunt_ohm = limits.shunt_resistance_ohm
    wire_ohm = min(max(shunt_ohm, limits.resistance_low_ohm), limits.resistance_high_ohm)
    return wire_ohm / (wire_ohm + shunt_ohm) ** 2 * limits.arriving_fraction**2
