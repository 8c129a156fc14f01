"""Stops in every drawn order of events: after a stop nothing is out until switch on was pressed after it.

The server's end, its session and the bench's process are the real ones, in one process: the bench's two threads go on
line by line and the server's tasks begin in the order that Hypothesis draws, on a clock of the test's own. The rig is
an ideal wire behind the real guard.
"""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.extras.live.unit.turns import Turn, TurnLock
from tests.unit.rigs.ideal_wire import IdealWire

from musclewire.errors import RigError
from musclewire.extras.live import _bench_handle as bench_handle
from musclewire.extras.live import _messages as messages
from musclewire.extras.live._bench import opening, orders, process, recipes
from musclewire.extras.live._bench import session as bench_session
from musclewire.extras.live._bench.lines import MessageWriter
from musclewire.extras.live._bench.state import PublishedState
from musclewire.extras.live._ring import RowRing, create_ring
from musclewire.extras.live._server import session as server_session
from musclewire.rigs import GuardedRig
from musclewire.signals import RawSample

FILES = frozenset(str(one.__file__) for one in (bench_session, opening, orders, process))
SAMPLES_OF_A_RUN, ROUNDS = 3, 400
OPENING_S = st.one_of(st.just(0.0), st.floats(0.0, 5.0))


class Outbox(MessageWriter):
    """The pipe from the bench, whose end the test hands over."""

    def __init__(self) -> None:
        self.lines: deque[bytes] = deque()
        self.stops_confirmed, self.is_dead = 0, False

    def send(self, message: dict[str, Any]) -> None:
        if self.is_dead:
            return  # threads end by an exception here, and what they still do then a killed process does not
        self.stops_confirmed += "stopped" in message
        self.lines.append(messages_to_json(message))


def messages_to_json(message: dict[str, Any]) -> bytes:
    return json.dumps(message, default=str).encode() + b"\n"


class Pipe:
    """Both pipes and the life of the bench's process, as its handle sees them."""

    def __init__(self, world: World) -> None:
        self.stdin, self.stdout = self, asyncio.StreamReader()
        self._world, self.lines, self.is_shut = world, deque[bytes](), False
        self.returncode: int | None = None
        self._ended = asyncio.Event()

    def write(self, data: bytes) -> None:
        self.lines.append(data)

    def is_closing(self) -> bool:
        return self.is_shut

    def close(self) -> None:
        self.is_shut = True

    def terminate(self) -> None:
        """Nothing: a frozen process hears no signal, and that is the worse case."""

    def kill(self) -> None:
        if self.returncode is None:
            self.returncode = -9
            self._world.die()
            self._ended.set()

    async def wait(self) -> int:
        await self._ended.wait()
        assert self.returncode is not None
        return self.returncode

    def __iter__(self) -> Iterator[bytes]:
        """The bench's end of the orders: what waits, then the end; until then the turn is somebody else's."""
        while True:
            if self.lines:
                yield self.lines.popleft()
            elif self.is_shut:
                return
            else:
                self._world.reader.pause()


class Wire(IdealWire):
    """An ideal wire that knows for which press of the button it was opened."""

    def __init__(self, world: World, pressed: int) -> None:
        super().__init__()
        self._world, self._pressed = world, pressed

    def put(self, drive_v: float) -> RawSample:
        self._world.driven(self._pressed, drive_v)
        return super().put(drive_v)


