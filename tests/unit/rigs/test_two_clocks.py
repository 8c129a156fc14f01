"""Of a paced device's clock and the host's the longer time heats, and two that differ for good end the run."""

from __future__ import annotations

import itertools

import pytest
from tests.unit.rigs.ideal_wire import LIMITS, PERIOD_S, IdealWire

from musclewire.controllers import Event, Protection, protection_table
from musclewire.rigs import GuardedRig, Missing, ProtectionTripError, _guarded
from musclewire.rigs._two_clocks import TwoClocks
from musclewire.signals import RawSample

MS = 1_000_000


def covered(clocks: TwoClocks, *samples: tuple[float, int, int], heated: bool = True) -> list[float]:
    """The times that samples cover: each with the device's step [s], and order and arrival by the host [ms]."""
    return [clocks.covered_s(step_s, heated, MS * ordered, MS * came) for step_s, ordered, came in samples]


def test_a_slow_device_counts_by_the_hosts_clock_from_the_first_order_on() -> None:
    given = (0.05, 1000, 1250), (0.05, 1251, 1500), (0.05, 1500, 1760)
    assert covered(TwoClocks(), *given) == pytest.approx([0.25, 0.25, 0.26])


def test_a_fast_device_counts_by_its_own_clock() -> None:
    assert covered(TwoClocks(), (0.05, 0, 5), (0.05, 5, 10), (0.05, 10, 15)) == [0.05, 0.05, 0.05]


def test_a_sample_that_came_late_once_does_not_count_again_when_the_others_come_the_sooner() -> None:
    late = (0.05, 0, 50), (0.05, 50, 100), (0.05, 100, 230), (0.05, 230, 232), (0.05, 232, 250), (0.05, 250, 300)
    assert covered(TwoClocks(), *late) == pytest.approx([0.05, 0.05, 0.13, 0.05, 0.05, 0.05])
    # 0.30 s have passed, and no more than by the latest of all is counted beyond.
    assert sum(covered(TwoClocks(), *late)) == pytest.approx(0.30 + 0.08)


def test_at_the_sense_voltage_only_the_device_counts_and_the_next_heat_begins_anew() -> None:
    clocks = TwoClocks()
    assert covered(clocks, (0.05, 0, 900), heated=False) == [0.05]
    assert covered(clocks, (0.05, 900, 950)) == pytest.approx([0.05])
    assert covered(clocks, (0.05, 950, 2000), heated=False) == [0.05]
    assert covered(clocks, (0.05, 5000, 5060)) == pytest.approx([0.06])


def test_the_next_sample_is_expected_to_take_as_long_as_the_shorter_of_two() -> None:
    clocks = TwoClocks()
    assert clocks.expected_s == 0.0
    covered(clocks, (0.05, 0, 900))
    assert clocks.expected_s == pytest.approx(0.9)
    covered(clocks, (0.05, 900, 950))
    assert clocks.expected_s == pytest.approx(0.05)


def said(factor: float, host_s: float) -> list[str]:
    """What is said of a device whose clock goes on by 50 ms in so many times as long, sample by sample."""
    clocks, now = TwoClocks(), itertools.count(0, round(factor * 50 * MS))
    return [clocks.difference(0.05, next(now)) for _ in range(int(host_s / (0.05 * factor)) + 1)]


@pytest.mark.parametrize("factor", [0.1, 0.88, 1.0, 1.09, 1.12, 2.0, 10.0])
def test_clocks_that_differ_by_more_than_a_tenth_for_five_seconds_are_told_by_both_times(factor: float) -> None:
    assert not any(said(factor, 4.8))
    found = [text for text in said(factor, 5.6) if text]
    assert len(found) == (not 0.9 <= factor <= 1.1)
    assert all("by the device's clock were 2.5" in text or "by the host's" in text for text in found)


def test_a_device_that_stands_still_for_a_second_and_catches_up_does_not_differ() -> None:
    clocks, now_ns = TwoClocks(), 0
    for number in range(400):
        now_ns += {100: 1000, **dict.fromkeys(range(101, 120), 0)}.get(number, 50) * MS
        assert clocks.difference(0.05, now_ns) == ""


def test_a_pause_is_no_difference() -> None:
    clocks, now_ns = TwoClocks(), 0
    for number in range(400):
        now_ns += 50 * MS
        if number % 40 == 0:
            now_ns += 3000 * MS
            clocks.rest()
        assert clocks.difference(0.05, now_ns) == ""


def held(device: IdealWire, drive_v: float, monkeypatch: pytest.MonkeyPatch) -> tuple[Event | None, str]:
    """Hold a drive for half a minute, by a host's clock that goes as the wire's time; why it ended."""
    monkeypatch.setattr(_guarded, "perf_counter_ns", lambda: round(1e9 * device.true_s) + 1)
    rig = GuardedRig(device)
    try:
        while device.true_s < 30.0:
            rig.exchange(drive_v)
    except ProtectionTripError as trip:
        return trip.event, str(trip)
    finally:
        rig.close()
    return None, ""


