"""Messages between a bench's process and the server: one JSON object a line, over a pipe."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Iterator
from typing import IO, Any

from pydantic_core import to_json


class MessageWriter:
    """Writes messages whole, from any thread; a server that has ended is no error here: the reading end notices it."""

    def __init__(self, descriptor: int) -> None:
        """Write to an open file descriptor."""
        self._descriptor, self._lock = descriptor, threading.Lock()

    def send(self, message: dict[str, Any]) -> None:
        """Send a message, with null for NaN and infinities."""
        data = to_json(message, inf_nan_mode="null") + b"\n"
        with self._lock:
            try:
                while data:
                    data = data[os.write(self._descriptor, data) :]
            except OSError:
                return


def lines_of(source: IO[bytes]) -> Iterator[dict[str, Any]]:
    """Return messages as they come, until the other end closes the pipe."""
    for line in source:
        message = json.loads(line)
        if isinstance(message, dict):
            yield message
