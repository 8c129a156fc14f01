"""What the protection remembers of readings before, and for how long: through gaps, over pauses, until it is gone."""

from __future__ import annotations

import math

import pytest
from tests.unit.controllers.protected_wire import LIMITS, of_wire

from musclewire.controllers import Event, Protection, State, protection_table

DT_S = 0.01


def driven(drive_v: float, temperature_k: float | None = None) -> Protection:
    """Return a protection that has seen one sound reading of 17 ohm at a drive."""
    protection = Protection(LIMITS, temperature_k)
    protection.command(drive_v)
    protection.reading(*of_wire(drive_v, 17.0), DT_S)
    return protection


def through_balance_k(before_k: float, power_w: float) -> float:
    """Return the temperature after DT_S by the heat balance, of second order as everywhere in it."""
    rate = LIMITS.heat_loss_w_per_k / LIMITS.heat_capacity_j_per_k * DT_S
    rise_k = DT_S * power_w / LIMITS.heat_capacity_j_per_k * (1.0 + rate / 2.0)
    above_k = before_k - LIMITS.ambient_temperature_k + rise_k
    return LIMITS.ambient_temperature_k + above_k / (1.0 + rate + rate**2 / 2.0)


@pytest.mark.parametrize(("drive_v", "temperature_k"), [(3.0, None), (0.3, 360.0)])
def test_while_readings_are_missing_the_wire_warms_and_cools_as_by_what_was_ordered(
    drive_v: float, temperature_k: float | None
) -> None:
    protection = driven(drive_v, temperature_k)
    power_w = 10.0 * (drive_v / 11.0) ** 2  # in its smallest resistance, 10 ohm behind 1 ohm
    for _ in range(3):
        before_k = protection.temperature_k
        protection.reading(drive_v, math.nan, math.nan, DT_S)
        assert protection.temperature_k == pytest.approx(through_balance_k(before_k, power_w), abs=1e-9)
    assert (protection.temperature_k > before_k) == (drive_v > 1.0)


def frozen(protection: Protection, readings: int, dt_s: float) -> bool:
    """Return whether so many equal readings are found frozen."""
    for _ in range(readings):
        protection.reading(*of_wire(2.0, 17.0), dt_s)
    return protection.state.event == Event.CHANNEL_FROZEN


@pytest.mark.parametrize(("readings", "dt_s", "found"), [(9, 0.03, False), (12, 0.03, True), (7, 0.1, False)])
def test_readings_are_frozen_when_they_repeat_often_and_for_long(readings: int, dt_s: float, found: bool) -> None:
    """Nine in 0.3 s could be chance at a slow converter, and so could seven at any pace."""
    protection = Protection(LIMITS)
    protection.command(2.0)
    assert frozen(protection, readings, dt_s) == found


def test_a_pause_begins_the_count_of_repeats_and_the_comparison_of_resistances_anew() -> None:
    with_pause, without = Protection(LIMITS), Protection(LIMITS)
    for protection in (with_pause, without):
        protection.command(2.0)
        assert not frozen(protection, 8, 0.05)
    with_pause.rest()
    with_pause.command(2.0)
    assert not frozen(with_pause, 3, 0.05)
    assert frozen(without, 3, 0.05)

    jumped = driven(2.0)
    jumped.rest()
    jumped.command(2.0)
    jumped.reading(*of_wire(2.0, 21.0), DT_S)
    assert jumped.state.state is State.RUN
    assert max(jumped.state.lasting_s) == 0.0
    unbroken = driven(2.0)
    unbroken.reading(*of_wire(2.0, 21.0), DT_S)
    assert max(unbroken.state.lasting_s) > 0.0


@pytest.mark.parametrize("drive_v", [0.1, 2.0])
def test_after_a_pause_in_a_gap_the_drive_is_the_one_before_or_sense_whichever_is_less(drive_v: float) -> None:
    protection = Protection(LIMITS)
    protection.command(drive_v)
    protection.missing(Event.READING_NOT_FINITE, DT_S)
    protection.rest()
    protection.reading(*of_wire(LIMITS.sense_voltage_v, 17.0), DT_S)
    assert protection.state.state is State.RUN
    assert protection.allowed_drive_v == min(drive_v, LIMITS.sense_voltage_v)


def test_a_reading_has_no_samples_from_before_a_pause() -> None:
    full_s = protection_table().reading_period_s
    protection = Protection(LIMITS)
    protection.command(3.0)
    protection.sample(*of_wire(3.0, 17.0), 0.6 * full_s)
    protection.rest()
    protection.command(1.0)
    for _ in range(2):
        protection.sample(*of_wire(1.0, 20.0), 0.5 * full_s)
        assert protection.last_reading_v == pytest.approx(of_wire(1.0, 20.0))


def test_a_condition_that_was_gone_must_last_anew() -> None:
    (lasts_s,) = (row.lasts_s for row in protection_table().event if row.name == "resistance_outside_window")
    assert lasts_s > 3.0 * DT_S
    short_of_it, protection = int(lasts_s / DT_S) - 1, driven(2.0)
    for _ in range(2):
        for _ in range(short_of_it):
            protection.reading(*of_wire(2.0, 30.0), DT_S)
        assert not protection.tripped
        protection.reading(*of_wire(2.0, 17.0), DT_S)
    for _ in range(short_of_it + 2):
        protection.reading(*of_wire(2.0, 30.0), DT_S)
    assert protection.tripped
