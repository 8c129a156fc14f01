"""Each limit of the protection is exact: at the limit as it says, and on the other side of it one rounding further.

The numbers are powers of two, so that no arithmetic rounds.
"""

from __future__ import annotations

import math

import pytest
from tests.unit.controllers.protected_wire import armed, protect_command, protect_missing, protect_reading

from musclewire.controllers import (
    CONDITION_EVENTS,
    Event,
    Protection,
    ProtectionLimits,
    ProtectionState,
    State,
    protection_table,
)

LIMITS = ProtectionLimits(
    sense_voltage_v=0.5,
    maximum_voltage_v=10.0,
    shunt_resistance_ohm=1.0,
    minimum_current_a=0.03125,
    maximum_current_a=0.5,
    maximum_power_w=4.0,
    resistance_low_ohm=8.0,
    resistance_high_ohm=32.0,
    jump_share=0.125,
    wire_range_v=1000.0,
    shunt_range_v=1000.0,
    readings_noisy=1.0,
    heat_capacity_j_per_k=1e6,
    heat_loss_w_per_k=6e-3,
    ambient_temperature_k=295.0,
    maximum_temperature_k=373.0,
)
Reading = tuple[float, float, float]
# Drive, wire and shunt voltage at a limit; the number of the three that crosses it, in which direction; and the event.
AT: dict[str, tuple[Reading, int, float, Event]] = {
    "lowest resistance": ((2.25, 2.0, 0.25), 1, -1.0, Event.RESISTANCE_OUTSIDE_WINDOW),
    "highest resistance": ((4.125, 4.0, 0.125), 1, 1.0, Event.RESISTANCE_OUTSIDE_WINDOW),
    "a jump up": ((4.75, 4.5, 0.25), 1, 1.0, Event.RESISTANCE_JUMP),
    "a jump down": ((3.75, 3.5, 0.25), 1, -1.0, Event.RESISTANCE_JUMP),
    "current": ((5.0, 4.5, 0.5), 2, 1.0, Event.OVER_CURRENT),
    "power": ((8.5, 8.0, 0.5), 1, 1.0, Event.OVER_POWER),
    "more than commanded": ((3.25, 4.0, 0.25), 0, -1.0, Event.OUTPUT_STUCK),
}


def settled_at(resistance_ohm: float) -> ProtectionState:
    """A driven state that knows a resistance."""
    state = protect_command(armed(LIMITS), LIMITS, 4.0)
    return state._replace(settled_ohm=resistance_ohm, wire_voltage_v=9.0, shunt_voltage_v=9.0)


def seen(state: ProtectionState, limits: ProtectionLimits, reading: Reading) -> set[Event]:
    """Return what a reading shows."""
    after = protect_reading(state, limits, *reading, 0.01)
    lasting = {event for event, lasts_s in zip(CONDITION_EVENTS, after.lasting_s, strict=True) if lasts_s > 0.0}
    return lasting | ({after.event} if after.state is State.HOLD else set())


def beyond(reading: Reading, place: int, way: float) -> Reading:
    """Return the reading with one number further by the least that there is, many times over."""
    moved = list(reading)
    for _ in range(8):
        moved[place] = math.nextafter(moved[place], way * math.inf)
    return moved[0], moved[1], moved[2]


@pytest.mark.parametrize("name", AT)
def test_at_its_limit_a_reading_is_sound_and_beyond_it_is_not(name: str) -> None:
    reading, place, way, event = AT[name]
    state = settled_at(16.0 if "jump" in name or name == "more than commanded" else reading[1] / reading[2])
    assert seen(state, LIMITS, reading) == set()
    assert event in seen(state, LIMITS, beyond(reading, place, way))


@pytest.mark.parametrize("way", [1.0, -1.0], ids=["positive", "negative"])
@pytest.mark.parametrize("channel", [1, 2])
def test_a_channel_is_saturated_from_a_thousandth_below_its_range(channel: int, way: float) -> None:
    ranges = LIMITS._replace(wire_range_v=4.0 / 0.999) if channel == 1 else LIMITS._replace(shunt_range_v=0.25 / 0.999)
    reading = (4.25, 4.0 * (way if channel == 1 else 1.0), 0.25 * (way if channel == 2 else 1.0))
    state = settled_at(16.0)
    assert Event.CHANNEL_SATURATED in seen(state, ranges, beyond(reading, channel, way))
    assert Event.CHANNEL_SATURATED not in seen(state, ranges, beyond(beyond(reading, channel, -way), channel, -way))


