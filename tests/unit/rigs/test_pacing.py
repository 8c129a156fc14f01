"""Samples on an absolute grid, and what happens to a caller who comes late; by a clock that only the test moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from musclewire.controllers import Event, State
from musclewire.errors import CallerError
from musclewire.rigs import GuardedRig, ProtectionTripError, SamplePacer, adjustable_clock_of, open_rig
from musclewire.rigs import _pacing as pacing
from musclewire.rigs._pacing import SPIN_S

READING_TAKES_S = 1e-6


class Clock:
    """Stands in for the module ``time``: a sleep moves it, each look at it by a microsecond, and the test."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.slept_s: list[float] = []
        self.looks = 0
        self.meanwhile: list[tuple[float, Callable[[], None]]] = []  # what other threads do, so long into a wait

    def monotonic(self) -> float:
        self.looks += 1
        self.now_s += READING_TAKES_S
        return self.now_s

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.slept_s.append(seconds)
        self.now_s += seconds


class Woken:
    """Stands in for ``threading.Event``: a wait moves the clock, unless what another thread does comes in between."""

    def __init__(self, clock: Clock) -> None:
        self.clock, self.is_set = clock, False

    def set(self) -> None:
        self.is_set = True

    def clear(self) -> None:
        self.is_set = False

    def wait(self, seconds: float) -> None:
        assert seconds > 0.0
        if self.clock.meanwhile:
            after_s, act = self.clock.meanwhile.pop(0)
            assert after_s < seconds
            act()
            seconds = after_s
        self.clock.now_s += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    fake = Clock()
    monkeypatch.setattr(pacing, "time", fake)
    monkeypatch.setattr(pacing, "Event", lambda: Woken(fake))
    return fake


@pytest.fixture
def rig(clock: Clock) -> GuardedRig:  # noqa: ARG001
    return open_rig("simulated", real_time=True)


def test_the_nth_sample_is_due_n_periods_after_the_first_whatever_the_caller_does_between(clock: Clock) -> None:
    pacer = SamplePacer(0.001)
    returned = []
    random = np.random.default_rng(1)
    for _ in range(10_000):
        pacer.wait()
        returned.append(clock.now_s)
        clock.now_s += random.uniform(0.0, 0.0009)
    late_s = np.array(returned) - returned[0] - 0.001 * np.arange(10_000)
    assert np.abs(late_s).max() < 5 * READING_TAKES_S


def test_a_sleep_that_ends_late_does_not_shift_what_follows(clock: Clock) -> None:
    pacer = SamplePacer(0.01, sleep=lambda seconds: clock.sleep(seconds + 0.004))
    returned = []
    for _ in range(100):
        pacer.wait()
        returned.append(clock.now_s)
    assert returned[-1] - returned[0] - 99 * 0.01 == pytest.approx(0.004 - SPIN_S, abs=1e-5)


def test_the_last_stretch_is_waited_for_awake(clock: Clock) -> None:
    pacer = SamplePacer(0.01)
    pacer.wait()
    pacer.wait()
    assert clock.slept_s == [pytest.approx(0.01 - SPIN_S, abs=1e-5)]


def test_without_real_time_nobody_looks_at_the_clock(clock: Clock) -> None:
    with open_rig("simulated") as rig:
        for _ in range(5):
            rig.exchange(0.3)
    assert clock.looks == 0


def test_a_late_sample_does_not_shift_those_that_follow(clock: Clock, rig: GuardedRig) -> None:
    returned = []
    with rig:
        for late_s in (0.0, 0.07, 0.0, 0.0):
            rig.exchange(0.3)
            returned.append(clock.now_s - 100.0)
            clock.now_s += late_s
    # The second sample returns at 0.05 s and its caller comes back at 0.12 s: the third is due at 0.10 s and
    # comes at once, the fourth is due at 0.15 s and comes then.
    assert returned == pytest.approx([0.0, 0.05, 0.12, 0.15], abs=1e-4)


@pytest.mark.parametrize(
    ("late_s", "out_v"),
    [
        pytest.param(0.0, 2.0, id="in time: the new drive"),
        pytest.param(0.09, 2.0, id="a little late: the old drive was held meanwhile, the new one goes out"),
        pytest.param(0.11, 0.3, id="later: the sense voltage, whatever is commanded"),
        pytest.param(0.24, 0.3, id="just in time not to be switched off"),
    ],
)
def test_a_late_host_is_answered_by_the_rule_of_the_table(
    clock: Clock, rig: GuardedRig, late_s: float, out_v: float
) -> None:
    with rig:
        rig.exchange(1.0)
        clock.now_s += rig.sample_period_s + late_s
        assert rig.exchange(2.0).drive_voltage_v == pytest.approx(out_v, abs=1e-3)
        # The sample came, so nothing is missing any more; once the grid is caught up with, drives are followed.
        assert rig.protection.state is State.RUN
        for _ in range(6):
            sample = rig.exchange(2.0)
        assert sample.drive_voltage_v == pytest.approx(2.0, abs=1e-3)


