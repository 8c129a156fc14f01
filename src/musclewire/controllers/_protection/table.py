"""The protection table as data: limits, states, signals, events, how long each must last, what happens then."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from enum import IntEnum
from functools import cached_property, lru_cache
from importlib.resources import files
from math import inf, isfinite
from typing import Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.errors import CallerError
from musclewire.wire import HeatBalance


class ProtectionLimits(NamedTuple):
    """Limits of a wire and ranges of its circuit, all SI. Plain numbers: the C library carries the same list.

    Attributes:
        sense_voltage_v: drive that heats by little and still lets resistance be measured.
        maximum_voltage_v: highest drive that may be commanded.
        shunt_resistance_ohm: R of Eq. 1 (Lan and Fan 2010).
        minimum_current_a: below this a driven wire counts as open.
        maximum_current_a: above this is over-current.
        maximum_power_w: above this is over-power.
        resistance_low_ohm: minimum resistance of this wire in any state.
        resistance_high_ohm: its maximum resistance.
        jump_share: change of resistance from one reading to the next, as a fraction of it, that no heating explains.
        wire_range_v: end of the range of the channel at the wire.
        shunt_range_v: end of the range of the channel at the shunt.
        readings_noisy: whether noise moves every reading, so that equal numbers in a row mean a frozen channel; 1 or 0.
        heat_capacity_j_per_k: m c of the wire.
        heat_loss_w_per_k: G, heat loss of the wire to the air per kelvin.
        ambient_temperature_k: temperature of the air.
        maximum_temperature_k: highest estimated temperature allowed.
        arriving_fraction: at most this fraction of an ordered voltage is at wire and shunt together.
    """

    sense_voltage_v: float
    maximum_voltage_v: float
    shunt_resistance_ohm: float
    minimum_current_a: float
    maximum_current_a: float
    maximum_power_w: float
    resistance_low_ohm: float
    resistance_high_ohm: float
    jump_share: float
    wire_range_v: float
    shunt_range_v: float
    readings_noisy: float
    heat_capacity_j_per_k: float
    heat_loss_w_per_k: float
    ambient_temperature_k: float
    maximum_temperature_k: float
    arriving_fraction: float = 1.0

    @property
    def heat(self) -> HeatBalance:
        """The heat balance of the wire, with a constant loss."""
        return HeatBalance(self.heat_capacity_j_per_k, self.heat_loss_w_per_k, self.ambient_temperature_k)

    def checked(self) -> ProtectionLimits:
        """Return the limits themselves. Raises CallerError if they cannot belong to a wire."""
        for name, value in self._asdict().items():
            may_be_infinite = name.startswith("maximum_") and name != "maximum_voltage_v"
            if not (value > 0.0 or name == "readings_noisy") or (not isfinite(value) and not may_be_infinite):
                raise CallerError(f"the limit {name} is {value:g} and must be above 0 and finite")
        if self.arriving_fraction > 1.0:
            raise CallerError(f"the limit arriving_fraction is {self.arriving_fraction:g} and must be at most 1")
        for lower, upper in (
            ("sense_voltage_v", "maximum_voltage_v"),
            ("minimum_current_a", "maximum_current_a"),
            ("resistance_low_ohm", "resistance_high_ohm"),
            ("ambient_temperature_k", "maximum_temperature_k"),
        ):
            if not getattr(self, lower) < getattr(self, upper) <= inf:
                raise CallerError(
                    f"the limit {lower} {getattr(self, lower):g} must be below {upper} {getattr(self, upper):g}"
                )
        return self


Action = Literal["trip", "degrade"]


class State(IntEnum):
    """What the output does; the numbers are those of the table and of the serial protocol."""

    OFF = 0
    RUN = 1
    HOLD = 2
    ARMED = 3
    TRIPPED = 4
    DEGRADED = 5


class AllowedDrive(IntEnum):
    """Which drive voltage may be out in a state."""

    NONE = 0
    COMMANDED = 1
    SENSE = 2


class Signal(IntEnum):
    """What can change the state; the numbers are those of the table."""

    ARM = 0
    COMMAND = 1
    PRESENT = 2
    MISSING = 3
    MISSING_LONG = 4
    MISSING_TOO_LONG = 5
    FAULT = 6
    REST = 7
    CLOSE = 8


class Effect(IntEnum):
    """What a transition does in addition to the change of state; the numbers are those of the table."""

    NOTHING = 0
    ARM = 1
    FOLLOW = 2
    BRIDGE = 3
    RESUME = 4
    LATCH = 5
    PAUSE = 6
    SWITCH_OFF = 7


class Event(IntEnum):
    """What has happened; the numbers are those of the table and of the serial protocol. 22 is reserved."""

    NONE = 0
    OVER_CURRENT = 1
    OVER_POWER = 2
    OVER_TEMPERATURE = 3
    WIRE_OPEN = 4
    WIRE_SHORT = 5
    RESISTANCE_OUTSIDE_WINDOW = 6
    RESISTANCE_JUMP = 7
    CHANNEL_SATURATED = 8
    CHANNEL_FROZEN = 9
    CHANNELS_SWAPPED = 10
    READING_NOT_FINITE = 11
    OUTPUT_STUCK = 12
    SUPPLY_MISSING = 13
    COMMAND_REFUSED = 14
    COMMAND_MISSING = 15
    LINK_CORRUPTED = 16
    DEVICE_LOST = 17
    CLOCK_BACKWARDS = 18
    SAMPLE_LATE = 19
    WATCHDOG = 20
    POWER_LOST = 21
    STOPPED = 23
    CLOCK_LEAPT = 24


class Transition(NamedTuple):
    """The state that a signal leads to, and what it does on the way."""

    state: State
    effect: Effect


class NumberedRow(BaseModel):
    """What every row of the table has."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    number: int = Field(ge=0, le=255)