@pytest.mark.parametrize("resistance_ohm", [12.2, 17.0, 24.0])
@pytest.mark.parametrize("drive_v", [3.0, 4.6, 5.5])
@pytest.mark.parametrize("factor", [0.1, 0.2, 0.5, 1.0, 1.5, 2.0, 5.0, 10.0])
def test_no_clock_of_a_paced_device_heats_its_wire_beyond_the_limit(
    factor: float, drive_v: float, resistance_ohm: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    device = IdealWire(paced=True, takes_s=factor * PERIOD_S, resistance_ohm=resistance_ohm)
    event, _ = held(device, drive_v, monkeypatch)
    assert device.hottest_k <= LIMITS.maximum_temperature_k + 10.0
    assert event in {Event.OVER_TEMPERATURE, Event.CLOCK_LEAPT, *((None,) if factor == 1.0 else ())}


def test_a_clock_that_is_wrong_for_good_ends_the_run_and_both_times_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    event, text = held(IdealWire(paced=True, takes_s=2.0 * PERIOD_S), 1.0, monkeypatch)
    assert event is Event.CLOCK_LEAPT
    assert "1.25 s by the device's clock were 2.50 s by the host's" in text


@pytest.mark.parametrize("drive_v", [0.3, 5.5])
def test_a_rig_that_idled_at_its_sense_voltage_may_be_heated_at_once(
    drive_v: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    device = IdealWire(paced=True)
    monkeypatch.setattr(_guarded, "perf_counter_ns", lambda: round(1e9 * device.true_s) + 1)
    with GuardedRig(device) as rig:
        for _ in range(3):
            rig.exchange(0.3)
            device.true_s, device.samples = device.true_s + 20.0, device.samples + 400
        before_k = rig.protection.temperature_k
        rig.exchange(drive_v)
        # The drive has been out for one sample, not for the time that nobody asked.
        assert rig.protection.temperature_k - before_k < 30.0


@pytest.mark.parametrize(("paced", "late", "earlier_heats"), [(True, 1, True), (False, 4, True), (False, 1, False)])
def test_until_an_order_can_have_arrived_the_drive_before_heats(paced: bool, late: int, earlier_heats: bool) -> None:
    """It cannot on a paced device, and not on any whose sample covers more than its period."""
    device = IdealWire(paced=paced)
    with GuardedRig(device) as rig:
        rig.exchange(4.0)
        hot_k = rig.protection.temperature_k
        device.samples += late - 1
        rig.exchange(0.3)
        assert (rig.protection.temperature_k > hot_k) == earlier_heats


def test_a_sample_covers_no_less_than_it_was_missing_for_whatever_its_clock_says() -> None:
    device = IdealWire(lambda number, sample: Missing(Event.SAMPLE_LATE, 0.08, sample) if number == 0 else sample)
    with GuardedRig(device) as rig:
        rig.exchange(3.0)
        assert rig.protection.temperature_k == pytest.approx(warmed_k(3.0, 0.08 + PERIOD_S))


def waits(number: int, sample: RawSample) -> object:
    """Say twice that a sample is missing, until the sense voltage is out, and then give it."""
    return sample if number >= 2 else Missing(Event.SAMPLE_LATE, (0.05, 0.12)[number])


def test_the_first_order_of_an_exchange_heats_though_the_sense_voltage_followed_it() -> None:
    device = IdealWire(waits)
    with GuardedRig(device) as rig:
        assert rig.exchange(3.0).drive_voltage_v == LIMITS.sense_voltage_v
        assert rig.protection.temperature_k == pytest.approx(warmed_k(3.0, 0.12 + PERIOD_S))


@pytest.mark.parametrize("said_s", [0.05, 0.09])
def test_no_wait_is_so_long_that_the_wire_would_be_too_hot_at_its_end(said_s: float) -> None:
    limit_k = 315.0
    assert warmed_k(4.0, PERIOD_S) < limit_k < warmed_k(4.0, PERIOD_S + said_s)
    limits = LIMITS._replace(maximum_temperature_k=limit_k)
    device = IdealWire(lambda number, _: Missing(Event.SAMPLE_LATE, said_s + number), limits=limits)
    with GuardedRig(device) as rig, pytest.raises(ProtectionTripError, match="over_temperature"):
        rig.exchange(4.0)
    assert device.samples == 1


def warmed_k(drive_v: float, dt_s: float) -> float:
    """The temperature of a cold wire after so long at a drive, by what was ordered."""
    return Protection(LIMITS).temperature_after_k(drive_v, dt_s)


def test_pauses_in_which_a_devices_clock_stands_still_are_neither_heat_nor_a_difference(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    device = IdealWire(paced=True)
    monkeypatch.setattr(_guarded, "perf_counter_ns", lambda: round(1e9 * device.true_s) + 1)
    with GuardedRig(device) as rig:
        for _ in range(5):
            rig.exchange(2.0)
            rig.make_safe()
            device.true_s += 20.0
        before_k = rig.protection.temperature_k
        assert before_k - LIMITS.ambient_temperature_k < 20.0
        rig.exchange(0.3)  # and the drive from before the pause is out no more
        assert rig.protection.temperature_k < before_k


def test_the_hosts_clock_says_nothing_of_a_device_without_a_pace(monkeypatch: pytest.MonkeyPatch) -> None:
    assert held(IdealWire(takes_s=2.0 * PERIOD_S), 1.0, monkeypatch) == (None, "")


def test_a_wait_without_end_ends_after_a_second_by_the_hosts_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the device's own clock hardly any time passes, so that the table's times are never over."""
    waits: list[float] = []

    def wait(number: int, sample: RawSample) -> object:
        if number < 3:
            return sample
        waits.append(1e-9 * len(waits) + 1e-9)
        return Missing(Event.SAMPLE_LATE, waits[-1])

    monkeypatch.setattr(_guarded, "perf_counter_ns", lambda: 50_000_000 * len(waits) + 1)
    device = IdealWire(wait)
    rig = GuardedRig(device)
    for _ in range(3):
        rig.exchange(3.0)
    with pytest.raises(ProtectionTripError) as caught:
        rig.exchange(3.0)
    assert caught.value.event is Event.DEVICE_LOST
    assert protection_table().trip_after_s < 0.05 * len(waits) < 1.2
    assert device.drive_voltage_v == 0.0