def test_a_host_that_comes_after_the_trip_time_finds_the_drive_off_for_good(clock: Clock, rig: GuardedRig) -> None:
    with rig:
        rig.exchange(1.0)
        clock.now_s += rig.sample_period_s + 0.26
        with pytest.raises(ProtectionTripError, match="samples come too late") as caught:
            rig.exchange(2.0)
        assert caught.value.event is Event.SAMPLE_LATE
        assert caught.value.exit_code == 3
        assert rig.protection.state is State.TRIPPED
        assert rig.drive_voltage_v == 0.0


def test_a_rig_that_was_made_safe_may_be_left_alone(clock: Clock, rig: GuardedRig) -> None:
    """Between two runs nothing is driven above the sense voltage, so nothing is late."""
    with rig:
        rig.exchange(1.0)
        rig.make_safe()
        clock.now_s += 60.0
        assert rig.exchange(2.0).drive_voltage_v == pytest.approx(2.0, abs=1e-3)


@pytest.fixture
def started(clock: Clock) -> SamplePacer:
    """A pacer of one second whose grid begins at 100 s."""
    pacer = SamplePacer(1.0)
    pacer.wait()
    assert clock.now_s == pytest.approx(100.0, abs=1e-5)
    return pacer


def test_another_thread_ends_a_wait_and_all_that_follow(clock: Clock, started: SamplePacer) -> None:
    clock.meanwhile = [(0.3, started.end)]
    for _ in range(3):
        started.wait()
        assert clock.now_s == pytest.approx(100.3, abs=1e-4)
    assert clock.slept_s == []


@pytest.mark.parametrize(
    ("period_s", "due_s"),
    [
        pytest.param(0.5, [100.5, 101.0, 101.5], id="faster: due earlier"),
        pytest.param(0.1, [100.3, 100.4, 100.5], id="so much faster that it is due already: now, and nothing is late"),
        pytest.param(4.0, [104.0, 108.0, 112.0], id="slower: due later"),
    ],
)
def test_another_thread_changes_the_period_of_a_wait(
    clock: Clock, started: SamplePacer, period_s: float, due_s: list[float]
) -> None:
    clock.meanwhile = [(0.3, lambda: started.change_period(period_s))]
    found_s = []
    for _ in due_s:
        started.wait()
        found_s.append(clock.now_s)
    assert found_s == pytest.approx(due_s, abs=1e-4)
    assert started.late_s() == 0.0


def test_a_change_back_during_a_wait_changes_nothing(clock: Clock, started: SamplePacer) -> None:
    clock.meanwhile = [(0.2, lambda: started.change_period(3.0)), (0.2, lambda: started.change_period(1.0))]
    started.wait()
    assert clock.now_s == pytest.approx(101.0, abs=1e-4)


@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0])
def test_samples_of_a_clock_come_as_often_as_it_says_and_their_time_is_the_wires(clock: Clock, speed: float) -> None:
    with open_rig("simulated", real_time=True, clock_speed=speed) as rig:
        returned_s = []
        for _ in range(5):
            rig.exchange(0.3)
            returned_s.append(clock.now_s)
            clock.now_s += 1e-3  # what the caller does with a sample
        assert np.diff(returned_s) == pytest.approx([rig.sample_period_s / speed] * 4, abs=1e-4)
        assert rig.exchange(0.3).time_s == pytest.approx(6 * rig.sample_period_s)
        assert rig.metadata()["clock_speed"] == speed


def test_a_speed_that_the_host_cannot_keep_is_no_fault(clock: Clock) -> None:
    with open_rig("simulated", real_time=True, clock_speed=100.0) as rig:
        for _ in range(5):
            assert rig.exchange(2.0).drive_voltage_v == pytest.approx(2.0, abs=1e-3)
            clock.now_s += 3.0


def test_back_in_real_time_a_late_host_is_late_again_but_not_for_what_was_before(clock: Clock, rig: GuardedRig) -> None:
    speed = adjustable_clock_of(rig)
    assert speed is not None
    with rig:
        rig.exchange(1.0)
        speed.set_speed(100.0)
        rig.exchange(1.0)
        clock.now_s += 3.0
        speed.set_speed(1.0)
        assert rig.exchange(2.0).drive_voltage_v == pytest.approx(2.0, abs=1e-3)
        clock.now_s += rig.sample_period_s + 0.3
        with pytest.raises(ProtectionTripError, match="samples come too late"):
            rig.exchange(2.0)


@pytest.mark.parametrize("factor", [0.0, -1.0, 0.009, 1001.0, float("nan"), float("inf")])
def test_an_impossible_clock_speed_is_refused(factor: float) -> None:
    with pytest.raises(CallerError, match=r"clock speed .* is outside 0\.01 to 1000"):
        open_rig("simulated", real_time=True, clock_speed=factor)


def test_a_clock_speed_without_a_clock_is_refused() -> None:
    with pytest.raises(CallerError, match=r"add real_time=True"):
        open_rig("simulated", clock_speed=10.0)
    assert adjustable_clock_of(open_rig("simulated")) is None


def test_only_a_change_counts_as_one() -> None:
    clock = adjustable_clock_of(open_rig("simulated", real_time=True))
    assert clock is not None
    for factor in (1.0, 10.0, 10.0, 1.0):
        clock.set_speed(factor)
    assert (clock.speed, clock.changes) == (1.0, 2)
