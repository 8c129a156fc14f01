"""Ctrl-C and SIGTERM, taken between two samples of a run and at once everywhere else.

A signal that becomes an exception inside compiled code's Python callbacks is lost there or worse (Numba raises
SystemError, or the process dies). So while a rig is open the first signal only leaves a note, which the run reads
after its next sample; a second one does not wait. While a rig is being opened there is no sample to wait for, and
nothing is out yet: the first signal ends the opening, unless it comes while a kernel is being compiled.

When all that is to be done at exit is done, nothing is taken apart any more: Numba's machine code and all modules take
the interpreter a second, and more than ten on a busy machine, in which people press Ctrl-C again or kill.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from musclewire.rigs import DeviceConfiguration, GuardedRig

# An ending takes this long at most; after that a further signal counts again.
PATIENCE_S = 2.0
COMPILER = {"numba", "llvmlite"}
STOPPED = {130: "Ctrl-C", 143: "SIGTERM"}


class StoppedCommand(SystemExit):
    """A command that was stopped, with what is left of it in words; without them a rig was made safe."""

    def __init__(self, code: int, rest: str) -> None:
        """Take the exit code and what to say."""
        super().__init__(code)
        self.rest = rest


class _SignalState:
    """Whether signals wait for a sample now, and the exit code of one that does."""

    waiting_allowed = False
    opening = False
    exit_code: int | None = None
    ending_since_s: float | None = None


def listen_for_signals() -> None:
    """Take both signals, also where SIGINT came ignored, as in a shell's background job."""
    signal.signal(signal.SIGINT, _on_signal)
    signal.signal(signal.SIGTERM, _on_signal)


def _on_signal(number: int, frame: FrameType | None) -> None:
    if _SignalState.ending_since_s is not None and time.monotonic() - _SignalState.ending_since_s < PATIENCE_S:
        return  # a double Ctrl-C must not break into the ending that the first one began
    ends_opening = _SignalState.opening and not is_compiling(frame)
    if _SignalState.waiting_allowed and _SignalState.exit_code is None and not ends_opening:
        _SignalState.exit_code = 128 + number
        return
    _SignalState.ending_since_s = time.monotonic()
    raise SystemExit(128 + number)


def is_compiling(frame: FrameType | None) -> bool:
    """Return whether a frame belongs to the compiler, which an exception at any moment may leave in disorder."""
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).partition(".")[0] in COMPILER:
            return True
        frame = frame.f_back
    return False


def ignore_signals() -> None:
    """Let the process end in peace: its exit code is decided."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)


def stop_if_asked(_row: Mapping[str, float] | None = None) -> None:
    """Raise SystemExit if a signal has left its note; serves as a callback after each sample."""
    if _SignalState.exit_code is not None:
        code, _SignalState.exit_code = _SignalState.exit_code, None
        _SignalState.ending_since_s = time.monotonic()
        raise SystemExit(code)


@contextmanager
def opened_rig(rig: str | DeviceConfiguration, **given: Any) -> Iterator[GuardedRig]:
    """Open a rig, as ``open_rig`` does, and close it at the end of the block; a signal ends the opening.

    A signal that came while a kernel was being compiled ends the command before the first sample.
    """
    from musclewire.rigs import open_rig

    _SignalState.opening = True
    try:
        opened = open_rig(rig, **given)
    finally:
        _SignalState.opening = False
    with opened:
        stop_if_asked()
        yield opened


@contextmanager
def stops_between_samples() -> Iterator[None]:
    """Let signals wait for the end of a sample inside this block, and for its end at the latest."""
    _SignalState.waiting_allowed = True
    try:
        yield
    finally:
        _SignalState.waiting_allowed = False
    stop_if_asked()


_codes: list[int] = []


@contextmanager
def leaves_at_once() -> Iterator[None]:
    """End the process with the exit code that ends the block, after its threads and all functions registered for exit.

    To be entered before anything else is imported: what is registered first is called last.
    """
    atexit.register(_leave)
    try:
        yield
    except SystemExit as end:
        if isinstance(end.code, int):
            _codes.append(end.code)
        raise


def _leave() -> None:
    """End the process, if its exit code is known; otherwise an error is on its way, which the interpreter shows."""
    if not _codes:
        return
    for stream in filter(None, (sys.stdout, sys.stderr)):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(_codes[-1])
