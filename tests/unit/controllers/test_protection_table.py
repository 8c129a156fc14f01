"""The transition table: every pair of state and signal is in it, off means off, and the code does what it says."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError
from tests.unit.controllers.protected_wire import LIMITS as WIRE
from tests.unit.controllers.protected_wire import (
    allowed_drive_v,
    armed,
    armed_again,
    closed,
    protect_command,
    protect_missing,
    protect_reading,
    rested,
    tripped_by,
)

from musclewire.controllers import (
    AllowedDrive,
    Effect,
    Event,
    ProtectionState,
    ProtectionTable,
    Signal,
    State,
    protection_table,
)

LIMITS = WIRE._replace(wire_range_v=10.0, shunt_range_v=10.0, readings_noisy=0.0, maximum_temperature_k=473.15)
SOUND = (32.0 / 17.0, 2.0 / 17.0)
TABLE = protection_table()
OFF = tuple(state for state in State if TABLE.output_drives[state] is AllowedDrive.NONE)

# How each state comes about by the public functions alone.
RUNNING = protect_command(armed(LIMITS), LIMITS, 2.0)
REACHED: dict[State, ProtectionState] = {
    State.OFF: closed(RUNNING),
    State.ARMED: armed(LIMITS),
    State.RUN: RUNNING,
    State.HOLD: protect_missing(RUNNING, Event.SAMPLE_LATE, 0.0),
    State.DEGRADED: protect_missing(RUNNING, Event.SAMPLE_LATE, 0.2),
    State.TRIPPED: tripped_by(RUNNING, Event.WIRE_SHORT),
}
# The public function behind each signal.
GIVEN: dict[Signal, Any] = {
    Signal.COMMAND: lambda state: protect_command(state, LIMITS, 1.0),
    Signal.PRESENT: lambda state: protect_reading(state, LIMITS, 2.0, *SOUND, 0.05),
    Signal.MISSING: lambda state: protect_missing(state, Event.COMMAND_MISSING, 0.05),
    Signal.MISSING_LONG: lambda state: protect_missing(state, Event.COMMAND_MISSING, 0.1),
    Signal.MISSING_TOO_LONG: lambda state: protect_missing(state, Event.COMMAND_MISSING, 0.25),
    Signal.FAULT: lambda state: tripped_by(state, Event.OVER_CURRENT),
    Signal.REST: lambda state: rested(state, LIMITS),
    Signal.CLOSE: closed,
}


def test_every_state_is_reached_by_the_public_functions() -> None:
    assert {state: reached.state for state, reached in REACHED.items()} == {state: state for state in State}


@pytest.mark.parametrize("signal", GIVEN, ids=lambda signal: signal.name)
@pytest.mark.parametrize("state", State, ids=lambda state: state.name)
def test_each_function_leads_where_the_table_says(state: State, signal: Signal) -> None:
    before = REACHED[state]
    following, effect = TABLE.transitions[state][signal]
    found = GIVEN[signal](before)
    assert found.state is following
    if effect is Effect.NOTHING and signal is not Signal.PRESENT:
        assert found == before
    assert effect is not Effect.FOLLOW or allowed_drive_v(found, LIMITS) == 1.0
    assert effect is not Effect.RESUME or (found.event, found.missing_s) == (Event.NONE, 0.0)
    assert effect is not Effect.BRIDGE or found.event is Event.COMMAND_MISSING
    assert effect not in (Effect.LATCH, Effect.SWITCH_OFF) or found.drive_voltage_v == 0.0
    assert effect is not Effect.PAUSE or found.drive_voltage_v <= LIMITS.sense_voltage_v


@pytest.mark.parametrize("state", State, ids=lambda state: state.name)
def test_arming_leads_from_everywhere_to_armed_and_forgets_all_but_the_warmth(state: State) -> None:
    before = REACHED[state]._replace(temperature_k=350.0, settled_ohm=16.0)
    found = armed_again(before, LIMITS)
    assert found == armed(LIMITS)._replace(temperature_k=350.0)


def test_every_trip_ends_off_and_only_arming_leaves_off() -> None:
    for signal in (Signal.FAULT, Signal.MISSING_TOO_LONG, Signal.CLOSE):
        assert all(TABLE.transitions[state][signal].state in OFF for state in State)
    for state in OFF:
        for signal in Signal:
            assert signal is Signal.ARM or TABLE.transitions[state][signal].state in OFF
    assert all(
        TABLE.transitions[State.TRIPPED][signal].state is State.TRIPPED for signal in Signal if signal != Signal.ARM
    )


def test_the_first_cause_stays() -> None:
    assert all(
        TABLE.transitions[State.TRIPPED][signal].effect is Effect.NOTHING for signal in Signal if signal != Signal.ARM
    )
    state = REACHED[State.TRIPPED]
    for given in GIVEN.values():
        state = given(state)
    assert state.event is Event.WIRE_SHORT


def test_what_is_missing_never_puts_out_more_than_before() -> None:
    more = {AllowedDrive.NONE: 0, AllowedDrive.SENSE: 1, AllowedDrive.COMMANDED: 2}
    for state in State:
        for signal in (Signal.MISSING, Signal.MISSING_LONG, Signal.MISSING_TOO_LONG, Signal.REST):
            following = TABLE.transitions[state][signal].state
            assert more[TABLE.output_drives[following]] <= more[TABLE.output_drives[state]]


def test_armed_and_degraded_both_put_out_the_sense_voltage_and_only_one_follows_a_command() -> None:
    for state in (State.ARMED, State.DEGRADED):
        assert allowed_drive_v(REACHED[state], LIMITS) == LIMITS.sense_voltage_v
    assert allowed_drive_v(protect_command(REACHED[State.HOLD], LIMITS, 1.5), LIMITS) == 2.0
    assert allowed_drive_v(protect_command(REACHED[State.ARMED], LIMITS, 1.5), LIMITS) == 1.5
    assert allowed_drive_v(protect_command(REACHED[State.DEGRADED], LIMITS, 1.5), LIMITS) == LIMITS.sense_voltage_v


def test_a_pause_keeps_what_is_missing_missing() -> None:
    assert rested(REACHED[State.HOLD], LIMITS).state is State.DEGRADED
    assert rested(REACHED[State.RUN], LIMITS).state is State.ARMED


def changed(event: str, action: str) -> ProtectionTable:
    """Return the table with another action for an event."""
    rows = tuple(row.model_copy(update={"action": action}) if row.name == event else row for row in TABLE.event)
    return ProtectionTable.model_validate({**TABLE.model_dump(), "event": [row.model_dump() for row in rows]})


def test_the_host_does_what_the_action_of_an_event_says() -> None:
    assert protect_reading(RUNNING, LIMITS, 2.0, 2.0, 0.0, 0.01).state is State.HOLD
    assert protect_reading(RUNNING, LIMITS, 2.0, 2.0, 0.0, 0.01, changed("wire_open", "trip")).state is State.TRIPPED
    assert protect_command(RUNNING, LIMITS, 9.0).state is State.TRIPPED
    assert protect_command(RUNNING, LIMITS, 9.0, changed("command_refused", "degrade")).state is State.HOLD
    power = LIMITS._replace(maximum_power_w=0.1)
    lenient, state = changed("over_power", "degrade"), RUNNING
    states = []
    for _ in range(30):
        state = protect_reading(state, power, 2.0, *SOUND, 0.01, lenient)
        states.append(state.state)
    # Seen for its own time first, then bridged as what is missing is, then off for good.
    assert [states.count(one) for one in (State.RUN, State.HOLD, State.DEGRADED)] == [4, 5, 15]
    assert (state.state, state.event) == (State.TRIPPED, Event.OVER_POWER)


def broken(change: Any) -> dict[str, Any]:
    document = TABLE.model_dump()
    change(document)
    return document


def signal_named(document: dict[str, Any], name: str) -> dict[str, Any]:
    return next(row for row in document["signal"] if row["name"] == name)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda table: signal_named(table, "command")["then"].pop("hold"), "the signal command must say"),
        (
            lambda table: signal_named(table, "fault")["then"]["run"].update(to="away"),
            "fault in run: there is no state",
        ),
        (lambda table: signal_named(table, "fault")["then"]["run"].update(effect="none"), "or effect none"),
        (lambda table: table.update(signal=table["signal"][1:]), "signals are not those of the code"),
        (lambda table: table.update(state=table["state"][:5]), "states are not those of the code"),
        (lambda table: table["event"][0].update(action="report"), "action"),
        (lambda table: table["event"][0].update(number=0), "number"),
        (lambda table: table["reserved"][0].update(number=1), "reserved"),
        (lambda table: table.update(sense_after_s=0.3), "must come before trip_after_s"),
    ],
)
def test_a_table_with_a_hole_or_a_name_that_is_none_is_refused(change: Any, says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        ProtectionTable.model_validate(broken(change))
