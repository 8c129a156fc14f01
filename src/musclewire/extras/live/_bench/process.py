"""What the process of one bench does, from its first line to the end of its server."""

from __future__ import annotations

import json
import logging
import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from musclewire.errors import CallerError, MusclewireError, NumericsError, RecordingNotWrittenError, RigError
from musclewire.extras.live import _messages as messages
from musclewire.extras.live._bench.lines import MessageWriter
from musclewire.extras.live._bench.opening import show_off, show_wiring, switch_on
from musclewire.extras.live._bench.orders import NumberedOrder, OrderQueue
from musclewire.extras.live._bench.recipes import RECIPES, CommandRecipe, rig_of
from musclewire.extras.live._bench.session import BenchSession, RunEndedError
from musclewire.extras.live._bench.state import PublishedState
from musclewire.extras.live._ring import RowRing
from musclewire.rigs import pin_to_cpu, take_priority
from musclewire.signals import JOURNAL_SUFFIX, recording_of, recover_recording

# How long a bench without an open rig waits for an order before it looks again whether it is to end [s].
WAIT_S = 0.2


def run_session(session: BenchSession, orders: OrderQueue) -> None:
    """Serve a session until its server ends; the rig is off then."""
    with missed_deadlines_shown(session):
        serve_orders(session, orders)


class MissedDeadlines(logging.Handler):
    """Shows on the page what the rig says when the loop was late and the drive fell to the sense voltage."""

    def __init__(self, session: BenchSession) -> None:
        """Show it in this session."""
        super().__init__(logging.INFO)
        self._session = session

    def emit(self, record: logging.LogRecord) -> None:
        """Show one message, with its time on the plots."""
        text = f"missed deadline, at {self._session.now_s:.1f} s on the plots: {record.getMessage()}"
        self._session.shown.say("warning", text)


@contextmanager
def missed_deadlines_shown(session: BenchSession) -> Iterator[None]:
    """Show the messages of rigs inside; the page's plots show only the voltage that fell."""
    logger, handler = logging.getLogger("musclewire.rigs"), MissedDeadlines(session)
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)


def serve_orders(session: BenchSession, orders: OrderQueue) -> None:
    """Carry out orders until the server ends, and switch the rig off."""
    try:
        while not session.quitting:
            resting = session.shown.state.phase == "ready"
            order = orders.next(0.0 if resting else WAIT_S)
            if order is not None:
                perform(session, order)
            elif resting:
                rest(session)
    finally:
        if session.rig is not None:
            session.rig.close()


def rest(session: BenchSession) -> None:
    """Take one sample at the sense voltage, so that the page lives while nothing is being done."""
    assert session.rig is not None
    try:
        session.show_rest(session.rig.exchange(session.rig.sense_voltage_v))
    except (RigError, NumericsError) as problem:
        failed(session, problem)


def perform(session: BenchSession, order: NumberedOrder) -> None:
    """Carry out a command and answer it: as begun with its first sample, as refused if it raises an error before."""
    command, refused = order.command, ""
    try:
        if isinstance(command, messages.SwitchOn):
            switch_on(session, order.stops_before)
        else:
            carry_out(session, order, RECIPES[type(command)])
    except (RigError, NumericsError, RecordingNotWrittenError) as problem:
        refused = str(problem)
        failed(session, problem)
    except MusclewireError as problem:
        refused = str(problem)
        session.shown.say("error", refused)
    finally:
        make_room(session, order)
    order.answer(not refused, refused)


def make_room(session: BenchSession, order: NumberedOrder) -> None:
    """Let the next command in: before an answer or "ready" is sent, since whoever sees either may send it at once."""
    if not order.is_over:
        order.is_over, session.queued = True, ""


