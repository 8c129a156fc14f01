"""What the server asks of a bench: a stop is carried out at once, a target is moved at once, the rest is queued.

Two threads: one reads the pipe, the other watches that somebody is in control while the wire may be heated. Neither
touches the rig except to switch it off.
"""

from __future__ import annotations

import queue
import threading
import time
from math import isnan
from typing import IO, Any

from musclewire.errors import CallerError
from musclewire.extras.live._bench.lines import MessageWriter, lines_of
from musclewire.extras.live._bench.session import AS_ASKED, BenchSession
from musclewire.extras.live._messages import ClockSpeed, Command, End, SetTarget, SwitchOn, read_command
from musclewire.extras.live._silence import ListeningClock

# A run that was to end and has not got to its next sample by then is switched off.
MAX_ENDING_S = 0.25
WATCHED_EVERY_S = 0.05
NOBODY = "nobody in control gave a sign for {:g} s"
SERVER_ENDED = "the end of the server"


class NumberedOrder:
    """A command with the number by which it is answered, and how many stops there had been when it was read."""

    def __init__(self, number: int, command: Command, outbox: MessageWriter, stops_before: int = 0) -> None:
        """Wait to be answered."""
        self.stops_before = stops_before
        # is_over: whether the next command may come, which is before the answer and the phase that say so.
        self.command, self.is_over = command, False
        self._number, self._outbox, self._answered = number, outbox, False

    def answer(self, accepted: bool, message: str = "") -> None:
        """Answer; only the first answer counts."""
        if not self._answered:
            self._answered = True
            self._outbox.send({"answer": self._number, "accepted": accepted, "message": message})


class OrderQueue:
    """The queue of a session, and the threads that fill it and watch."""

    def __init__(self, session: BenchSession, source: IO[bytes], outbox: MessageWriter) -> None:
        """Start both threads."""
        self._session, self._source, self._outbox = session, source, outbox
        self._waiting: queue.SimpleQueue[NumberedOrder | None] = queue.SimpleQueue()
        self._clock = ListeningClock()
        self._watched_s = self._alive_s = self._clock.now_s()
        self._ending_since_s: float | None = None
        for target, name in ((self._read, "musclewire orders"), (self._watch, "musclewire watch")):
            threading.Thread(target=target, name=name, daemon=True).start()

    def next(self, wait_s: float) -> NumberedOrder | None:
        """Return the next order; None if there is none within a time [s], or if the session is to end."""
        try:
            return self._waiting.get(block=wait_s > 0.0, timeout=wait_s or None)
        except queue.Empty:
            return None

    def _read(self) -> None:
        """Take messages until the server ends; then the rig is switched off and the process ends."""
        try:
            for message in lines_of(self._source):
                self._take(message)
        finally:
            self._session.quitting = True
            self._session.stop(SERVER_ENDED)
            self._waiting.put(None)

    def _take(self, message: dict[str, Any]) -> None:
        """Carry out a message, or queue it."""
        self._alive_s = self._watched_s
        session = self._session
        if "stop" in message:
            session.stop(str(message["stop"]))
            took_s = session.stopped.took_s  # NaN if there was nothing to switch off
            self._outbox.send({"stopped": message["stop"], "took_ms": None if isnan(took_s) else 1e3 * took_s})
        elif "release" in message:
            self._end(str(message["release"]))
        elif "command" in message:
            self._command(int(message["number"]), message["command"])

    def _command(self, number: int, data: object) -> None:
        """Answer what needs no loop, refuse what has to wait for another run's end, queue the rest.

        Switching on after a stop is queued in any case: what was stopped ends by itself. A stop that comes while it
        waits makes it out of date.
        """
        try:
            order = NumberedOrder(number, read_command(data), self._outbox, self._session.stops)
        except CallerError as problem:
            self._outbox.send({"answer": number, "accepted": False, "message": str(problem)})
            return
        session = self._session
        try:
            if isinstance(order.command, SetTarget):
                session.steer(order.command.value)
            elif isinstance(order.command, ClockSpeed):
                session.set_clock_speed(order.command.factor)
            elif isinstance(order.command, End):
                self._end(AS_ASKED)
            elif session.queued and not (session.stopped.by and isinstance(order.command, SwitchOn)):
                raise CallerError(f"'{session.queued}' is running: end it first")
            else:
                session.queued = order.command.do
                self._waiting.put(order)
                return
        except CallerError as problem:
            order.answer(False, str(problem))
            return
        order.answer(True)

    def _end(self, why: str) -> None:
        """Let the present run end after its sample."""
        if self._session.shown.state.doing is not None:
            self._session.ending = why

    def _watch(self) -> None:
        """End a run that nobody watches over; switch off one that does not end."""
        session = self._session
        while not session.quitting:
            time.sleep(WATCHED_EVERY_S)
            now_s = self._watched_s = self._clock.now_s()
            if session.heating and not session.ending and now_s - self._alive_s > session.max_silence_s:
                session.ending = NOBODY.format(session.max_silence_s)
            if not (session.heating and session.ending):
                self._ending_since_s = None
            elif self._ending_since_s is None:
                self._ending_since_s = now_s
            # At its sense voltage the wire is safe, and what was recorded is being judged: that may take its time.
            elif now_s - self._ending_since_s > MAX_ENDING_S + 2.0 * session.sample_s and session.above_sense_voltage:
                session.stop(f"the bench itself, since the run did not end ({session.ending})")
                self._ending_since_s = None
