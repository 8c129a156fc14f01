"""The protection table as data: states, events, how long each must last, what happens then."""

from __future__ import annotations

import tomllib
from enum import IntEnum
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

__all__ = ["Action", "Event", "EventRow", "ProtectionTable", "State", "StateRow", "protection_table"]

Action = Literal["trip", "degrade", "report"]


class State(IntEnum):
    """What the output does; the numbers are those of the table and of the serial protocol."""

    OFF = 0
    RUN = 1
    HOLD = 2
    SENSE = 3
    TRIPPED = 4


class Event(IntEnum):
    """What has happened; the numbers are those of the table and of the serial protocol."""

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
    OVER_FORCE = 22
    STOPPED = 23


class StateRow(BaseModel):
    """One state: what is out, and what it means."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    number: int
    output: str
    meaning: str


class EventRow(BaseModel):
    """One event: when it is seen, how long it must last [s], and what happens then."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    number: int = Field(ge=1, le=255)
    lasts_s: float = Field(ge=0.0, le=0.5)
    action: Action
    watched_by: tuple[Literal["host", "firmware", "guardian"], ...]
    when: str
    cause: str
    remedy: str


class ProtectionTable(BaseModel):
    """All states and events, and the times of the degrade rule [s]."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    reading_period_s: float = Field(gt=0.0)
    sense_after_s: float = Field(gt=0.0)
    trip_after_s: float = Field(gt=0.0, le=0.5)
    state: tuple[StateRow, ...]
    event: tuple[EventRow, ...]

    @model_validator(mode="after")
    def _agrees_with_the_code(self) -> ProtectionTable:
        states = {row.name.upper(): row.number for row in self.state}
        events = {"NONE": 0, **{row.name.upper(): row.number for row in self.event}}
        for names, kind in ((states, State), (events, Event)):
            if names != {item.name: item.value for item in kind}:
                raise ValueError(f"the table's {kind.__name__.lower()}s are not those of the code")
        if self.sense_after_s >= self.trip_after_s:
            raise ValueError("sense_after_s must come before trip_after_s")
        return self

    def row(self, event: Event) -> EventRow:
        """Return the row of an event. Raises KeyError for ``Event.NONE``, which has none."""
        return self._rows()[event]

    def lasts_s(self) -> tuple[float, ...]:
        """Return for each event number how long it must last [s]; 0 where it has no row."""
        return self.durations_s

    @cached_property
    def durations_s(self) -> tuple[float, ...]:
        """What ``lasts_s`` returns, made once: it is asked for while a fault lasts, in a loop that must be on time."""
        rows = self._rows()
        return tuple(rows[event].lasts_s if event in rows else 0.0 for event in Event)

    def sentence(self, event: Event) -> str:
        """Return cause and remedy of an event as part of an error message."""
        row = self.row(event)
        return f"{row.cause}: {row.remedy}"

    def _rows(self) -> dict[Event, EventRow]:
        return {Event(row.number): row for row in self.event}


@lru_cache(maxsize=1)
def protection_table() -> ProtectionTable:
    """Return the one protection table, read from its file and checked against the code."""
    text = (files("musclewire.controllers") / "data" / "protection.toml").read_text(encoding="utf-8")
    return ProtectionTable.model_validate(tomllib.loads(text))
