"""A session: its benches, who watches, who has control, and what everybody is sent thirty times a second."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections import deque
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from musclewire.controllers import rule_base_names
from musclewire.errors import CallerError, nearest_hint
from musclewire.extras.live._messages import Answer, Command, Stop
from musclewire.extras.live._messages import Control as ClosedLoop
from musclewire.extras.live._server.access import (
    LEASE_AT_REST_S,
    BenchControl,
    ControlClient,
    RequestOutcome,
)
from musclewire.extras.live._server.frames import FrameMaker, RowFrame
from musclewire.extras.live._server.json_texts import compact
from musclewire.extras.live._server.socket_messages import ControlMessage, Hello, Ping
from musclewire.extras.live._server.viewers import Viewer
from musclewire.extras.live._silence import PING_S, ListeningClock

if TYPE_CHECKING:
    from musclewire.extras.live._bench_handle import BenchHandle

FRAME_S = 1.0 / 30.0  # [s] from one frame of rows to the next: no screen shows more
LEASE_CHECK_S = 0.05  # [s] from one check of the leases to the next, by which a lost one ends late
MAX_VIEWERS = 32
ORDERED = "the drive is being switched off; the state says when it is"


class OnlineBench:
    """A bench with what the server knows of it."""

    def __init__(self, handle: BenchHandle) -> None:
        """Begin without holder, viewers and rows."""
        self.handle, self.control = handle, BenchControl()
        self.state_changed = True
        self._frames, self._cursor = FrameMaker(), -1
        self.on_phase: Callable[[OnlineBench], None] | None = None
        self._phase_seen = ""
        handle.on_change.append(self._on_change)

    @property
    def name(self) -> str:
        """The bench's identifier."""
        return self.handle.identifier

    @property
    def phase(self) -> str:
        """What the bench is doing, in one word of the interface."""
        return str(self.handle.state["phase"])

    def _on_change(self, _handle: BenchHandle) -> None:
        self.state_changed = True
        if self.phase != self._phase_seen and self.on_phase is not None:
            self._phase_seen = self.phase
            self.on_phase(self)

    async def stopped(self, who: str, max_wait_s: float) -> bool:
        """Stop, and return whether this stop was confirmed within a time [s]: the drive was off then.

        The phase would not do: it may be that of before an order to switch on which is still on its way.
        """
        confirmation = self.handle.stop(who)
        await asyncio.wait([confirmation], timeout=max_wait_s)
        return confirmation.done()

    def new_frames(self) -> list[RowFrame]:
        """Return the frames of the rows that have come since the last time."""
        cursor, parts, _ = self.handle.rows(self._cursor)
        state, layouts = self.handle.state, self.handle.layouts
        if any(layout not in layouts for layout, _ in parts):
            return []  # rows are faster than the message with their columns: they are read again next time
        self._cursor = cursor
        frames = [self._frames.frame(layout, layouts[layout], rows, state) for layout, rows in parts]
        return [frame for frame in frames if len(frame.rows)]

    def skip_rows(self) -> None:
        """Leave out rows that nobody watches."""
        self._cursor = -1