def carry_out(session: BenchSession, order: NumberedOrder, recipe: CommandRecipe) -> None:
    """Do what a command asks for; afterwards the bench is ready again, if the rig still is."""
    require_ready(session)
    doing = {
        "experiment": order.command.do,
        "title": recipe.title,
        "duration_s": recipe.duration_s(session, order.command),
        "steering": isinstance(getattr(order.command, "reference", None), messages.Steer),
        "started_at": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    with busy(session, order, doing, heats=recipe.heats):
        # A recipe computes before its first sample (a fit, compiling): a pause, and no sample that comes too late.
        rig_of(session).make_safe()
        try:
            recipe.run(session, order.command)
        except RunEndedError as ended:
            session.shown.say("info" if session.end_asked() else "warning", f"the run ended before its time: {ended}")


def require_ready(session: BenchSession) -> None:
    """Raise CallerError if the rig is not switched on, or is not any more."""
    if session.shown.state.phase != "ready":
        raise CallerError("the rig is not switched on: switch on first")


@contextmanager
def busy(session: BenchSession, order: NumberedOrder, doing: dict[str, Any], *, heats: bool) -> Iterator[None]:
    """Mark the session as busy inside; a stop before or meanwhile stays what it is."""
    with session.deciding:
        require_ready(session)
        session.ending, session.on_first_row = "", lambda: order.answer(True)
        session.shown.change(phase="busy", doing=doing)
    session.heating, failing = heats, False
    try:
        yield
    except (RigError, NumericsError) as problem:
        failing = not isinstance(problem, RecordingNotWrittenError)  # then the rig is off: it was never ready again
        raise
    finally:
        session.heating, session.on_first_row = False, None
        session.note_recordings()
        with session.deciding:
            if session.shown.state.phase == "busy" and not failing:
                make_room(session, order)
                session.shown.change(phase="ready", doing=None)


def failed(session: BenchSession, problem: MusclewireError) -> None:
    """Show that the rig is off because of an error; after a stop, that stays the reason."""
    rig = session.rig
    if isinstance(problem, RecordingNotWrittenError) and not session.stopped.by:
        session.shown.say("error", str(problem))  # the rig is well and at its sense voltage
        return
    if rig is not None:
        rig.close()
    with session.deciding:
        if not session.stopped.by:
            session.shown.say("error", str(problem))
            session.shown.change(phase="failed", why=str(problem), doing=None)


def main() -> int:
    """Read how to begin from the first line, then serve until the server ends."""
    outbox = MessageWriter(os.dup(1))
    os.dup2(2, 1)  # whatever prints belongs to the log, not between the messages
    # Ctrl-C on the server's terminal is for the server, which then ends this process in its own time.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Not sys.stdin: Python aborts at its end if another thread still reads from that.
    source = os.fdopen(os.dup(0), "rb")
    setup: dict[str, Any] = json.loads(source.readline())
    shown = PublishedState(setup["bench"], lambda state: outbox.send({"state": state}))
    session = BenchSession(
        setup["rig"], Path(setup["folder"]), shown, RowRing(Path(setup["ring"])), setup["seed"], setup["max_silence_s"]
    )
    signal.signal(signal.SIGTERM, lambda _number, _frame: ended_by_signal(session))
    # Before the threads: they inherit core and priority, and a busy loop cannot keep a stop waiting.
    refused = apply_scheduling(setup)
    orders = OrderQueue(session, source, outbox)
    show_wiring(session)
    finish_journals(session)
    session.note_recordings()
    show_off(session)
    shown.say("warning", *refused)
    run_session(session, orders)
    return 0


def finish_journals(session: BenchSession) -> None:
    """Finish recordings of runs that were cut off by a power cut or a kill; one that still runs is left alone."""
    for journal in sorted(session.folder.glob(f"*.h5{JOURNAL_SUFFIX}")):
        try:
            recording = recover_recording(journal)
        except MusclewireError as problem:
            session.shown.say("warning", str(problem))
        else:
            kept = f"{recording_of(journal).name}: a run that was cut off, {len(recording)} samples of it are kept"
            session.shown.say("info", kept)


def apply_scheduling(setup: dict[str, Any]) -> list[str]:
    """Pin this process and take priority as asked for; return what the system refused."""
    try:
        if setup["cpu"] is not None:
            pin_to_cpu(setup["cpu"])
        return take_priority() if setup["priority"] else []
    except CallerError as problem:
        return [str(problem)]


def ended_by_signal(session: BenchSession) -> None:
    """Switch off and end."""
    session.quitting = True
    session.stop("SIGTERM")