def test_a_current_or_a_supply_that_is_just_enough_is_a_reading() -> None:
    wide = LIMITS._replace(resistance_high_ohm=1000.0)
    state = settled_at(16.0)
    least = (0.53125, 0.5, 0.03125)
    assert seen(state, LIMITS, least) == set()
    assert seen(state._replace(settled_ohm=0.0), wide, beyond(least, 2, -1.0)) == {Event.WIRE_OPEN}
    half = (4.25, 2.0, 0.125)
    assert seen(state, LIMITS, half) == set()
    assert seen(state, LIMITS, beyond(half, 0, 1.0)) == {Event.SUPPLY_MISSING}


def test_from_half_the_sense_voltage_on_a_wire_without_current_is_missing() -> None:
    state = settled_at(16.0)
    nothing = (0.25, 0.125, 0.0)
    assert seen(state, LIMITS, nothing) == {Event.WIRE_OPEN}
    assert seen(state, LIMITS, beyond(nothing, 0, -1.0)) == set()


def test_the_highest_temperature_is_allowed_and_no_more() -> None:
    state = settled_at(16.0)._replace(temperature_k=LIMITS.maximum_temperature_k)
    no_loss = LIMITS._replace(heat_loss_w_per_k=0.0, heat_capacity_j_per_k=1.0)
    idle = (0.0, 0.0, 0.0)
    assert seen(state, no_loss, idle) == set()
    hotter = state._replace(temperature_k=LIMITS.maximum_temperature_k + 1e-9)
    assert seen(hotter, no_loss, idle) == {Event.OVER_TEMPERATURE}


@pytest.mark.parametrize(
    ("volts", "followed"), [(0.0, True), (10.0, True), (10.000009, True), (10.00002, False), (-1e-300, False)]
)
def test_the_maximum_voltage_is_followed_as_it_may_have_been_rounded(volts: float, followed: bool) -> None:
    after = protect_command(armed(LIMITS), LIMITS, volts)
    assert (after.state is State.RUN) == followed
    assert (after.event is Event.COMMAND_REFUSED) != followed


def test_what_is_missing_for_exactly_its_time_degrades_and_trips_whatever_a_sum_has_rounded() -> None:
    table, run = protection_table(), protect_command(armed(LIMITS), LIMITS, 2.0)
    states = []
    for exact_s in (table.sense_after_s, table.trip_after_s):
        for missing_s in (exact_s - 1e-5, exact_s - 1e-9, exact_s):
            states.append(protect_missing(run, Event.SAMPLE_LATE, missing_s).state)
    hold, degraded, tripped = State.HOLD, State.DEGRADED, State.TRIPPED
    assert states == [hold, degraded, degraded, degraded, tripped, tripped]


@pytest.mark.parametrize("dt_s", [0.01, 0.02, 0.025, 0.03])
def test_a_channel_is_frozen_as_soon_as_it_has_repeated_for_three_tenths_of_a_second(dt_s: float) -> None:
    """As on a board, which counts whole microseconds, whatever the rounding of so many times the period."""
    protection, readings = Protection(LIMITS), 0
    protection.command(2.25)
    while not protection.tripped:
        protection.reading(2.25, 2.0, 0.25, dt_s)
        readings += 1
    assert protection.state.event is Event.CHANNEL_FROZEN
    assert (readings - 1) * dt_s == pytest.approx(0.3)


@pytest.mark.parametrize(("sound_s", "state"), [(0.0, State.DEGRADED), (0.2, State.DEGRADED), (0.28, State.HOLD)])
def test_sound_readings_make_up_for_a_quarter_of_their_time_that_readings_were_missing(
    sound_s: float, state: State
) -> None:
    """Two gaps of 80 ms are too often within 240 ms: what is missing adds up to 0.1 s then."""
    protection = Protection(LIMITS)
    protection.command(2.25)
    for volts, time_s in (((math.nan, math.nan), 0.08), ((2.0, 0.25), sound_s), ((math.nan, math.nan), 0.08)):
        for _ in range(round(time_s / 0.01)):
            protection.reading(2.25, *volts, 0.01)
    assert protection.state.state is state
