"""Threads that go on line by line, as the test says: any order it draws is one that the scheduler might have taken.

Only lines of the files that are named count. A lock that is held is waited for by giving the turn back.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

# Only so that a fault does not hang a test.
MAX_WAIT_S = 60.0


class Killed(BaseException):
    """The process of these threads has been killed."""


class Turn:
    """A thread that stands still until it is told to go on."""

    def __init__(self, files: frozenset[str], target: Callable[[], None]) -> None:
        self._files, self._target = files, target
        self._go, self._still = threading.Lock(), threading.Lock()  # held while nobody may go on; while it goes on
        self._go.acquire(), self._still.acquire()
        self._lines = 0
        self.is_over = self._is_killed = False
        self.failure: BaseException | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def step(self, lines: int) -> None:
        """Let it go on by so many lines, to where it gives the turn back, or to its end."""
        if self.is_over:
            return
        self._lines = lines
        self._go.release()
        assert self._still.acquire(timeout=MAX_WAIT_S)

    def kill(self) -> None:
        """End it where it is."""
        self._is_killed = True
        self.step(1)
        self._thread.join(MAX_WAIT_S)

    def pause(self) -> None:
        """Give the turn back; called by the thread itself."""
        if self._is_killed:
            raise Killed
        self._still.release()
        self._go.acquire()
        if self._is_killed:
            raise Killed

    def _run(self) -> None:
        self._go.acquire()
        sys.settrace(self._entered)
        try:
            self._target()
        except Killed:
            pass
        except BaseException as failure:  # shown by the test, which runs in another thread
            self.failure = failure
        finally:
            sys.settrace(None)
            self.is_over = True
            self._still.release()

    def _entered(self, frame: FrameType, _event: str, _what: Any) -> Any:
        return self._line if frame.f_code.co_filename in self._files and not self._is_killed else None

    def _line(self, _frame: FrameType, event: str, _what: Any) -> Any:
        if event == "line" and not self._is_killed:
            self._lines -= 1
            if self._lines < 0:
                self.pause()
        return self._line


class TurnLock:
    """A re-entrant lock between such threads."""

    def __init__(self, turns: Callable[[], list[Turn]]) -> None:
        self._turns, self._owner, self._depth = turns, 0, 0

    def __enter__(self) -> bool:
        me = threading.get_ident()
        while self._owner not in (0, me):
            next(turn for turn in self._turns() if turn._thread.ident == me).pause()
        self._owner, self._depth = me, self._depth + 1
        return True

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._depth -= 1
        if not self._depth:
            self._owner = 0
