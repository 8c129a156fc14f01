"""Somebody who watches: what waits to be sent to them, and never more than that.

What a viewer is sent is put here without waiting and taken out by a task of its own. A connection that does not take
it in loses rows, gets of each state only the newest, and is closed when its messages stop moving. No one else waits.
"""

from __future__ import annotations

import asyncio
from collections import deque

MAX_FRAMES = 8  # frames of rows that may wait: a quarter of a second at 30 Hz
MAX_MESSAGES = 200  # other messages that may wait: they are few, and more mean a dead connection


class ViewerTooSlowError(Exception):
    """A viewer's messages pile up: their connection is closed."""


class Viewer:
    """One who watches; by their ``key``, a secret, they have control."""

    def __init__(self, key: str, name: str, place: tuple[str, int] | None = None) -> None:
        """Begin with nothing to send."""
        self.key, self.name, self.place = key, name, place
        self.layouts_seen: set[tuple[str, int]] = set()
        self._messages: deque[str] = deque()
        self._states: dict[str, str] = {}
        self._frames: deque[str] = deque()
        self._something = asyncio.Event()

    def say(self, text: str) -> None:
        """Send a message, in order with the others."""
        self._messages.append(text)
        self._something.set()

    def show_state(self, bench: str, text: str) -> None:
        """Send the state of a bench; one that still waits is replaced."""
        self._states[bench] = text
        self._something.set()

    def show_rows(self, text: str) -> None:
        """Send a frame of rows; if too many wait, the oldest is dropped."""
        if len(self._frames) >= MAX_FRAMES:
            self._frames.popleft()
        self._frames.append(text)
        self._something.set()

    async def next_text(self) -> str:
        """Return what is to be sent next, when there is something: messages, then states, then rows."""
        while True:
            if len(self._messages) > MAX_MESSAGES:
                raise ViewerTooSlowError
            if self._messages:
                return self._messages.popleft()
            if self._states:
                return self._states.pop(next(iter(self._states)))
            if self._frames:
                return self._frames.popleft()
            self._something.clear()
            await self._something.wait()
