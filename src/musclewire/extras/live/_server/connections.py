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
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from starlette.types import Scope
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

LOGGER = logging.getLogger("musclewire.live")
# From the connection to the last header of its first valid request.
FIRST_REQUEST_S = 5.0
# Connections at most: a client that is disconnected comes again, which costs more than an open connection does; in
# memory all of them take some 40 MB at most.
MAX_CONNECTIONS = 512
FILES_EACH = 2  # files that this process may open, for each connection: half of them stay free
REPORT_S = 60.0
# Connections accepted at once: few enough that a stop is read before it would be the oldest of all.
ACCEPTED_AT_ONCE = 16
STOP = re.compile(rb"POST /\S*/stop ")
# [s] after which accepting is tried again when nothing could be accepted.
AGAIN_S = 0.05
LEASE_HEADER = b"musclewire-lease"


@dataclass
class Connection:
    """A connection: when it last gave a sign [s], and what is known of it."""

    transport: asyncio.Transport
    sign_s: float
    lease: str | None = None
    stops: bool = False


class Connections:
    """The connections of a server: noting one takes the same time however many there are.

    All times are of one clock, given by the caller. ``is_kept`` says whether somebody at a place, or with a lease, is
    kept: at an open page, with control or asking for it.
    """

    def __init__(self, most: int, is_kept: Callable[[Any, str | None], bool]) -> None:
        """Begin with none."""
        self._most, self._is_kept = most, is_kept
        # Who has not shown a valid request yet, and who has: in both who gave a sign longest ago comes first.
        self._new: OrderedDict[Any, Connection] = OrderedDict()
        self._known: OrderedDict[Any, Connection] = OrderedDict()
        self._refused, self._why, self._reported_s = 0, "", -REPORT_S

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._new) + len(self._known)

    def came(self, transport: asyncio.Transport, now_s: float) -> None:
        """Note a new connection; of too many another one is closed."""
        place = place_of(transport)
        self._pop(place)  # an old one with the same address and port is over
        if len(self) >= self._most:
            self.make_room("too many were open at once")
        self._new[place] = Connection(transport, now_s)

    def passed(self, scope: Scope, stops: bool, now_s: float) -> None:
        """Note that a request has passed the gate, and whether it is a stop."""
        place = tuple(scope["client"] or ())
        one = self._pop(place)
        if one is not None:
            self._known[place] = one
            lease = dict(scope["headers"]).get(LEASE_HEADER)
            one.sign_s, one.stops = now_s, stops
            one.lease = one.lease if lease is None else lease.decode("latin-1")

    def has_lease(self, scope: Scope) -> bool:
        """Return whether the connection of a request is kept for its lease."""
        one = self._known.get(tuple(scope["client"] or ()))
        return one is not None and one.lease is not None and self._is_kept(None, one.lease)

    def answered(self, scope: Scope) -> None:
        """Note that a request has been answered."""
        one = self._known.get(tuple(scope["client"] or ()))
        if one is not None:
            one.stops = False

    def gone(self, transport: asyncio.BaseTransport) -> None:
        """Note that a connection is closed."""
        place = place_of(transport)
        one = self._pop(place)
        if one is not None and one.transport is not transport:  # closed late: another one has its address and port
            self._new[place] = one

    def make_room(self, why: str) -> None:
        """Close the connection that has been idle longest and is not kept; nothing if all are kept."""
        self._refused, self._why = self._refused + 1, why
        first, then = (self._new, self._known) if 2 * len(self._new) >= self._most else (self._known, self._new)
        if not self._end_oldest(first):
            self._end_oldest(then)

    def look(self, now_s: float) -> None:
        """Close those whose first request does not come; say, once a minute at most, how many made room."""
        while self._new and now_s - next(iter(self._new.values())).sign_s > FIRST_REQUEST_S:
            self._end_oldest(self._new)
        if self._refused and now_s - self._reported_s >= REPORT_S:
            LOGGER.warning("closed %d connections: %s", self._refused, self._why)
            self._refused, self._reported_s = 0, now_s

    def _pop(self, place: Any) -> Connection | None:
        """Forget the connection at a place and return it; None if there is none."""
        return self._new.pop(place, None) or self._known.pop(place, None)

    def _end_oldest(self, some: OrderedDict[Any, Connection]) -> bool:
        """Close the first that is not kept, and return whether there is one; who is kept goes to the end."""
        for _ in range(len(some)):
            place, one = some.popitem(last=False)
            if one.stops or self._is_kept(place, one.lease):
                some[place] = one
            else:
                one.transport.abort()
                return True
        return False


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
    """HTTP on one connection, whose end is noted, also when it has become a WebSocket."""

    def __init__(self, connections: Connections, **given: Any) -> None:
        """Take what uvicorn gives its own protocol, and where to note the end."""
        super().__init__(**given)
        self._connections = connections
        self.ws_protocol_class = partial(WatchedSocket, connections)  # type: ignore[assignment]  # it is only called

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        self._connections.gone(self.transport)
        super().connection_lost(exc)


class WatchedSocket(WebSocketsSansIOProtocol):
    """A WebSocket, whose end is noted."""

    def __init__(self, connections: Connections, **given: Any) -> None:
        """Take what uvicorn gives its own protocol, and where to note the end."""
        super().__init__(**given)
        self._connections = connections

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        self._connections.gone(self.transport)
        super().connection_lost(exc)


class FirstBytes(asyncio.Protocol):
    """A connection before its first bytes: a stop is read as HTTP at once, everything else when it is its turn."""

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
    """Accept connections until cancelled, few in a turn of the loop, so that those before them are read and count.

    Not ``create_server``: without a free file descriptor it writes a traceback for each connection that waits.
    """
    loop, reserved = asyncio.get_running_loop(), ReservedFile()
    try:
        async with asyncio.TaskGroup() as beginnings:
            while True:
                accepted: list[socket.socket] = []
                try:
                    accepted.append((await loop.sock_accept(listening))[0])
                    while len(accepted) < ACCEPTED_AT_ONCE:
                        accepted.append(listening.accept()[0])
                except (BlockingIOError, ConnectionError):  # no more wait, or one has gone before it was accepted
                    pass
                except OSError as error:
                    connection = reserved.accepted(listening)
                    accepted += [] if connection is None else [connection]
                    connections.make_room(error.strerror or str(error))
                    await asyncio.sleep(0.0 if accepted else AGAIN_S)
                for one in accepted:
                    one.setblocking(False)
                    beginnings.create_task(begin(one, protocol))
                await asyncio.sleep(0.0)
                reserved.keep()
    finally:
        reserved.close()


async def begin(connection: socket.socket, protocol: Callable[[], FirstBytes]) -> None:
    """Begin to read an accepted connection, unless it has gone meanwhile."""
    try:
        await asyncio.get_running_loop().connect_accepted_socket(protocol, connection)
    except OSError:
        connection.close()
