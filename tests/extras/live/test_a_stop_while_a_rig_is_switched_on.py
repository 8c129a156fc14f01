"""Stops around an order to switch on, at points that the tests choose: a stop that came after the order always counts.

Orders come through a pipe and a thread, as in a bench's process; the loop's part is done by the test. It waits for
events and messages, so that no clock judges.
"""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

import pytest
from pydantic_core import from_json, to_json

from musclewire.errors import CallerError, RigError
from musclewire.extras.live import _messages as messages
from musclewire.extras.live._bench import opening, process
from musclewire.extras.live._bench.descriptions import described_rig
from musclewire.extras.live._bench.lines import MessageWriter
from musclewire.extras.live._bench.orders import NumberedOrder, OrderQueue
from musclewire.extras.live._bench.process import perform
from musclewire.extras.live._bench.recipes import RECIPES
from musclewire.extras.live._bench.session import BenchSession
from musclewire.extras.live._bench.state import PublishedState
from musclewire.extras.live._ring import RowRing, create_ring
from musclewire.rigs import open_rig

# Only so that a fault does not hang a test.
MAX_WAIT_S = 60.0
STAYS_OFF = "rig 'simulated' stays off: a stop came after this order to switch on; order it again when it is safe"


class Kept(MessageWriter):
    """Keeps messages for the test, as they would have been sent."""

    def __init__(self) -> None:
        """Begin without messages."""
        self.messages: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()

    def send(self, message: dict[str, Any]) -> None:
        """Keep a message."""
        self.messages.put(from_json(to_json(message, inf_nan_mode="null")))


class Bench:
    """A session with its orders; the test is the server at one end and the loop at the other."""

    def __init__(self, folder: Path) -> None:
        """Start the threads that read orders."""
        create_ring(folder / "rows")
        self.phases: list[str] = []
        shown = PublishedState("one", lambda state: self.phases.append(state["phase"]))
        self.session = BenchSession(
            "simulated", folder, shown, RowRing(folder / "rows"), seed=1, max_silence_s=MAX_WAIT_S
        )
        source, self._orders_end = os.pipe()
        self._source, self._to_session = os.fdopen(source, "rb"), MessageWriter(self._orders_end)
        self._answers, self._number = Kept(), 0
        self.orders = OrderQueue(self.session, self._source, self._answers)
        opening.show_off(self.session)

    def close(self) -> None:
        """End the session, as a server does that ends."""
        os.close(self._orders_end)
        while self.orders.next(MAX_WAIT_S) is not None:
            continue  # None is its end
        if self.session.rig is not None:
            self.session.rig.close()
        self._source.close()

    @property
    def phase(self) -> str:
        """The phase that is shown."""
        return self.session.shown.state.phase

    def order(self, do: str) -> None:
        """Order something; it is read after what was sent before."""
        self._number += 1
        self._to_session.send({"command": {"do": do}, "number": self._number})

    def stop(self) -> dict[str, Any]:
        """Send a stop and return its confirmation."""
        self._to_session.send({"stop": "a test"})
        return self.answer()

    def answer(self) -> dict[str, Any]:
        """Return the next message to the server."""
        return self._answers.messages.get(timeout=MAX_WAIT_S)

    def perform_next(self) -> dict[str, Any]:
        """Carry out the next order and return its answer."""
        order = self.orders.next(MAX_WAIT_S)
        assert order is not None
        perform(self.session, order)
        return self.answer()

    def is_off(self) -> bool:
        """Return whether no rig can be driven."""
        try:
            if self.session.rig is not None:
                self.session.rig.exchange(0.3)
        except RigError:
            return True
        return self.session.rig is None


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """A session that is off."""
    one = Bench(tmp_path)
    yield one
    one.close()


def refused(answer: dict[str, Any]) -> bool:
    """Return whether an answer is the refusal to switch on after a stop."""
    return (answer["accepted"], answer["message"]) == (False, STAYS_OFF)


def must_not_open(*_arguments: Any, **_options: Any) -> Any:
    """Stand in for ``open_rig`` where a rig must not even be opened."""
    raise AssertionError("a rig was opened after a stop")


