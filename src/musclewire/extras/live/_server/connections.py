"""Connections, few at a time: a new one is always accepted, and whoever has been idle longest makes room for it.

What a connection is kept for is an open page, a lease, and a stop that is being answered. All others end when too many
have come since their last valid request: it may be the newest that brings the stop. Whoever has shown a valid request
and whoever has not make room only while they take more than half, so that neither kind keeps the other out. Nothing is
counted by address: on loopback, and in a class behind one router, everybody has the same.
"""

from __future__ import annotations

import asyncio
import logging
import os
import re
import socket
import sys
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from starlette.types import Scope
from uvicorn.protocols.http.h11_impl import H11Protocol

LOGGER = logging.getLogger("musclewire.live")
# From the connection to the last header of its first valid request.
FIRST_REQUEST_S = 5.0
# How many there may be, with so many of the files that this process may open for each: who is thrown out comes again,
# which costs more than an open connection does; in memory all of them take some 40 MB at most.
MAX_CONNECTIONS, FILES_EACH = 512, 2
REPORT_S = 60.0
# So few at once that a stop has been read before as many have come as would make it the oldest.
ACCEPTED_AT_ONCE = 16
STOP = re.compile(rb"POST /\S*/stop ")
# When nothing could be accepted, it is tried again after so long.
AGAIN_S = 0.05
LEASE_HEADER = b"musclewire-lease"


@dataclass
class Connection:
    """A connection: when it last gave a sign [s], and what is known of it."""

    transport: asyncio.Transport
    sign_s: float
    is_new: bool = True
    lease: str | None = None
    stops: bool = False


class Connections:
    """The connections of a server. All times are of one clock, given by the caller.

    Parameters
    ----------
    most
        How many there may be.
    kept
        Returns the places of open pages and the leases of who has control or asks for it.
    """

    def __init__(self, most: int, kept: Callable[[], tuple[set[Any], set[str]]]) -> None:
        """Begin with none."""
        self._most, self._kept = most, kept
        self._all: dict[Any, Connection] = {}  # who gave a sign longest ago comes first
        self._refused, self._why, self._reported_s = 0, "", -REPORT_S

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._all)

    def came(self, transport: asyncio.Transport, now_s: float) -> None:
        """Note a new connection; of too many another one is closed."""
        place = place_of(transport)
        self._all.pop(place, None)  # an old one with the same address and port is over
        if len(self._all) >= self._most:
            self._forget_closed()
        if len(self._all) >= self._most:
            self.make_room("too many were open at once")
        self._all[place] = Connection(transport, now_s)

    def passed(self, scope: Scope, stops: bool, now_s: float) -> None:
        """Note that a request has passed the gate, and whether it is a stop."""
        place = tuple(scope["client"] or ())
        one = self._all.pop(place, None)
        if one is not None:
            self._all[place] = one
            lease = dict(scope["headers"]).get(LEASE_HEADER)
            one.sign_s, one.is_new, one.stops = now_s, False, stops
            one.lease = one.lease if lease is None else lease.decode("latin-1")

    def is_kept(self, scope: Scope) -> bool:
        """Return whether the connection of a request is kept: it has a lease that counts."""
        one = self._all.get(tuple(scope["client"] or ()))
        return one is not None and one.lease in self._kept()[1]

    def answered(self, scope: Scope) -> None:
        """Note that a request has been answered."""
        one = self._all.get(tuple(scope["client"] or ()))
        if one is not None:
            one.stops = False

    def gone(self, transport: asyncio.BaseTransport) -> None:
        """Note that a connection is closed."""
        self._all.pop(place_of(transport), None)

    def make_room(self, why: str) -> None:
        """Close the connection that has been idle longest and is not kept; nothing if all are kept."""
        pages, leases = self._kept()
        free = [place for place, one in self._all.items() if not (one.stops or place in pages or one.lease in leases)]
        new = [place for place in free if self._all[place].is_new]
        known = [place for place in free if not self._all[place].is_new]
        first, then = (new, known) if 2 * len(new) >= self._most else (known, new)
        self._refused, self._why = self._refused + 1, why
        for place in (*first, *then)[:1]:
            self._all.pop(place).transport.abort()

    def look(self, now_s: float) -> None:
        """Close those whose first request does not come; say, once a minute at most, how many made room."""
        self._forget_closed()
        for place, one in list(self._all.items()):
            if one.is_new and now_s - one.sign_s > FIRST_REQUEST_S:
                self._all.pop(place).transport.abort()
        if self._refused and now_s - self._reported_s >= REPORT_S:
            LOGGER.warning("closed %d connections: %s", self._refused, self._why)
            self._refused, self._reported_s = 0, now_s

    def _forget_closed(self) -> None:
        """Forget connections that another protocol than HTTP has closed."""
        self._all = {place: one for place, one in self._all.items() if not one.transport.is_closing()}


def place_of(transport: asyncio.BaseTransport) -> tuple[Any, ...]:
    """Return the address and the port at the other end, as a request's scope has them."""
    return tuple(transport.get_extra_info("peername") or ("", id(transport)))[:2]


