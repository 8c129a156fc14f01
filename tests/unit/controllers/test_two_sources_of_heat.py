"""A wire counts as heated by the larger of what was read and what was ordered; numbers computed by hand."""

from __future__ import annotations

import math

import pytest
from tests.unit.controllers.protected_wire import LIMITS, Reading, of_wire

from musclewire.controllers import Event, Protection, State, protection_table
from musclewire.errors import CallerError

# 10 ohm, the smallest resistance of this wire, behind 1 ohm at 2 V: 10 x (2/11)^2 = 0.3306 W. Over 0.05 s that warms
# 5.4 mJ/K by 3.0609 K, less what 6 mW/K give off meanwhile, 0.05 x 6/5.4 = 0.05556 of it a step: of x = 0.05556
# (1 + x/2) / (1 + x + x^2/2) = 0.972263 is left.
ORDERED_2_V_K = 2.97601
# A reading of 1.9 V and 0.3 A: 0.57 W. 0.05 x 0.57 / 5.4e-3 = 5.27778 K, times 0.972263.
READ_570_MW_K = 5.13139


def warmed_k(reading: Reading, ordered_v: float | None = None, dt_s: float = 0.05) -> float:
    protection = Protection(LIMITS)
    protection.reading(*reading, dt_s, ordered_v)
    return protection.temperature_k - LIMITS.ambient_temperature_k


@pytest.mark.parametrize("factor", [1.0, 0.8, 0.6, 0.3])
def test_readings_that_are_too_small_do_not_make_the_wire_count_as_cooler(factor: float) -> None:
    drive_v, wire_v, shunt_v = of_wire(2.0, 17.0)
    assert warmed_k((drive_v, factor * wire_v, factor * shunt_v)) == pytest.approx(ORDERED_2_V_K, rel=1e-5)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_more_power_than_was_ordered_counts_if_it_is_read_also_on_a_reversed_channel(sign: float) -> None:
    assert warmed_k((2.0, sign * 1.9, 0.3)) == pytest.approx(READ_570_MW_K, rel=1e-5)


@pytest.mark.parametrize("volts", [(math.nan, 0.1), (1.9, math.inf), (0.0, 0.0), (2.0, 0.0)])
def test_the_wire_of_a_missing_reading_counts_as_heated_by_what_was_ordered(volts: tuple[float, float]) -> None:
    assert warmed_k((2.0, *volts)) == pytest.approx(ORDERED_2_V_K, rel=1e-5)


def test_the_highest_drive_ordered_in_a_reading_heats_whatever_is_out_at_its_end() -> None:
    assert warmed_k(of_wire(0.3, 17.0), ordered_v=2.0) == pytest.approx(ORDERED_2_V_K, rel=1e-5)


def test_the_highest_drive_of_fast_samples_heats_for_the_whole_reading() -> None:
    protection = Protection(LIMITS)
    for drive_v in (2.0, 0.0):
        protection.sample(drive_v, 0.0, 0.0, 0.005)
    # 0.01 x 0.330579 / 5.4e-3 = 0.612183 K; x = 0.011111, (1 + x/2) / (1 + x + x^2/2) = 0.994445.
    assert protection.temperature_k - LIMITS.ambient_temperature_k == pytest.approx(0.608782, rel=1e-5)
    protection.sample(0.0, 0.0, 0.0, 0.005)
    protection.sample(0.0, 0.0, 0.0, 0.005)
    # Without a drive it falls by 1 + x + x^2/2 = 1.011173.
    assert protection.temperature_k - LIMITS.ambient_temperature_k == pytest.approx(0.608782 / 1.011173, rel=1e-5)


@pytest.mark.parametrize("dt_s", [0.01, 0.05, 0.25, 0.5])
def test_long_readings_warm_the_wire_as_the_heat_balance_does(dt_s: float) -> None:
    """Against its closed form, T = T_end (1 - exp(-t G/C)): readings of half a second are within 3 % of the end."""
    protection = Protection(LIMITS._replace(readings_noisy=0.0))
    end_k, rate_per_s = 10.0 * (2.0 / 11.0) ** 2 / 6e-3, 6e-3 / 5.4e-3
    for number in range(1, round(2.0 / dt_s) + 1):
        protection.reading(*of_wire(2.0, 17.0), dt_s)
        exact_k = end_k * -math.expm1(-number * dt_s * rate_per_s)
        assert protection.temperature_k - LIMITS.ambient_temperature_k == pytest.approx(exact_k, abs=0.03 * end_k)


def test_what_is_known_to_arrive_of_an_order_heats_by_its_square() -> None:
    protection = Protection(LIMITS._replace(arriving_fraction=0.9).checked())
    protection.reading(*of_wire(1.8, 17.0), 0.05, 2.0)
    assert protection.temperature_k - LIMITS.ambient_temperature_k == pytest.approx(0.81 * ORDERED_2_V_K, rel=1e-5)
    with pytest.raises(CallerError, match=r"arriving_fraction is 1\.1 and must be at most 1"):
        LIMITS._replace(arriving_fraction=1.1).checked()


class Driven:
    """A protection of a wire that is driven, and readings of whatever was out when they were taken."""

    def __init__(self, period_s: float) -> None:
        self.protection = Protection(LIMITS._replace(maximum_temperature_k=1e4))
        self.period_s, self.readings = period_s, 0
        for _ in range(round(0.5 / period_s)):
            self.read(3.0, of=3.0)

    def read(self, drive_v: float, *, of: float, covered_s: float | None = None) -> None:
        """Order a drive and take a reading of one that was, with a microvolt of noise."""
        self.readings += 1
        _, wire_v, shunt_v = of_wire(of, 17.0)
        noise_v = 1e-6 * (self.readings % 3)
        self.protection.command(drive_v)
        self.protection.reading(drive_v, wire_v + noise_v, shunt_v + noise_v, covered_s or self.period_s)

    def sound(self) -> bool:
        """Whether nothing was seen in the last reading."""
        state = self.protection.state
        return state.state is State.RUN and max(state.lasting_s) == 0.0


@pytest.mark.parametrize("covered_s", [0.05, 0.1, 0.24, 1.0])
def test_a_late_reading_of_the_earlier_drive_is_no_stuck_output(covered_s: float) -> None:
    driven = Driven(0.05)
    driven.read(1.0, of=3.0, covered_s=covered_s)
    assert driven.sound()


@pytest.mark.parametrize("period_s", [0.01, 0.016, 0.025, 0.05])
def test_readings_that_lag_by_the_delay_show_no_stuck_output_while_the_drive_falls(period_s: float) -> None:
    driven, lag = Driven(period_s), math.floor(protection_table().delay_s / period_s + 1e-9)
    drives_v = [3.0] * (lag + 1)
    for _ in range(20):
        drives_v.append(max(0.6, drives_v[-1] - 0.4))
        driven.read(drives_v[-1], of=drives_v[-1 - lag])
        assert driven.sound()


@pytest.mark.parametrize("phase", range(6))
@pytest.mark.parametrize("period_s", [0.01, 0.017, 0.024, 0.026, 0.038, 0.049, 0.05])
def test_an_output_that_is_really_stuck_trips_within_a_quarter_of_a_second(period_s: float, phase: int) -> None:
    driven = Driven(period_s)
    for _ in range(phase):
        driven.read(3.0, of=3.0)
    before = driven.readings
    while not driven.protection.tripped:
        driven.read(1.0, of=3.0)
    assert driven.protection.state.event is Event.OUTPUT_STUCK
    assert (driven.readings - before) * period_s <= 0.25
