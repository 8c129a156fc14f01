"""The process of one bench (``python -m`` this module), started by the server and ended with it."""

from __future__ import annotations

import json
import os
import signal
import sys
from pathlib import Path
from typing import Any

from musclewire.errors import CallerError, MusclewireError
from musclewire.extras.live._bench.lines import MessageWriter
from musclewire.extras.live._bench.loop import run_session
from musclewire.extras.live._bench.opening import show_off, show_wiring
from musclewire.extras.live._bench.orders import OrderQueue
from musclewire.extras.live._bench.session import BenchSession
from musclewire.extras.live._bench.state import PublishedState
from musclewire.extras.live._ring import RowRing
from musclewire.rigs import pin_to_cpu, take_priority
from musclewire.signals import JOURNAL_SUFFIX, recording_of, recover_recording


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
    refused = scheduled(setup)
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


def scheduled(setup: dict[str, Any]) -> list[str]:
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


if __name__ == "__main__":
    sys.exit(main())