class Session:
    """The benches of a session, not started, and everybody who is connected to them."""

    def __init__(self, handles: Sequence[BenchHandle], folder: Path, *, token_needed: bool = False) -> None:
        """Begin without viewers; benches are started by ``start``."""
        self.benches = {handle.identifier: OnlineBench(handle) for handle in handles}
        for bench in self.benches.values():
            bench.on_phase = self.send_state  # at once: it may say that the drive is off
        self.folder, self.token_needed = folder, token_needed
        self.viewers: dict[str, Viewer] = {}
        self._count, self._pings = 0, deque[tuple[int, float]](maxlen=64)
        self._ping, self._closed = 0, False
        self._clock = ListeningClock()

    async def start(self) -> None:
        """Start the process of every bench."""
        await asyncio.gather(*(bench.handle.start() for bench in self.benches.values()))

    async def close(self) -> None:
        """End the process of every bench, its drive off; every one is tried, whatever becomes of the others."""
        if self._closed:
            return
        self._closed = True
        ends = await asyncio.gather(*(one.handle.close() for one in self.benches.values()), return_exceptions=True)
        for end in ends:
            if isinstance(end, BaseException):
                raise end

    async def run(self) -> None:
        """Send what is new and watch over the leases until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(repeat(FRAME_S, self.send_news))
            tasks.create_task(repeat(LEASE_CHECK_S, self.end_lost_leases))
            tasks.create_task(repeat(PING_S, self.ping))

    def bench(self, name: str) -> OnlineBench:
        """Return a bench by name. CallerError for an unknown one."""
        bench = self.benches.get(name)
        if bench is None:
            raise CallerError(f"no bench '{name[:100]}'{nearest_hint(name[:100], self.benches)}")
        return bench

    def stops(self) -> dict[str, int]:
        """Return how many stops each bench has had: what arrives now comes after them."""
        return {name: bench.handle.stops for name, bench in self.benches.items()}

    # Viewers

    def enter(self, place: tuple[str, int] | None = None) -> Viewer | None:
        """Return a new viewer at an address and port, already sent all there is to know; None if there are too many."""
        if len(self.viewers) >= MAX_VIEWERS:
            return None
        self._count += 1
        viewer = Viewer(secrets.token_urlsafe(24), f"viewer {self._count}", place)
        self.viewers[viewer.key] = viewer
        hello = Hello(
            version=version("musclewire"), you=viewer.name, benches=list(self.benches), token_needed=self.token_needed
        )
        viewer.say(hello.model_dump_json())
        for bench in self.benches.values():
            viewer.show_state(bench.name, state_text(bench))
            self._tell_control(viewer, bench)
        return viewer

    def leave(self, viewer: Viewer) -> None:
        """Forget a viewer; what they controlled ends."""
        self.viewers.pop(viewer.key, None)
        for bench in self.benches.values():
            self.give_up(bench, viewer.key, f"{viewer.name} has left")

    def is_kept(self, place: Any, lease: str | None) -> bool:
        """Return whether an open page is at a place, or somebody with a lease has control or asks for it."""
        if any(viewer.place == place for viewer in self.viewers.values()):
            return True
        now_s, controls = self._clock.now_s(), (bench.control for bench in self.benches.values())
        people = (one for each in controls for one in (each.holder, each.asking) if one is not None)
        return any(one.key == lease and one.is_there(now_s, LEASE_AT_REST_S) for one in people)

    def pong(self, key: str, number: int) -> None:
        """Note an answer to a ping; one to an old ping or to none says nothing."""
        now_s = self._clock.now_s()
        if any(ping == number and now_s - sent_s <= self.pong_s for ping, sent_s in self._pings):
            self.sign_of_life(key)

    @property
    def pong_s(self) -> float:
        """How old a ping may be for its answer to count [s]: as old as a lease, the shortest of all benches."""
        return min(bench.control.lease_s for bench in self.benches.values())

    def sign_of_life(self, key: str) -> None:
        """Note that somebody is there."""
        for bench in self.benches.values():
            bench.control.sign_of_life(key, self._clock.now_s())

    # Control

    def ask(self, bench: OnlineBench, key: str, name: str) -> RequestOutcome:
        """Take control of a bench, or ask its holder for it."""
        outcome = bench.control.ask(key, name, self._clock.now_s())
        self.tell_control(bench)
        return outcome

    def answer(self, bench: OnlineBench, key: str, give: bool) -> bool:
        """Answer who asks for control, as its holder; return whether it went over."""
        gone = bench.control.answer(key, give, self._clock.now_s())
        self.tell_control(bench)
        return gone

    def give_up(self, bench: OnlineBench, key: str, why: str) -> None:
        """Take control from somebody who leaves it; a heated run ends."""
        asked = bench.control.asking
        if bench.control.leave(key):
            bench.handle.release(why)
            self.tell_control(bench)
        elif asked is not bench.control.asking:
            self.tell_control(bench)

    def end_lost_leases(self) -> None:
        """Take control from holders who are no longer there; a heated run of theirs ends."""
        now_s = self._clock.now_s()
        for bench in self.benches.values():
            silence_s = bench.handle.settings.max_silence_s
            bench.control.lease_s = silence_s if bench.handle.state.get("doing") else LEASE_AT_REST_S
            asked = bench.control.asking
            lost = bench.control.end_lost(now_s)
            if lost is not None:
                bench.handle.release(f"the connection to {lost.name}, who had control, was lost")
            if lost is not None or asked is not bench.control.asking:
                self.tell_control(bench)

    def may_command(self, bench: OnlineBench, key: str | None) -> bool:
        """Return whether somebody has control of a bench."""
        return bench.control.holds(key, self._clock.now_s())

    async def command(self, bench: OnlineBench, command: Command, who: str, stops_before: int) -> Answer:
        """Pass a command that arrived after so many stops on to the bench; whoever sends it is permitted to."""
        if isinstance(command, Stop):
            bench.handle.stop(who)
            return Answer(True, ORDERED)
        refuse_paths(command)
        return await bench.handle.command(command, stops_before)

    # What everybody is sent

    def ping(self) -> None:
        """Ask every viewer for a sign of life, and show the benches whose holders are there that they are."""
        self._ping += 1
        now_s = self._clock.now_s()
        self._pings.append((self._ping, now_s))
        for viewer in self.viewers.values():
            viewer.say(Ping(n=self._ping).model_dump_json())
        for bench in self.benches.values():
            holder = bench.control.holder
            if holder is not None and holder.is_there(now_s, bench.handle.settings.max_silence_s):
                bench.handle.alive()

    def send_news(self) -> None:
        """Send the rows since the last time, and every state that has changed."""
        for bench in self.benches.values():
            if bench.state_changed:
                self.send_state(bench)
            if not self.viewers:
                bench.skip_rows()
                continue
            for frame in bench.new_frames():
                self._show(bench.name, frame)

    def send_state(self, bench: OnlineBench) -> None:
        """Send every viewer the state of a bench."""
        bench.state_changed = False
        text = state_text(bench)
        for viewer in self.viewers.values():
            viewer.show_state(bench.name, text)

    def _show(self, bench: str, frame: RowFrame) -> None:
        message: dict[str, Any] = {
            "type": "rows",
            "bench": bench,
            "layout": frame.layout,
            "rows": frame.rows.tolist(),
            "rules": frame.rules,
        }
        text, with_columns, seen = compact(message), "", (bench, frame.layout)
        for viewer in self.viewers.values():
            if seen in viewer.layouts_seen:
                viewer.show_rows(text)
                continue
            # Columns must arrive, so the first rows of a layout are among the messages that are never dropped.
            with_columns = with_columns or compact({**message, "columns": frame.columns})
            viewer.layouts_seen.add(seen)
            viewer.say(with_columns)

    def tell_control(self, bench: OnlineBench) -> None:
        """Show every viewer who has control of a bench."""
        for viewer in self.viewers.values():
            self._tell_control(viewer, bench)

    def _tell_control(self, viewer: Viewer, bench: OnlineBench) -> None:
        control = bench.control
        message = ControlMessage(
            bench=bench.name,
            holder=name_of(control.holder),
            you_hold=control.holder is not None and control.holder.key == viewer.key,
            asked_by=name_of(control.asking),
        )
        viewer.say(message.model_dump_json())


def name_of(person: ControlClient | None) -> str | None:
    """Return the name that others see."""
    return None if person is None else person.name


def state_text(bench: OnlineBench) -> str:
    """Return the message with a bench's state."""
    return compact({"type": "state", "state": bench.handle.state})


def refuse_paths(command: Command) -> None:
    """Refuse a rule base that is not one of ours: any other name of one is the path of a file."""
    if not isinstance(command, ClosedLoop) or not command.settings or "rule_base" not in command.settings:
        return
    named = command.settings["rule_base"]
    if named not in rule_base_names():
        raise CallerError(
            f"command: settings.rule_base: no rule base of that name; known: {', '.join(rule_base_names())}"
        )


async def repeat(period_s: float, function: Any) -> None:
    """Call a function every ``period_s`` [s]; after a delay the calls that were missed are left out."""
    due_s = time.monotonic()
    while True:
        function()
        due_s = max(due_s + period_s, time.monotonic())
        await asyncio.sleep(due_s - time.monotonic())
