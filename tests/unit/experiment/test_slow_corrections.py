"""A slow part takes effect exactly when it should, in line as in a thread; what is late or fails changes nothing."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from fake_rig import FakeRig, straight_model
from tests.slow_estimators import DriftingState, MeanPower, drifting

from musclewire.controllers import staircase
from musclewire.experiment._closed_loop import control
from musclewire.rigs import Rig
from musclewire.sensing import InLine, InThread, PolynomialEstimator, SlowCorrections, SlowStatus
from musclewire.signals import Command, RawSample, WireSample

SHORT = staircase(hold_s=0.3)
SAMPLE = WireSample(0.0, 1.0, 0.9, 0.1)


class PacedRig(FakeRig):
    """The fake rig as one with a clock, so slow that no correction is late: what was requested is waited for."""

    paced = True

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        super().__init__()
        self._requested: list[Callable[[], object] | None] = []
        request = InThread.request

        def noted(thread: InThread, compute: Callable[[], object]) -> Callable[[], object] | None:
            self._requested.append(request(thread, compute))
            return self._requested[-1]

        monkeypatch.setattr(InThread, "request", noted)

    def exchange(self, command: Command | float) -> RawSample:
        wait_for(lambda: all(result is not None and result() is not None for result in self._requested))
        return super().exchange(command)


def short_run(rig: Rig, **slow: object):
    return control(rig, straight_model(), SHORT, estimator=drifting(**slow), approach_s=1.0)


@contextmanager
def in_thread(slow: MeanPower) -> Iterator[SlowCorrections]:
    corrections = SlowCorrections(slow, InThread())
    try:
        yield corrections
    finally:
        corrections.close()


def followed(corrections: SlowCorrections, ticks: int, between: Callable[[int], object] = lambda _: None):
    """Return the status of each tick, and the offset in effect at it."""
    state = DriftingState(PolynomialEstimator(straight_model(), 1.0).start(), 0.0, 0.0)
    found = []
    for tick in range(ticks):
        state, status = corrections.before(state)
        found.append((status, state.offset))
        corrections.after(SAMPLE)
        between(tick)
    return found


def wait_for(condition: Callable[[], bool]) -> None:
    begin = time.monotonic()
    while not condition():
        assert time.monotonic() < begin + 30.0
        time.sleep(1e-4)


def test_a_correction_takes_effect_exactly_so_many_ticks_after_it_was_requested() -> None:
    found = followed(SlowCorrections(MeanPower(every_ticks=10, after_ticks=5), InLine()), 30)
    applied = [tick for tick, (status, _) in enumerate(found) if status is SlowStatus.APPLIED]
    assert applied == [3 + 5, 13 + 5, 23 + 5]  # the window of four is full at tick 3
    assert [offset for _, offset in found[:8]] == [0.0] * 8
    assert found[8][1] == pytest.approx(1e-4 * 0.09)


def test_a_thread_that_is_in_time_gives_the_recording_that_in_line_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    in_line, in_time = short_run(FakeRig()), short_run(PacedRig(monkeypatch))
    assert in_line.metadata["slow_corrections_applied"] == 8
    assert in_time.metadata["slow_corrections_late"] == 0
    assert set(in_line.columns) == set(in_time.columns)
    for name in in_line.columns:
        assert np.array_equal(in_line[name], in_time[name]), name
    for name in ("estimator", "slow_corrections_applied", "slow_corrections_failed"):
        assert in_line.metadata[name] == in_time.metadata[name]


def test_a_late_correction_leaves_the_old_one_and_the_sample_says_so() -> None:
    gate, done, requests = threading.Event(), threading.Event(), []

    def slow_the_second_time() -> None:
        requests.append(1)
        if len(requests) == 2:
            gate.wait(30.0)
        done.set()

    def between(tick: int) -> None:
        if tick == 3:
            wait_for(done.is_set)
        if tick == 19:
            done.clear()
            gate.set()
            wait_for(done.is_set)

    with in_thread(MeanPower(10, 5, slow_the_second_time)) as corrections:
        found = followed(corrections, 25, between)
        counts = corrections.metadata()
    assert found[8][0] is SlowStatus.APPLIED
    assert found[18] == (SlowStatus.LATE, found[8][1])
    assert {offset for _, offset in found[8:]} == {found[8][1]}
    assert counts == {"slow_corrections_applied": 1, "slow_corrections_late": 1, "slow_corrections_failed": 0}


def test_a_thread_still_busy_takes_no_second_request_and_the_tick_never_waits() -> None:
    gate = threading.Event()
    try:
        with in_thread(MeanPower(5, 5, lambda: gate.wait(30.0))) as corrections:
            found = followed(corrections, 40)
    finally:
        gate.set()
    due = [status for status, _ in found if status is not SlowStatus.NONE_DUE]
    # A tick that waited would have found the first correction there.
    assert due == [SlowStatus.LATE] * 7
    assert {offset for _, offset in found} == {0.0}


@pytest.mark.parametrize("rig", [lambda _: FakeRig(), PacedRig], ids=["in line", "in a thread"])
def test_an_exception_in_the_slow_part_leaves_the_old_correction_and_the_run_says_so(
    rig: Callable[[pytest.MonkeyPatch], FakeRig], monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[int] = []

    def fails_from_the_third_on() -> None:
        calls.append(1)
        if len(calls) >= 3:
            raise ZeroDivisionError("nothing to divide by")

    opened = rig(monkeypatch)
    run = short_run(opened, meanwhile=fails_from_the_third_on)
    assert run.metadata["ended"] == "done"
    assert run.metadata["slow_corrections_applied"] == 2
    assert run.metadata["slow_corrections_failed"] == 6
    assert run.metadata["slow_correction_error"] == "ZeroDivisionError: nothing to divide by"
    second = int(np.flatnonzero(run["slow_correction"] == SlowStatus.APPLIED)[1])
    assert set(run["extra_offset"][second:]) == {run["extra_offset"][second]}
    assert opened.drive_voltage_v == opened.sense_voltage_v


def test_a_correction_that_cannot_be_used_counts_as_failed() -> None:
    class Unusable(MeanPower):
        def corrected(self, _state: DriftingState, correction: float) -> DriftingState:
            raise ValueError(f"no state takes {correction:.2f}")

    corrections = SlowCorrections(Unusable(10, 5), InLine())
    assert [status for status, _ in followed(corrections, 9)][-1] is SlowStatus.FAILED
    assert corrections.metadata()["slow_correction_error"] == "ValueError: no state takes 0.09"


def test_the_threads_end_with_their_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow_threads() -> int:
        return sum(thread.name == "musclewire slow part" for thread in threading.enumerate())

    before = slow_threads()
    short_run(PacedRig(monkeypatch))
    wait_for(lambda: slow_threads() == before)