class StateRow(NumberedRow):
    """One state: the drive that is applied in it, and what it means."""

    drive: Literal["none", "commanded", "sense"]
    output: str
    meaning: str


class EffectRow(NumberedRow):
    """One effect of a transition, in words."""

    meaning: str


class TransitionRow(BaseModel):
    """Where a signal leads to from one state, by name."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    to: str
    effect: str


class SignalRow(NumberedRow):
    """One signal: when it comes, and what it does in each state."""

    when: str
    then: dict[str, TransitionRow]


class EventRow(NumberedRow):
    """One event: when it is seen, how long it must last [s], and what happens then."""

    number: int = Field(ge=1, le=255)
    lasts_s: float = Field(ge=0.0, le=0.5)
    action: Action
    watched_by: tuple[Literal["host", "firmware", "guardian"], ...]
    when: str
    cause: str
    remedy: str


class ReservedRow(NumberedRow):
    """A name and number that older programs know and nothing uses any more."""

    kind: Literal["event", "state", "action"]
    why: str


class ProtectionTable(BaseModel):
    """All states, signals and events, and the times of what is missing [s]; refuses a table with holes."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    reading_period_s: float = Field(gt=0.0)
    delay_s: float = Field(gt=0.0)
    sense_after_s: float = Field(gt=0.0)
    trip_after_s: float = Field(gt=0.0, le=0.5)
    state: tuple[StateRow, ...]
    effect: tuple[EffectRow, ...]
    signal: tuple[SignalRow, ...]
    event: tuple[EventRow, ...]
    reserved: tuple[ReservedRow, ...]

    @model_validator(mode="after")
    def _agrees_with_the_code(self) -> ProtectionTable:
        _require_same(self.state, State)
        _require_same(self.effect, Effect)
        _require_same(self.signal, Signal)
        _require_same(self.event, Event, without=("NONE",))
        taken = {row.number for row in self.event} & {row.number for row in self.reserved if row.kind == "event"}
        if taken:
            raise ValueError(f"the event numbers {sorted(taken)} are reserved: take others")
        if self.sense_after_s >= self.trip_after_s:
            raise ValueError(
                f"sense_after_s ({self.sense_after_s:g}) must come before trip_after_s ({self.trip_after_s:g})"
            )
        return self

    @model_validator(mode="after")
    def _says_every_pair_once(self) -> ProtectionTable:
        states = {row.name for row in self.state}
        for signal in self.signal:
            if set(signal.then) != states:
                raise ValueError(f"the signal {signal.name} must say what it does in each of {sorted(states)}")
            for state, then in signal.then.items():
                if then.to not in states or then.effect.upper() not in Effect.__members__:
                    raise ValueError(f"{signal.name} in {state}: there is no state {then.to} or effect {then.effect}")
                if then.effect == "nothing" and then.to != state:
                    raise ValueError(f"{signal.name} in {state} goes to {then.to}: it needs an effect")
        return self

    @cached_property
    def transitions(self) -> tuple[tuple[Transition, ...], ...]:
        """What each signal does in each state: ``transitions[state][signal]``."""
        signals = sorted(self.signal, key=lambda row: row.number)
        states = sorted(self.state, key=lambda row: row.number)
        rows = [[signal.then[state.name] for signal in signals] for state in states]
        return tuple(
            tuple(Transition(State[then.to.upper()], Effect[then.effect.upper()]) for then in row) for row in rows
        )

    @cached_property
    def output_drives(self) -> tuple[AllowedDrive, ...]:
        """Which drive may be out in each state, by the state's number."""
        return tuple(AllowedDrive[row.drive.upper()] for row in sorted(self.state, key=lambda row: row.number))

    def row(self, event: Event) -> EventRow:
        """Return the row of an event. Raises KeyError for ``Event.NONE``, which has none."""
        return self._rows[event]

    @cached_property
    def lasts_s(self) -> tuple[float, ...]:
        """How long each event must last [s], by the event's number; 0 for a number that has no event."""
        return tuple(
            self._rows[Event(number)].lasts_s if number in self._rows else 0.0 for number in range(max(Event) + 1)
        )

    @cached_property
    def _rows(self) -> dict[int, EventRow]:
        return {Event(row.number): row for row in self.event}


def _require_same(rows: Sequence[NumberedRow], kind: type[IntEnum], without: tuple[str, ...] = ()) -> None:
    """Raise ValueError unless names and numbers of the rows are those of an enumeration, each once."""
    found = sorted((row.name.upper(), row.number) for row in rows)
    if found != sorted((item.name, item.value) for item in kind if item.name not in without):
        raise ValueError(
            f"the table's {kind.__name__.lower()}s are not those of the code: {[name.lower() for name, _ in found]}"
        )


@lru_cache(maxsize=1)
def protection_table() -> ProtectionTable:
    """Return the one protection table, read from its file and checked against the code."""
    text = (files("musclewire.controllers") / "data" / "protection.toml").read_text(encoding="utf-8")
    return ProtectionTable.model_validate(tomllib.loads(text))
