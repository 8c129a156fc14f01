"""What a bench does by itself: it ends runs nobody watches over, closes its rig, and keeps a core free for the loop."""

from __future__ import annotations

import asyncio
import logging
import os
import queue
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from musclewire.errors import CallerError, RigError
from musclewire.extras.live import _messages as messages
from musclewire.extras.live import _silence
from musclewire.extras.live._bench import orders, process, recipes
from musclewire.extras.live._bench.session import BenchSession
from musclewire.extras.live._bench_handle import BenchHandle, BenchSettings, ended
from musclewire.extras.live._server import running
from musclewire.extras.live._silence import LEASE_S, PING_S, ListeningClock
from musclewire.rigs import open_rig

SAMPLE_S, MAX_SILENCE_S = 0.05, LEASE_S


class Watched:
    """A session that is watched for some seconds of a clock of the test's own; nobody gives a sign meanwhile."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *, heating: bool, ending: str = "", above: bool = True) -> None:
        self.heating, self.ending, self.above_sense_voltage = heating, ending, above
        self.quitting, self.sample_s, self.max_silence_s = False, SAMPLE_S, MAX_SILENCE_S
        self.now_s, self.stopped_at_s, self.ended_at_s = 0.0, [], None
        monkeypatch.setattr(orders, "time", SimpleNamespace(sleep=self._sleep))

    def _sleep(self, seconds_s: float) -> None:
        if self.ending and self.ended_at_s is None:
            self.ended_at_s = self.now_s
        self.now_s += seconds_s
        self.quitting = self.now_s > self._until_s

    def stop(self, _who: str) -> None:
        self.stopped_at_s.append(self.now_s)

    def watch(self, until_s: float) -> None:
        self._until_s = until_s
        watch: Any = object.__new__(orders.OrderQueue)  # without its threads
        watch._session, watch._alive_s, watch._ending_since_s = self, 0.0, None
        watch._clock = SimpleNamespace(now_s=lambda: self.now_s)
        watch._watch()


def test_a_heated_run_nobody_watches_over_is_ended_and_switched_off_if_it_goes_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = Watched(monkeypatch, heating=True)
    session.watch(until_s=3.0)
    assert "nobody in control" in session.ending
    assert session.ended_at_s == pytest.approx(MAX_SILENCE_S, abs=2.0 * orders.WATCHED_EVERY_S)
    given_s = orders.MAX_ENDING_S + 2.0 * SAMPLE_S
    assert session.stopped_at_s[0] - session.ended_at_s == pytest.approx(given_s, abs=3.0 * orders.WATCHED_EVERY_S)


def test_silence_counts_only_while_the_process_was_awake(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine that stood still for a minute has asked nobody; who is gone is noticed once it goes on."""
    looks_s = [0.0, 0.05, 0.1, 60.1, *(60.1 + 0.05 * look for look in range(1, 21))]
    monkeypatch.setattr(_silence, "time", SimpleNamespace(monotonic=iter(looks_s).__next__))
    clock = ListeningClock()
    heard_s = [clock.now_s() for _ in looks_s[1:]]
    assert heard_s[2] == pytest.approx(0.1 + PING_S)
    assert heard_s[-1] - heard_s[2] == pytest.approx(1.0)


def test_a_wire_at_rest_is_not_ended_by_silence(monkeypatch: pytest.MonkeyPatch) -> None:
    session = Watched(monkeypatch, heating=False)
    session.watch(until_s=3.0)
    assert (session.ending, session.stopped_at_s) == ("", [])


def test_a_run_that_ends_has_its_last_samples_before_it_is_switched_off(monkeypatch: pytest.MonkeyPatch) -> None:
    session = Watched(monkeypatch, heating=True, ending="as asked")
    session.watch(until_s=2.0 * SAMPLE_S)
    assert session.stopped_at_s == []


def test_a_run_whose_drive_is_down_has_its_time_to_be_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    session = Watched(monkeypatch, heating=True, ending="as asked", above=False)
    session.watch(until_s=3.0)
    assert session.stopped_at_s == []


def test_a_session_knows_whether_more_than_the_sense_voltage_was_ordered() -> None:
    nothing: Any = None
    with open_rig("simulated") as rig:
        session = BenchSession("simulated", Path(), nothing, nothing, rig=rig)
        seen = []
        for voltage_v in (rig.sense_voltage_v, 1.0):
            rig.exchange(voltage_v)
            seen.append(session.above_sense_voltage)
        rig.make_safe()
        assert [*seen, session.above_sense_voltage] == [False, True, False]
    assert not BenchSession("simulated", Path(), nothing, nothing).above_sense_voltage


def test_a_run_that_was_ended_keeps_its_reason_when_nobody_is_there_any_more(monkeypatch: pytest.MonkeyPatch) -> None:
    session = Watched(monkeypatch, heating=True, ending="as asked")
    session.watch(until_s=3.0)
    assert session.ending == "as asked"
    assert session.stopped_at_s


@pytest.mark.parametrize(("rig", "sample_s"), [(None, 0.0), (SimpleNamespace(sample_period_s=SAMPLE_S), SAMPLE_S)])
def test_how_long_a_run_may_take_to_end_counts_the_samples_of_the_rig_that_is_open(rig: Any, sample_s: float) -> None:
    nothing: Any = None
    assert BenchSession("simulated", Path(), nothing, nothing, rig=rig).sample_s == sample_s