def test_a_stop_read_after_the_order_keeps_the_rig_from_being_opened(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(opening, "open_rig", must_not_open)
    bench.order("switch_on")
    assert bench.stop()["took_ms"] is None  # there was nothing to switch off
    assert refused(bench.perform_next())
    assert bench.phase == "stopped"
    assert bench.session.shown.state.why.startswith("stopped by a test")
    assert bench.session.queued == ""


def test_a_stop_before_a_bench_has_begun_is_not_covered_by_its_beginning(bench: Bench) -> None:
    assert bench.phase == "off"
    bench.stop()
    opening.show_off(bench.session)
    assert bench.phase == "stopped"


def test_that_a_rig_is_simulated_is_shown_before_it_is_switched_on(bench: Bench) -> None:
    opening.show_wiring(bench.session)
    assert bench.session.shown.state.simulated
    assert bench.session.rig is None


def test_of_stop_switch_on_stop_the_last_counts(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opening, "open_rig", must_not_open)
    bench.stop()
    bench.order("switch_on")
    bench.stop()
    assert refused(bench.perform_next())
    assert bench.phase == "stopped"


def test_after_a_stop_a_fresh_order_brings_the_rig_up(bench: Bench) -> None:
    bench.stop()
    bench.order("switch_on")
    assert bench.perform_next()["accepted"]
    assert bench.phase == "ready"
    assert not bench.is_off()


def test_of_switch_on_stop_switch_on_the_first_is_refused_and_the_second_counts(bench: Bench) -> None:
    bench.order("switch_on")
    bench.stop()
    bench.order("switch_on")
    assert refused(bench.perform_next())
    assert bench.perform_next()["accepted"]
    assert bench.phase == "ready"
    assert not bench.is_off()


def test_a_stop_while_a_run_ends_counts_although_switching_on_waits_for_that_end(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The run is one that does nothing but receive ``stop, switch_on, stop``; its end comes afterwards."""
    bench.order("switch_on")
    bench.perform_next()

    def stopped_twice(session: BenchSession, _command: Any) -> None:
        bench.stop()
        bench.order("switch_on")
        bench.stop()
        assert session.rig is not None
        session.rig.exchange(0.3)

    perform(bench.session, order_of(bench, monkeypatch, stopped_twice))
    assert not bench.answer()["accepted"]  # the run's
    assert refused(bench.perform_next())
    assert bench.phase == "stopped"
    assert bench.is_off()


def order_of(bench: Bench, monkeypatch: pytest.MonkeyPatch, run: Callable[[BenchSession, Any], None]) -> NumberedOrder:
    """Return a queued order to pulse, for which ``run`` is carried out."""
    monkeypatch.setitem(RECIPES, messages.Pulse, RECIPES[messages.Pulse]._replace(run=run))
    bench.order("pulse")
    order = bench.orders.next(MAX_WAIT_S)
    assert order is not None
    return order


@pytest.mark.parametrize("early", [True, False])
def test_a_stop_while_a_rig_is_being_opened_leaves_it_closed(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, early: bool
) -> None:
    opened = []

    def slow(*arguments: Any, **options: Any) -> Any:
        if early:
            bench.stop()
        opened.append(open_rig(*arguments, **options))
        if not early:
            bench.stop()
        return opened[0]

    monkeypatch.setattr(opening, "open_rig", slow)
    bench.order("switch_on")
    assert refused(bench.perform_next())
    assert bench.phase == "stopped"
    assert "ready" not in bench.phases
    with pytest.raises(RigError, match="closed"):
        opened[0].exchange(0.3)


def test_after_a_stop_an_opening_that_fails_stays_stopped(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*_arguments: Any, **_options: Any) -> Any:
        bench.stop()
        raise CallerError("no such rig")

    monkeypatch.setattr(opening, "open_rig", failing)
    bench.order("switch_on")
    assert bench.perform_next()["message"] == "no such rig"
    assert bench.phase == "stopped"


def test_a_stop_just_before_ready_is_shown_closes_the_rig_that_is_there_by_then(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def last(*arguments: Any, **options: Any) -> Any:
        assert bench.stop()["took_ms"] >= 0.0
        return described_rig(*arguments, **options)

    monkeypatch.setattr(opening, "described_rig", last)
    bench.order("switch_on")
    assert refused(bench.perform_next())
    assert bench.phase == "stopped"
    assert "ready" not in bench.phases
    assert bench.is_off()


class Watched:
    """A lock that says when somebody has to wait for it."""

    def __init__(self, lock: Any) -> None:
        """Watch a lock."""
        self._lock, self.waited_for = lock, threading.Event()

    def __enter__(self) -> bool:
        """Acquire it."""
        if not self._lock.acquire(blocking=False):
            self.waited_for.set()
            self._lock.acquire()
        return True

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Release it."""
        self._lock.release()


def stop_between(bench: Bench, monkeypatch: pytest.MonkeyPatch, phase: str) -> threading.Thread:
    """Let a stop come between the last look and a phase that is shown; return its thread.

    The phase goes on once the stop is over or waits for the lock. Without the lock it would be over before the phase
    is shown, and that would stay.
    """
    session, change = bench.session, bench.session.shown.change
    session.deciding = lock = Watched(session.deciding)

    def stop() -> None:
        session.stop("a test")
        lock.waited_for.set()

    stopping = threading.Thread(target=stop)

    def interrupted(**changed: Any) -> None:
        if changed.get("phase") == phase and stopping.ident is None:  # the first time
            stopping.start()
            assert lock.waited_for.wait(MAX_WAIT_S)
        change(**changed)

    monkeypatch.setattr(session.shown, "change", interrupted)
    return stopping


def test_a_stop_between_the_last_look_and_ready_is_shown_after_it(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    stopping = stop_between(bench, monkeypatch, "ready")
    bench.order("switch_on")
    bench.perform_next()
    stopping.join(MAX_WAIT_S)
    assert bench.phases[-2:] == ["ready", "stopped"]
    assert bench.is_off()


@pytest.mark.parametrize("phase", ["busy", "ready"])
def test_a_stop_at_the_beginning_or_end_of_a_run_is_shown_last(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, phase: str
) -> None:
    bench.order("switch_on")
    bench.perform_next()
    order = order_of(bench, monkeypatch, lambda _session, _command: None)
    stopping = stop_between(bench, monkeypatch, phase)
    perform(bench.session, order)
    stopping.join(MAX_WAIT_S)
    assert bench.phase == "stopped"
    assert bench.is_off()


def test_a_stop_after_the_first_look_at_the_phase_keeps_a_run_from_beginning(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.order("switch_on")
    bench.perform_next()
    stopping = RECIPES[messages.Pulse]._replace(duration_s=lambda _session, _command: bench.stop()["took_ms"])
    monkeypatch.setitem(RECIPES, messages.Pulse, stopping)
    bench.order("pulse")
    assert bench.perform_next()["message"] == "the rig is not switched on: switch on first"
    assert bench.phase == "stopped"
    assert "busy" not in bench.phases


def test_who_stopped_first_stays_the_reason_until_the_rig_is_on_again(bench: Bench) -> None:
    def reason() -> str:
        return bench.session.shown.state.why.partition(":")[0]

    bench.session.stop("Ann")
    bench.session.stop("Ben")
    assert reason() == "stopped by Ann"
    bench.order("switch_on")
    bench.perform_next()
    bench.session.stop("Cid")
    assert reason() == "stopped by Cid"


def test_after_a_run_that_fails_the_rig_is_off_and_was_never_ready_again(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An error of the rig that its guard knows nothing of, so that nobody else switches off."""

    def failing(_session: BenchSession, _command: Any) -> None:
        raise RigError("the stage does not move")

    bench.order("switch_on")
    bench.perform_next()
    assert not bench.is_off()
    perform(bench.session, order_of(bench, monkeypatch, failing))
    answer = bench.answer()
    assert (answer["accepted"], answer["message"]) == (False, "the stage does not move")
    assert bench.session.shown.state.why == "the stage does not move"
    after = bench.phases[bench.phases.index("busy") :]
    assert (set(after), after[-1]) == ({"busy", "failed"}, "failed")
    assert bench.is_off()


def test_a_stop_in_a_run_that_takes_no_further_sample_is_not_followed_by_ready(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.order("switch_on")
    bench.perform_next()
    perform(bench.session, order_of(bench, monkeypatch, lambda _session, _command: bench.stop() and None))
    assert bench.phase == "stopped"
    assert bench.is_off()


def test_a_bench_that_was_stopped_while_opening_waits_and_does_not_spin(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The loop itself: after the refusal it waits for orders and takes no sample, until the session ends."""
    rests: list[BenchSession] = []
    waits: list[float] = []

    def slow(*arguments: Any, **options: Any) -> Any:
        bench.stop()
        return open_rig(*arguments, **options)

    next_order = bench.orders.next

    def counted(wait_s: float) -> NumberedOrder | None:
        waits.append(wait_s)
        bench.session.quitting = len(waits) == 3
        return next_order(0.0 if len(waits) > 1 else MAX_WAIT_S)

    monkeypatch.setattr(opening, "open_rig", slow)
    monkeypatch.setattr(process, "rest", rests.append)
    monkeypatch.setattr(bench.orders, "next", counted)
    bench.order("switch_on")
    process.run_session(bench.session, bench.orders)
    assert refused(bench.answer())
    assert rests == []
    assert waits == [process.WAIT_S] * 3
    monkeypatch.undo()
