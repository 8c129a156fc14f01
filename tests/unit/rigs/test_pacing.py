"""Samples on an absolute grid, and what happens to a caller who comes late; by a clock that only the test moves."""

from __future__ import annotations

import numpy as np
import pytest

from musclewire.controllers.protection import Event, State
from musclewire.rigs import pacing
from musclewire.rigs.configuration import open_rig
from musclewire.rigs.guarded import GuardedRig, ProtectionTripError
from musclewire.rigs.pacing import SPIN_S, Pacer

READING_TAKES_S = 1e-6


class Clock:
    """Stands in for the module ``time``: a sleep moves it, each look at it by a microsecond, and the test."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.slept_s: list[float] = []
        self.looks = 0

    def monotonic(self) -> float:
        self.looks += 1
        self.now_s += READING_TAKES_S
        return self.now_s

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.slept_s.append(seconds)
        self.now_s += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    fake = Clock()
    monkeypatch.setattr(pacing, "time", fake)
    return fake


@pytest.fixture
def rig(clock: Clock) -> GuardedRig:  # noqa: ARG001
    return open_rig("simulated", real_time=True)


def test_the_nth_sample_is_due_n_periods_after_the_first_whatever_the_caller_does_between(clock: Clock) -> None:
    pacer = Pacer(0.001)
    returned = []
    random = np.random.default_rng(1)
    for _ in range(10_000):
        pacer.wait()
        returned.append(clock.now_s)
        clock.now_s += random.uniform(0.0, 0.0009)
    late_s = np.array(returned) - returned[0] - 0.001 * np.arange(10_000)
    assert np.abs(late_s).max() < 5 * READING_TAKES_S


def test_a_sleep_that_ends_late_does_not_shift_what_follows(clock: Clock) -> None:
    pacer = Pacer(0.01, sleep=lambda seconds: clock.sleep(seconds + 0.004))
    returned = []
    for _ in range(100):
        pacer.wait()
        returned.append(clock.now_s)
    assert returned[-1] - returned[0] - 99 * 0.01 == pytest.approx(0.004 - SPIN_S, abs=1e-5)


def test_the_last_stretch_is_waited_for_awake(clock: Clock) -> None:
    pacer = Pacer(0.01)
    pacer.wait()
    pacer.wait()
    assert clock.slept_s == [pytest.approx(0.01 - SPIN_S, abs=1e-5)]


def test_after_a_rest_nothing_is_due(clock: Clock) -> None:
    pacer = Pacer(0.01)
    pacer.wait()
    clock.now_s += 60.0
    assert pacer.late_s() == pytest.approx(59.99, abs=1e-3)
    pacer.rest()
    assert pacer.late_s() == 0.0
    pacer.wait()
    pacer.wait()
    assert len(clock.slept_s) == 1


def test_without_real_time_nobody_looks_at_the_clock(clock: Clock) -> None:
    with open_rig("simulated") as rig:
        for _ in range(5):
            rig.exchange(0.3)
    assert clock.looks == 0


def test_in_real_time_samples_come_one_period_apart(clock: Clock, rig: GuardedRig) -> None:
    returned = []
    with rig:
        for _ in range(5):
            rig.exchange(0.3)
            returned.append(clock.now_s)
            clock.now_s += 0.01  # what the caller does with a sample
    assert np.diff(returned) == pytest.approx([rig.sample_period_s] * 4, abs=1e-5)


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