@pytest.mark.parametrize("fails", [False, True])
def test_a_session_that_ends_closes_its_rig_however_it_ends(fails: bool) -> None:
    closed: list[bool] = []
    rig = SimpleNamespace(close=lambda: closed.append(True))
    session: Any = SimpleNamespace(quitting=not fails, rig=rig)  # without a state a turn of the loop fails
    if fails:
        with pytest.raises(AttributeError):
            process.run_session(session, SimpleNamespace())  # type: ignore[arg-type]
    else:
        process.run_session(session, SimpleNamespace())  # type: ignore[arg-type]
    assert closed == [True]


def test_a_bench_without_a_process_refuses_what_is_ordered_and_says_why(tmp_path: Path) -> None:
    handle = BenchHandle(BenchSettings("one", "simulated", tmp_path, 1))
    handle.state["why"] = "its process has ended"
    answer = asyncio.run(handle.command(messages.read_command({"do": "home"})))
    assert (answer.accepted, answer.message) == (False, "its process has ended")


def test_a_rig_that_is_in_order_has_passed_the_doctor() -> None:
    passed: list[str] = []
    state = SimpleNamespace(phase="ready")
    shown = SimpleNamespace(state=state, change=lambda **_: None, say=lambda *_: None, done=passed.append)
    with open_rig("simulated") as rig:
        session: Any = SimpleNamespace(rig=rig, shown=shown, on_probe=lambda *_: None)
        recipes.examine_rig(session, messages.Doctor(do="doctor"))
    assert passed == ["doctor"]


def test_a_model_cannot_be_fitted_before_there_is_a_slow_loop() -> None:
    session: Any = SimpleNamespace(work=SimpleNamespace(loop=None))
    with pytest.raises(CallerError, match="no slow loop in this session yet"):
        recipes.fit_model(session, messages.read_command({"do": "fit", "quantity": "strain"}))  # type: ignore[arg-type]


def test_a_staircase_may_begin_at_zero() -> None:
    steps = messages.Steps(kind="staircase", start=0.0, stop=0.02, step=0.01, hold_s=5.0)
    reference = recipes.staircase_of(steps, SimpleNamespace())  # type: ignore[arg-type]
    assert reference.targets_at([1.0, 6.0, 11.0]) == pytest.approx([0.0, 0.01, 0.02])


@pytest.mark.parametrize(("cores", "chosen"), [({0, 1, 3}, [{0, 3}]), ({1}, [])])
def test_the_server_leaves_the_loops_core_to_it_if_there_is_another(
    cores: set[int], chosen: list[set[int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    set_to: list[set[int]] = []
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _process: cores, raising=False)
    monkeypatch.setattr(os, "sched_setaffinity", lambda _process, others: set_to.append(others), raising=False)
    running.leave_core(1)
    assert set_to == chosen


def test_a_drive_that_fell_because_the_loop_was_late_is_named_on_the_page() -> None:
    said: list[tuple[str, str]] = []
    session: Any = SimpleNamespace(now_s=12.34, shown=SimpleNamespace(say=lambda *words: said.append(words)))
    rigs = logging.getLogger("musclewire.rigs")
    with process.missed_deadlines_shown(session):
        rigs.info("sample late for 0.15 s")
    rigs.info("afterwards")
    assert said == [("warning", "missed deadline, at 12.3 s on the plots: sample late for 0.15 s")]


@pytest.mark.parametrize(
    ("command", "stopped_by", "accepted"),
    [({"do": "switch_on"}, "", False), ({"do": "switch_on"}, "Ann", True), ({"do": "pulse"}, "Ann", False)],
)
def test_while_a_run_goes_on_only_switching_on_after_a_stop_may_wait_for_its_end(
    command: dict[str, object], stopped_by: str, accepted: bool
) -> None:
    sent: list[dict[str, object]] = []
    session = SimpleNamespace(queued="loop", stopped=SimpleNamespace(by=stopped_by), stops=1)
    taken: Any = object.__new__(orders.OrderQueue)  # without its threads
    taken._session, taken._outbox = session, SimpleNamespace(send=sent.append)
    taken._waiting, taken._alive_s, taken._watched_s = queue.SimpleQueue(), 0.0, 0.0
    taken._take({"command": command, "number": 3})
    assert taken._waiting.empty() is not accepted
    assert [message["accepted"] for message in sent] == ([] if accepted else [False])


class Stubborn:
    """A process that ends after so many forces."""

    def __init__(self, ends_after: int) -> None:
        self.forces: list[str] = []
        self._ends_after = ends_after

    def terminate(self) -> None:
        self.forces.append("terminate")

    def kill(self) -> None:
        self.forces.append("kill")
        raise ProcessLookupError  # it has ended by itself meanwhile

    async def wait(self) -> int:
        if len(self.forces) < self._ends_after:
            await asyncio.Event().wait()
        return 0


@pytest.mark.parametrize("ends_after", [0, 1, 2, 3])
def test_a_process_is_given_time_then_asked_then_ended_and_said_if_it_still_goes_on(ends_after: int) -> None:
    process_of_rig: Any = Stubborn(ends_after)
    forces = (None, process_of_rig.terminate, process_of_rig.kill)
    if ends_after == 3:
        with pytest.raises(RigError, match="cut the supply"):
            asyncio.run(ended(process_of_rig, *forces, max_wait_s=0.01))
    else:
        asyncio.run(ended(process_of_rig, *forces, max_wait_s=0.01))
    assert process_of_rig.forces == ["terminate", "kill"][:ends_after]
