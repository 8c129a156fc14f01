"""A thread that looks whether anybody still talks to a rig whose samples come at the pace of a real clock."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from threading import Event, Thread
from typing import Any


class IdleWatch:
    """Asks a rig again and again to look at its own silence, until it is closed or nobody holds it any more.

    Of ``look``, which returns after how many seconds to look again, only a weak reference is kept.
    """

    def __init__(self, look: Callable[[], float], first_s: float) -> None:
        """Start the thread; it keeps no interpreter alive."""
        self._ended = Event()
        arguments = (weakref.WeakMethod(look), self._ended, first_s)
        Thread(target=watch, args=arguments, name="musclewire idle watch", daemon=True).start()

    def end(self) -> None:
        """Let the thread end; from any thread, its own too."""
        self._ended.set()


def watch(look_again: Callable[[], Any], ended: Event, wait_s: float) -> None:
    """Look, and wait for as long as the look says."""
    while not ended.wait(wait_s):
        look = look_again()
        if look is None:
            return
        wait_s = look()
        del look  # while it waits the thread holds no rig
