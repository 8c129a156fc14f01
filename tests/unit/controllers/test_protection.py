"""The protection table and the functions that follow it: every event ends off within its time, nothing healthy does."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.controllers.protected_wire import LIMITS as WIRE
from tests.unit.controllers.protected_wire import allowed_drive_v, armed, protect_command, protect_reading

from musclewire.controllers import CONDITION_EVENTS, Event, ProtectionState, State, protection_table
from musclewire.errors import CallerError

LIMITS = WIRE._replace(wire_range_v=10.0, shunt_range_v=10.0, maximum_temperature_k=473.15)
PERIODS_S = (0.01, 0.02, 0.05)
SAFE_WITHIN_S = 0.5


def run(state: ProtectionState | None = None, drive_voltage_v: float = 2.0) -> ProtectionState:
    return protect_command(state or armed(LIMITS), LIMITS, drive_voltage_v)


def reading(ohm: float, drive_v: float = 2.0, noise: float = 0.0) -> tuple[float, float]:
    """Return wire and shunt voltage of a resistance at a drive."""
    current = drive_v / (ohm + LIMITS.shunt_resistance_ohm)
    return current * ohm * (1.0 + noise), current


# What each fault makes of wire and shunt voltage at a drive of 2 V, and the event it must be called by.
FAULTS: dict[str, tuple[float, float, Event]] = {
    "wire broken": (2.0, 0.0, Event.WIRE_OPEN),
    "supply gone": (0.0, 0.0, Event.SUPPLY_MISSING),
    "bridge over the wire": (0.5, 1.4, Event.WIRE_SHORT),
    "another wire": (1.95, 0.05, Event.RESISTANCE_OUTSIDE_WINDOW),
    "channels swapped": (0.118, 1.882, Event.CHANNELS_SWAPPED),
    "channel reversed": (-1.88, 0.118, Event.CHANNELS_SWAPPED),
    "more than commanded": (9.0 * 0.3, 0.17, Event.OUTPUT_STUCK),
    "wire channel at its end": (10.0, 0.118, Event.CHANNEL_SATURATED),
    "shunt channel at its end": (1.88, 10.0, Event.CHANNEL_SATURATED),
    "not a number": (math.nan, 0.118, Event.READING_NOT_FINITE),
    "infinite": (1.88, math.inf, Event.READING_NOT_FINITE),
}


@pytest.mark.parametrize("shunt_ohm", [0.1, 1.0, 2.5])
@pytest.mark.parametrize(("ohm", "is_wire"), [(9.0, False), (11.0, True), (25.0, True), (27.0, False)])
def test_a_wire_is_known_by_its_resistance_behind_any_shunt(shunt_ohm: float, ohm: float, is_wire: bool) -> None:
    limits = LIMITS._replace(shunt_resistance_ohm=shunt_ohm)
    state = run()
    for number in range(20):
        current_a = (1.0 + 1e-6 * number) / (ohm + shunt_ohm)
        state = protect_reading(state, limits, 1.0, current_a * ohm, current_a * shunt_ohm, 0.05)
    assert state.state is (State.RUN if is_wire else State.TRIPPED)
    assert state.event is (Event.NONE if is_wire else Event.RESISTANCE_OUTSIDE_WINDOW)


@pytest.mark.parametrize("dt_s", PERIODS_S)
@pytest.mark.parametrize("fault", sorted(FAULTS))
def test_every_fault_of_a_reading_ends_off_within_half_a_second_under_its_name(fault: str, dt_s: float) -> None:
    wire_v, shunt_v, event = FAULTS[fault]
    state = protect_reading(run(), LIMITS, 2.0, *reading(16.0), dt_s)
    assert state.state is State.RUN
    elapsed_s = 0.0
    while state.state is not State.TRIPPED:
        elapsed_s += dt_s
        assert elapsed_s <= SAFE_WITHIN_S
        # Noise of a real converter: without it a dead channel would also count as frozen.
        state = protect_reading(state, LIMITS, 2.0, wire_v + 1e-7 * elapsed_s, shunt_v + 1e-7 * elapsed_s, dt_s)
    assert state.event is event
    assert allowed_drive_v(state, LIMITS) == 0.0


@pytest.mark.parametrize("dt_s", PERIODS_S)
def test_a_frozen_channel_ends_off_though_the_other_lives(dt_s: float) -> None:
    state = run()
    elapsed_s = 0.0
    while state.state is not State.TRIPPED:
        wire_v, shunt_v = reading(16.0)
        state = protect_reading(state, LIMITS, 2.0, wire_v + 1e-5 * elapsed_s, shunt_v, dt_s)
        elapsed_s += dt_s
        assert elapsed_s <= SAFE_WITHIN_S + dt_s  # the first reading is not yet a repetition
    assert state.event is Event.CHANNEL_FROZEN


def test_a_channel_without_noise_is_frozen_only_when_the_drive_has_moved() -> None:
    limits = LIMITS._replace(readings_noisy=0.0)
    state = run()
    for _ in range(100):
        state = protect_reading(state, limits, 2.0, *reading(16.0), 0.05)
    assert state.state is State.RUN
    for _ in range(10):
        state = protect_reading(state, limits, 2.3, *reading(16.0), 0.05)
    assert state.event is Event.CHANNEL_FROZEN


def test_a_jump_of_resistance_trips_and_a_single_glitch_does_not() -> None:
    state = protect_reading(run(), LIMITS, 2.0, *reading(16.0), 0.01)
    state = protect_reading(state, LIMITS, 2.0, *reading(13.0), 0.01)
    state = protect_reading(state, LIMITS, 2.0, *reading(16.0, noise=1e-6), 0.01)
    assert state.state is State.RUN
    for step in range(2):
        state = protect_reading(state, LIMITS, 2.0, *reading(13.0, noise=1e-6 * step), 0.01)
    assert state.event is Event.RESISTANCE_JUMP


def test_a_wire_that_contracts_as_fast_as_it_can_is_no_jump() -> None:
    state = run()
    for step in range(7):
        state = protect_reading(state, LIMITS, 3.6, *reading(18.0 - 0.5 * step, 3.6), 0.05)
        state = protect_command(state, LIMITS, 3.6)
    assert state.state is State.RUN


def test_temperature_by_power_reaches_what_power_over_loss_says_and_trips_above_the_limit() -> None:
    limits = LIMITS._replace(readings_noisy=0.0)
    state = run()
    wire_v, shunt_v = reading(16.0, 3.0)
    for _ in range(400):
        state = protect_reading(state, limits, 3.0, wire_v, shunt_v, 0.05)
    # What was ordered in the smallest resistance, 10 ohm behind 1 ohm, is more than what 16 ohm take.
    assert state.temperature_k == pytest.approx(295.15 + 10.0 * (3.0 / 11.0) ** 2 / 6e-3, rel=1e-6)
    for _ in range(400):
        wire_v, shunt_v = reading(11.0, 3.6)
        state = protect_reading(state, limits, 3.6, wire_v, shunt_v, 0.05)
    assert state.event in (Event.OVER_TEMPERATURE, Event.RESISTANCE_JUMP)
    warm = limits._replace(maximum_temperature_k=320.0)
    state = run()
    for _ in range(40):
        state = protect_reading(state, warm, 2.0, *reading(16.0), 0.05)
    assert state.event is Event.OVER_TEMPERATURE


@pytest.mark.parametrize(
    ("limit", "event"), [("maximum_current_a", Event.OVER_CURRENT), ("maximum_power_w", Event.OVER_POWER)]
)
def test_more_current_or_power_than_allowed_trips(limit: str, event: Event) -> None:
    limits = LIMITS._replace(**{limit: 0.1})
    state = run()
    for step in range(10):
        state = protect_reading(state, limits, 2.0, *reading(16.0, noise=1e-6 * step), 0.01)
    assert state.event is event


def test_what_is_missing_is_held_then_sensed_then_off_and_held_again_when_it_was_back() -> None:
    state = run()
    seen = []
    for _ in range(30):
        state = protect_reading(state, LIMITS, 2.0, 2.0, 0.0, 0.01)
        seen.append(state.state)
    table = protection_table()
    assert seen[0] is State.HOLD
    assert seen.index(State.DEGRADED) == round(table.sense_after_s / 0.01) - 1
    assert seen.index(State.TRIPPED) == round(table.trip_after_s / 0.01) - 1
    back = protect_reading(protect_reading(run(), LIMITS, 2.0, 2.0, 0.0, 0.05), LIMITS, 2.0, *reading(16.0), 0.05)
    assert back.state is State.RUN
    assert back.missing_s == 0.0
    assert back.event is Event.NONE


@pytest.mark.parametrize("wrong", [-1e-3, 3.61, math.nan, math.inf, -math.inf])
def test_an_impossible_command_trips_at_once(wrong: float) -> None:
    state = run(drive_voltage_v=wrong)
    assert (state.state, state.event) == (State.TRIPPED, Event.COMMAND_REFUSED)


voltages = st.floats(allow_nan=True, allow_infinity=True, width=64)
plausible = st.floats(min_value=-12.0, max_value=12.0)


@given(
    st.lists(
        st.tuples(st.one_of(plausible, voltages), st.one_of(plausible, voltages), st.one_of(plausible, voltages)),
        max_size=40,
    ),
    st.sampled_from(PERIODS_S),
)
def test_whatever_is_commanded_or_read_only_an_allowed_voltage_is_out(
    steps: list[tuple[float, float, float]], dt_s: float
) -> None:
    state = armed(LIMITS)
    off = False
    for drive, wire_v, shunt_v in steps:
        state = protect_command(state, LIMITS, drive)
        out = allowed_drive_v(state, LIMITS)
        assert 0.0 <= out <= LIMITS.maximum_voltage_v * (1.0 + 1e-6)
        assert not (off and out > 0.0)
        state = protect_reading(state, LIMITS, out, wire_v, shunt_v, dt_s)
        off = off or state.state is State.TRIPPED


HEALTHY = st.tuples(st.floats(10.5, 25.5), st.floats(0.3, 3.0), st.integers(0, 2**31))


@settings(max_examples=20)
@given(HEALTHY)
def test_no_healthy_wire_is_ever_switched_off(wire: tuple[float, float, int]) -> None:
    hold_a_healthy_wire(*wire)


@pytest.mark.full
@settings(max_examples=400)
@given(HEALTHY)
def test_none_of_400_healthy_wires_is_ever_switched_off(wire: tuple[float, float, int]) -> None:
    hold_a_healthy_wire(*wire)


def hold_a_healthy_wire(ohm: float, drive_v: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    state = run(drive_voltage_v=drive_v)
    for _ in range(200):
        wire_v, shunt_v = reading(ohm, drive_v)
        wire_v, shunt_v = wire_v + 5.5e-5 * random.standard_normal(), shunt_v + 5.5e-5 * random.standard_normal()
        state = protect_command(protect_reading(state, LIMITS, drive_v, wire_v, shunt_v, 0.05), LIMITS, drive_v)
        assert state.state is State.RUN


def test_the_table_says_everything_the_functions_do() -> None:
    table = protection_table()
    assert {row.number for row in table.event} == {event.value for event in Event} - {0}
    assert all(table.row(event).action == "trip" for event in CONDITION_EVENTS)
    assert all(row.lasts_s + max(PERIODS_S) < SAFE_WITHIN_S for row in table.event)
    assert table.trip_after_s + max(PERIODS_S) < SAFE_WITHIN_S
    assert all(row.cause and row.remedy and row.when for row in table.event)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("resistance_low_ohm", 30.0),
        ("maximum_power_w", 0.0),
        ("sense_voltage_v", math.nan),
        ("shunt_resistance_ohm", math.inf),
        ("maximum_temperature_k", 290.0),
        ("maximum_voltage_v", math.inf),
    ],
)
def test_limits_that_cannot_be_are_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(CallerError, match=name):
        LIMITS._replace(**{name: value}).checked()
