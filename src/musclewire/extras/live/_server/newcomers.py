"""Connections that have shown nothing yet: few of them may wait, and not for long, so that none keeps a stop out.

A connection is a newcomer until a request on it has passed the gate. There is no limit for those that have: a limit for
all would refuse the stop of somebody with the token, too. If newcomers are too many the one that has waited longest is
closed and the new one let in, because it may be the one that brings the stop.
"""

from __future__ import annotations

import asyncio
import logging
import socket
import sys
from typing import Any, NamedTuple

from uvicorn.protocols.http.h11_impl import H11Protocol

LOGGER = logging.getLogger("musclewire.live")
# From the connection to the last header of its first valid request.
FIRST_REQUEST_S = 5.0
# How many may wait, with so many of the files that this process may open for each; one address has at most half.
MAX_NEWCOMERS, FILES_EACH, PEERS_AT_LEAST = 128, 4, 2
REPORT_S = 60.0
# When nothing could be accepted, it is tried again after so long.
AGAIN_S = 0.05


class Newcomer(NamedTuple):
    """A connection that has shown nothing, and when it came [s]."""

    transport: asyncio.Transport
    came_s: float


class Newcomers:
    """The connections of which no request has passed the gate. All times are of one clock, given by the caller.

    Parameters
    ----------
    most
        How many may wait; half as many from one address.
    """

    def __init__(self, most: int) -> None:
        """Begin with none."""
        self._most = most
        self._waiting: dict[Any, Newcomer] = {}
        self._refused, self._why, self._reported_s = 0, "", -REPORT_S

    def __len__(self) -> int:
        """Return how many wait."""
        return len(self._waiting)

    def came(self, transport: asyncio.Transport, now_s: float) -> None:
        """Note a new connection; of too many the one that has waited longest is closed."""
        place = place_of(transport)
        self._waiting.pop(place, None)  # an old one with the same address and port is over
        same = [one for one in self._waiting if one[0] == place[0]]
        if len(same) >= self._most // PEERS_AT_LEAST:
            self._close(same[0], f"too many from {place[0]} had sent no valid request")
        elif len(self._waiting) >= self._most:
            self._close(next(iter(self._waiting)), "too many had sent no valid request")
        self._waiting[place] = Newcomer(transport, now_s)

    def passed(self, place: Any) -> None:
        """Note that a request from an address and port has passed the gate."""
        self._waiting.pop(place, None)

    def gone(self, transport: asyncio.BaseTransport) -> None:
        """Note that a connection is closed."""
        self._waiting.pop(place_of(transport), None)

    def not_accepted(self, why: str) -> None:
        """Make room after a connection could not be accepted."""
        if self._waiting:
            self._close(next(iter(self._waiting)), why)
        else:
            self._refused, self._why = self._refused + 1, why

    def look(self, now_s: float) -> None:
        """Close those that have waited too long; say, once a minute at most, how many were closed for want of room."""
        for place, one in list(self._waiting.items()):
            # A connection that asked for a WebSocket and was refused is closed by another protocol.
            if one.transport.is_closing() or now_s - one.came_s > FIRST_REQUEST_S:
                self._waiting.pop(place).transport.abort()
        if self._refused and now_s - self._reported_s >= REPORT_S:
            LOGGER.warning("closed %d connections: %s", self._refused, self._why)
            self._refused, self._reported_s = 0, now_s

    def _close(self, place: Any, why: str) -> None:
        self._waiting.pop(place).transport.abort()
        self._refused, self._why = self._refused + 1, why


def place_of(transport: asyncio.BaseTransport) -> tuple[Any, ...]:
    """Return the address and the port at the other end, as a request's scope has them."""
    return tuple(transport.get_extra_info("peername") or ("", id(transport)))[:2]


def max_newcomers() -> int:
    """Return how many newcomers may wait, so that most of the files this process may open stay free."""
    if sys.platform == "win32":
        return MAX_NEWCOMERS
    import resource

    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return MAX_NEWCOMERS if files == resource.RLIM_INFINITY else min(MAX_NEWCOMERS, files // FILES_EACH)


class WatchedProtocol(H11Protocol):
    """HTTP on one connection, which is a newcomer from its first moment on.

    Parameters
    ----------
    newcomers
        Where it is noted.
    """

    def __init__(self, newcomers: Newcomers, **given: Any) -> None:
        """Take what uvicorn gives its own protocol, and where to note the connection."""
        super().__init__(**given)
        self._newcomers = newcomers

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin as a newcomer."""
        self._newcomers.came(transport, self.loop.time())
        super().connection_made(transport)

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        self._newcomers.gone(self.transport)
        super().connection_lost(exc)


async def accept(listening: socket.socket, newcomers: Newcomers, protocol: Any) -> None:
    """Accept connections until cancelled, one after the other, so that none is accepted before those before it count.

    Not ``create_server``: without a free file descriptor it writes a traceback for each connection that waits.
    """
    loop = asyncio.get_running_loop()
    while True:
        try:
            connection, _ = await loop.sock_accept(listening)
        except ConnectionError:  # it has gone before it was accepted
            continue
        except OSError as error:
            newcomers.not_accepted(error.strerror or str(error))
            await asyncio.sleep(AGAIN_S)
            continue
        try:
            await loop.connect_accepted_socket(protocol, connection)
        except OSError:  # it has gone meanwhile
            connection.close()