class World:
    """A server, a bench, and people who press buttons; what happens next is drawn."""

    def __init__(self, folder: Path, draw: Callable[[Any], Any], monkeypatch: pytest.MonkeyPatch) -> None:
        self.draw, self.now_s, self.presses = draw, 0.0, 0
        self.loop = asyncio.new_event_loop()
        self.loop.time = lambda: self.now_s  # type: ignore[method-assign]
        self.clock = clock = SimpleNamespace(now_s=lambda: self.now_s)
        monkeypatch.setattr(server_session, "ListeningClock", lambda: clock)
        monkeypatch.setattr(orders, "time", SimpleNamespace(sleep=lambda _s: None))
        monkeypatch.setattr(process, "WAIT_S", 0.0)
        monkeypatch.setattr(opening, "open_rig", self.opened)
        monkeypatch.setattr(opening, "SamplePacer", lambda _period_s: SimpleNamespace(wait=lambda: None))
        monkeypatch.setattr(process, "perform", self.performed)
        run = recipes.RECIPES[messages.Pulse]._replace(run=self.run, duration_s=lambda _session, _command: 1.0)
        monkeypatch.setitem(process.RECIPES, messages.Pulse, run)
        self.turns: list[Turn] = []
        self.pressed_of: dict[int, int] = {}
        self.performing, self.opening_s = 0, 0.0
        self.stops: list[tuple[int, asyncio.Task[bool]]] = []
        self.switched_on = [0]
        self.waiting: list[tuple[int, messages.Command, int]] = []
        self.tasks: set[asyncio.Task[messages.Answer]] = set()
        self.rigs: list[GuardedRig] = []
        self.failure = ""
        self.loop.run_until_complete(self._begin(folder))

    async def _begin(self, folder: Path) -> None:
        self.handle = bench_handle.BenchHandle(bench_handle.BenchSettings("one", "simulated", folder))
        self.pipe: Any = Pipe(self)
        self.handle._process = self.pipe
        self.handle._reader = asyncio.create_task(self.handle._read(self.pipe))
        self.server = server_session.Session([self.handle], folder)
        self.bench = self.server.bench("one")
        self.viewer: Any = self.server.enter()
        self.outbox = Outbox()
        shown = PublishedState("one", lambda state: self.outbox.send({"state": state}))
        ring = folder / "rows"
        if not ring.exists():
            create_ring(ring)
        self.ring = RowRing(ring)
        lock, counting = (TurnLock(lambda: self.turns) for _ in range(2))
        self.session = bench_session.BenchSession(
            "simulated",
            folder,
            shown,
            self.ring,
            deciding=lock,
            _counting=counting,  # type: ignore[arg-type]
        )
        queue: Any = object.__new__(orders.OrderQueue)  # without its threads
        queue._session, queue._source, queue._outbox = self.session, self.pipe, self.outbox
        queue._waiting, queue._alive_s, queue._ending_since_s = orders.queue.SimpleQueue(), 0.0, None
        queue._clock, queue._watched_s = self.clock, 0.0
        self.queue = queue
        opening.show_off(self.session)
        self.reader = Turn(FILES, queue._read)
        self.turns.append(self.reader)
        self.main = Turn(FILES, lambda: process.run_session(self.session, queue))
        self.turns.append(self.main)

    # What the bench does

    def opened(self, *_arguments: Any, **_options: Any) -> GuardedRig:
        """Open a rig, which takes a while; other things happen meanwhile."""
        ends_s = self.now_s + self.opening_s
        device = Wire(self, self.performing)
        rig = GuardedRig(device)
        while self.now_s < ends_s:
            self.main.pause()
        self.rigs.append(rig)
        return rig

    def performed(self, session: bench_session.BenchSession, order: orders.NumberedOrder) -> None:
        self.performing = self.pressed_of[order._number]
        PERFORM(session, order)

    def run(self, session: bench_session.BenchSession, _command: Any) -> None:
        """A run of a few samples."""
        for _ in range(SAMPLES_OF_A_RUN):
            rig = recipes.rig_of(session)
            rig.exchange(3.0)
            begun, session.on_first_row = session.on_first_row, None
            if begun is not None:
                begun()
            self.main.pause()
            if session.ending:
                raise bench_session.RunEndedError(session.ending)

    def driven(self, pressed: int, drive_v: float) -> None:
        """A drive is put out: the last stop that was confirmed came before the rig was ordered on."""
        confirmed = [pressed_stop for pressed_stop, _ in self.stops[: self.outbox.stops_confirmed]]
        if confirmed and pressed < confirmed[-1] and drive_v > 0.0:
            self.failure = f"{drive_v} V for press {pressed} after stop {confirmed[-1]} was confirmed"

    def die(self) -> None:
        """The process is killed: its threads end where they are."""
        self.outbox.is_dead = True
        while self.outbox.lines:
            self.pipe.stdout.feed_data(self.outbox.lines.popleft())
        self.pipe.stdout.feed_eof()
        for turn in self.turns:
            turn.kill()

    # What people do

    def press(self, do: str) -> None:
        """A command arrives; its task begins when it is drawn."""
        self.presses += 1
        if do == "stop":
            self.stops.append((self.presses, self._now(self._stop())))
            return
        if do == "switch_on":
            self.switched_on.append(self.presses)
        command = messages.read_command({"do": do})
        self.waiting.append((self.presses, command, self.handle.stops))

    async def _stop(self) -> asyncio.Task[bool]:
        stopping = asyncio.create_task(self.bench.stopped("somebody", 60.0))
        await asyncio.sleep(0)
        return stopping

    def begin_task(self, index: int) -> None:
        pressed, command, stops_before = self.waiting.pop(index % len(self.waiting))
        self.pressed_of[self.handle._numbers + 1] = pressed
        self._now(self._begun(command, stops_before))

    async def _begun(self, command: Any, stops_before: int) -> None:
        task = asyncio.create_task(self.server.command(self.bench, command, "somebody", stops_before))
        self.tasks.add(task)
        await asyncio.sleep(0)

    def _now(self, coroutine: Any) -> Any:
        return self.loop.run_until_complete(coroutine)

    def server_reads(self) -> None:
        """The server reads what the bench has sent so far, and its timers run."""
        while self.outbox.lines:
            self.pipe.stdout.feed_data(self.outbox.lines.popleft())

        async def turns() -> None:
            for _ in range(6):
                await asyncio.sleep(0)

        self._now(turns())

    def happens(self) -> None:
        """Draw what happens next."""
        what = self.draw(st.sampled_from(ACTIONS))
        if what in ("switch_on", "stop", "pulse", "end"):
            self.press(what)
        elif what == "begin":
            if self.waiting:
                self.begin_task(self.draw(st.integers(0, 3)))
        elif what == "reader":
            self.reader.step(self.draw(st.integers(1, 25)))
        elif what == "loop":
            self.main.step(self.draw(st.integers(1, 60)))
        elif what == "server":
            self.server_reads()
        elif what == "time":
            self.now_s += self.draw(st.floats(0.0, 0.7))
        elif what == "control":
            self.server.ask(self.bench, self.viewer.key, "somebody")
        elif what == "leases":
            self.server.end_lost_leases()
        elif what == "gone":
            self.server.leave(self.viewer)
        elif what == "dies" and self.draw(st.integers(0, 9)) == 0:
            self.pipe.kill()
        assert not self.failure, self.failure

    def comes_to_rest(self) -> None:
        """Everything that waits is done, by a clock that stands still."""
        for _ in range(ROUNDS):
            while self.waiting:
                self.begin_task(0)
            self.reader.step(40)
            self.main.step(60)
            self.server_reads()
            self.now_s += 0.05
            idle = not self.pipe.lines and self.queue._waiting.empty() and not self.session.queued
            if self.pipe.returncode is not None or (idle and all(stop.done() for _, stop in self.stops)):
                break
        self.server_reads()
        for turn in self.turns:
            if turn.failure is not None:
                raise turn.failure
        assert not self.failure, self.failure
        assert all(stop.result() for _, stop in self.stops)
        if self.pipe.returncode is None and self.stops and self.stops[-1][0] > self.switched_on[-1]:
            self.main.step(300)  # nothing may come of it any more
            assert not self.failure, self.failure
            for rig in self.rigs:
                with pytest.raises(RigError, match="closed"):
                    rig.exchange(0.3)
            assert self.session.shown.state.phase == "stopped"
            assert self.handle.state["phase"] == "stopped"

    def close(self) -> None:
        self.pipe.kill()
        self.server_reads()
        for task in asyncio.all_tasks(self.loop):
            task.cancel()
        self.server_reads()
        self.loop.close()
        self.ring.close()


PERFORM = process.perform
ACTIONS = (
    *(
        "switch_on",
        "switch_on",
        "stop",
        "stop",
        "pulse",
        "end",
        "begin",
        "begin",
        "begin",
        "reader",
        "reader",
        "reader",
    ),
    *("loop", "loop", "loop", "loop", "server", "server", "time", "control", "leases", "gone", "dies"),
)


def one_interleaving(folder: Path, data: st.DataObject) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch:
        world = World(folder, data.draw, monkeypatch)
        try:
            world.opening_s = data.draw(OPENING_S)
            for _ in range(data.draw(st.integers(5, 40))):
                world.happens()
            world.comes_to_rest()
        finally:
            world.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("session")


@given(data=st.data())
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
def test_after_a_stop_nothing_is_out_until_switch_on_was_pressed_after_it(folder: Path, data: st.DataObject) -> None:
    one_interleaving(folder, data)


@pytest.mark.full
@given(data=st.data())
@settings(max_examples=5000, deadline=None, suppress_health_check=list(HealthCheck))
def test_of_five_thousand_interleavings_none_loses_a_stop(folder: Path, data: st.DataObject) -> None:
    one_interleaving(folder, data)