def max_connections() -> int:
    """Return how many connections there may be, so that half of the files this process may open stay free."""
    if sys.platform == "win32":
        return MAX_CONNECTIONS
    import resource

    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return MAX_CONNECTIONS if files == resource.RLIM_INFINITY else min(MAX_CONNECTIONS, files // FILES_EACH)


class Turns:
    """Work that waits for its turn: one piece each time the loop has looked at everybody else; a stop has no turn."""

    def __init__(self) -> None:
        """Begin with nobody."""
        self._waiting: deque[Callable[[], None]] = deque()

    def after(self, work: Callable[[], None]) -> None:
        """Do a piece of work when it is its turn."""
        self._waiting.append(work)
        if len(self._waiting) == 1:
            asyncio.get_running_loop().call_soon(self._next)

    async def come(self) -> None:
        """Wait for one's turn."""
        come = asyncio.get_running_loop().create_future()
        self.after(lambda: None if come.done() else come.set_result(None))
        await come

    def _next(self) -> None:
        try:
            self._waiting[0]()
        finally:
            self._waiting.popleft()
            if self._waiting:
                asyncio.get_running_loop().call_soon(self._next)


class WatchedProtocol(H11Protocol):
    """HTTP on one connection, whose end is noted.

    Parameters
    ----------
    connections
        Where it is noted.
    """

    def __init__(self, connections: Connections, **given: Any) -> None:
        """Take what uvicorn gives its own protocol, and where to note the end."""
        super().__init__(**given)
        self._connections = connections

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        self._connections.gone(self.transport)
        super().connection_lost(exc)


class FirstBytes(asyncio.Protocol):
    """A connection before its first bytes: a stop is read as HTTP at once, everything else when it is its turn.

    Parameters
    ----------
    connections
        Where it is noted.
    turns
        Who else waits.
    http
        Returns the protocol that takes over.
    """

    def __init__(self, connections: Connections, turns: Turns, http: Callable[[], asyncio.Protocol]) -> None:
        """Take the parts."""
        self._connections, self._turns, self._http = connections, turns, http
        self._transport: asyncio.Transport

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin as a new one."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        self._connections.came(transport, asyncio.get_running_loop().time())

    def data_received(self, data: bytes) -> None:
        """Hand over what has come."""
        if STOP.match(data):
            self._hand_over(data)
        else:
            self._transport.pause_reading()
            self._turns.after(lambda: self._hand_over(data))

    def _hand_over(self, data: bytes) -> None:
        if self._transport.is_closing():
            return
        http = self._http()
        http.connection_made(self._transport)
        self._transport.set_protocol(http)
        self._transport.resume_reading()
        http.data_received(data)

    def connection_lost(self, _exc: Exception | None) -> None:
        """End before anything came."""
        self._connections.gone(self._transport)


class ReservedFile:
    """A file descriptor that is kept for one connection more, which may be the stop, when no other is left."""

    def __init__(self) -> None:
        """Keep one."""
        self._descriptor: int | None = os.open(os.devnull, os.O_RDONLY)

    def accepted(self, listening: socket.socket) -> socket.socket | None:
        """Accept a connection that waits by the descriptor that was kept; None if there is none."""
        self.close()
        try:
            connection, _ = listening.accept()
        except OSError:
            return None
        connection.setblocking(False)
        return connection

    def close(self) -> None:
        """Keep none."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def keep(self) -> None:
        """Keep one again, if one is free by now."""
        if self._descriptor is None:
            try:
                self._descriptor = os.open(os.devnull, os.O_RDONLY)
            except OSError:
                return


async def accept(listening: socket.socket, connections: Connections, protocol: Callable[[], FirstBytes]) -> None:
    """Accept connections until cancelled, few at a time, so that those before them have been read and count.

    Not ``create_server``: without a free file descriptor it writes a traceback for each connection that waits.
    """
    loop, reserved = asyncio.get_running_loop(), ReservedFile()
    try:
        while True:
            found: list[socket.socket | None] = []
            try:
                found.append((await loop.sock_accept(listening))[0])
                while len(found) < ACCEPTED_AT_ONCE:
                    found.append(listening.accept()[0])
            except (BlockingIOError, ConnectionError):  # no more wait, or one has gone before it was accepted
                pass
            except OSError as error:
                found.append(reserved.accepted(listening))
                connections.make_room(error.strerror or str(error))
                await asyncio.sleep(0.0 if found[-1] is not None else AGAIN_S)
            accepted = [one for one in found if one is not None]
            for one in accepted:
                one.setblocking(False)
            beginnings = (loop.connect_accepted_socket(protocol, one) for one in accepted)
            for one, end in zip(accepted, await asyncio.gather(*beginnings, return_exceptions=True), strict=True):
                if isinstance(end, OSError):  # it has gone meanwhile
                    one.close()
            reserved.keep()
    finally:
        reserved.close()
