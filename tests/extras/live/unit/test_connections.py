"""Connections: how many there may be, who makes room, who is kept, and how little is said of it."""

from __future__ import annotations

import asyncio
import errno
import logging
import os
import socket
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import pytest
import uvicorn
from hypothesis import given
from hypothesis import strategies as st

from musclewire.extras.live._server.connections import (
    ACCEPTED_AT_ONCE,
    FIRST_REQUEST_S,
    REPORT_S,
    Connections,
    FirstBytes,
    ReservedFile,
    Turns,
    WatchedProtocol,
    accept,
)

MOST = 8


class Line:
    """A connection's transport, by what is needed of it."""

    def __init__(self, port: int) -> None:
        self.place, self.is_open = ("10.0.0.1", port), True

    def get_extra_info(self, _name: str) -> tuple[str, int, int, int]:
        return (*self.place, 0, 0)  # as of IPv6

    def is_closing(self) -> bool:
        return not self.is_open

    def abort(self) -> None:
        self.is_open = False


class Server:
    """Connections with pages and leases, and a clock."""

    def __init__(self, most: int = MOST) -> None:
        self.pages: set[Any] = set()
        self.leases: set[str] = set()
        self.asked, self.now_s, self.lines = 0, 0.0, list[Line]()
        self.connections = Connections(most, self.is_kept)

    def is_kept(self, place: Any, lease: str | None) -> bool:
        self.asked += 1
        return place in self.pages or lease in self.leases

    def came(self, count: int = 1) -> list[Line]:
        lines = [Line(len(self.lines) + number) for number in range(count)]
        for line in lines:
            self.now_s += 0.001
            self.connections.came(line, self.now_s)  # type: ignore[arg-type]
        self.lines += lines
        return lines

    def came_and_asked(self, count: int) -> list[Line]:
        lines = []
        for _ in range(count):
            lines += self.came()
            self.asks(lines[-1])
        return lines

    def asks(self, line: Line, *, stops: bool = False, lease: str | None = None) -> dict[str, Any]:
        self.now_s += 0.001
        headers = [] if lease is None else [(b"musclewire-lease", lease.encode())]
        scope = {"client": line.place, "headers": headers}
        self.connections.passed(scope, stops, self.now_s)
        return scope

    @property
    def open(self) -> list[int]:
        return [line.place[1] for line in self.lines if line.is_open]


def test_the_newest_is_always_let_in_and_who_has_been_idle_longest_makes_room() -> None:
    server = Server()
    lines = server.came(20)
    assert server.open == list(range(12, 20))
    server.asks(lines[12])
    server.came(1)
    assert server.open == [12, *range(14, 21)]


def test_who_has_shown_a_request_and_who_has_not_keep_half_of_the_places_from_each_other() -> None:
    server = Server()
    server.came_and_asked(MOST)
    silent = server.came(20)
    assert [line.is_open for line in server.lines[:MOST]] == [False] * 4 + [True] * 4
    assert sum(line.is_open for line in silent) == 4
    server.came_and_asked(20)
    assert sum(line.is_open for line in silent) == 3  # the one that comes counts as silent until it has asked


@pytest.mark.parametrize("kept", ["page", "lease", "stop"])
def test_an_open_page_a_lease_and_a_stop_that_is_being_answered_are_kept(kept: str) -> None:
    server = Server()
    (line,) = server.came()
    scope = server.asks(line, stops=kept == "stop", lease="secret")
    server.pages, server.leases = ({line.place}, set()) if kept == "page" else (set(), {"secret"})
    if kept == "stop":
        server.leases = set()
    server.came_and_asked(5 * MOST)
    server.came(5 * MOST)
    assert line.is_open
    server.pages, server.leases = set(), set()
    server.connections.answered(scope)
    server.came_and_asked(5 * MOST)
    assert not line.is_open


def test_a_lease_stays_with_its_connection_when_a_request_shows_none() -> None:
    server = Server()
    (line,) = server.came()
    server.leases = {"secret"}
    server.asks(line, lease="secret")
    server.asks(line)
    server.came_and_asked(5 * MOST)
    assert line.is_open


@given(st.lists(st.tuples(st.booleans(), st.integers(0, 30)), max_size=200))
def test_whatever_comes_there_are_no_more_than_may_be_and_who_is_kept_stays(
    steps: list[tuple[bool, int]],
) -> None:
    server = Server()
    (page,) = server.came()
    server.asks(page)
    server.pages = {page.place}
    for comes, number in steps:
        if comes:
            server.came()
        elif (line := server.lines[number % len(server.lines)]).is_open:
            server.asks(line)
        assert len(server.connections) == len(server.open) <= MOST
        assert page.is_open
        assert server.lines[-1].is_open


def test_if_all_are_kept_one_more_is_let_in() -> None:
    server = Server()
    for line in server.came(MOST):
        server.asks(line)
        server.pages.add(line.place)
    server.came()
    assert len(server.open) == MOST + 1


def test_who_is_gone_makes_room() -> None:
    server = Server()
    first, second, *_ = server.came(MOST)
    server.connections.gone(second)  # type: ignore[arg-type]
    server.came()
    assert first.is_open


def test_a_late_end_is_not_that_of_who_has_the_address_and_port_by_now() -> None:
    server = Server()
    (old,) = server.came()
    new = Line(old.place[1])
    server.connections.came(new, server.now_s)  # type: ignore[arg-type]
    server.connections.gone(old)  # type: ignore[arg-type]
    assert len(server.connections) == 1


def test_room_is_made_by_looking_at_one_however_many_there_are_and_at_each_who_is_kept_once() -> None:
    server = Server(most=1000)
    server.came_and_asked(990)
    server.pages = {line.place for line in server.lines[:30]}
    server.came(10)
    assert server.asked == 0
    server.came(100)
    assert server.asked == 100 + len(server.pages)


def test_who_sends_no_valid_request_in_time_is_closed() -> None:
    server = Server()
    silent, asks = server.came(2)
    server.asks(asks)
    server.connections.look(silent_s := FIRST_REQUEST_S)
    assert silent.is_open
    server.connections.look(silent_s + 0.1)
    assert (silent.is_open, asks.is_open, len(server.connections)) == (False, True, 1)


def test_without_a_file_descriptor_one_makes_room() -> None:
    server = Server()
    server.came(3)
    server.connections.make_room("Too many open files")
    assert server.open == [1, 2]


def test_a_descriptor_is_kept_for_one_connection_more() -> None:
    """The stop's, when this process may open nothing else."""
    resource = pytest.importorskip("resource")
    with socket.create_server(("127.0.0.1", 0)) as listening:
        reserved = ReservedFile()
        with socket.create_connection(listening.getsockname()):
            filler = os.dup(listening.fileno())  # nothing below it is free
            limits = resource.getrlimit(resource.RLIMIT_NOFILE)
            resource.setrlimit(resource.RLIMIT_NOFILE, (filler + 1, limits[1]))
            try:
                with pytest.raises(OSError, match=os.strerror(errno.EMFILE)):
                    listening.accept()
                connection = reserved.accepted(listening)
            finally:
                resource.setrlimit(resource.RLIMIT_NOFILE, limits)
                os.close(filler)
            assert connection is not None
            connection.close()
        reserved.keep()
        reserved.close()


class Handed(asyncio.Protocol):
    """Notes in which turn of the loop what has come is handed over."""

    def __init__(self, turn_of: Callable[[], int], turns: list[int]) -> None:
        self._turn_of, self._turns = turn_of, turns

    def data_received(self, _data: bytes) -> None:
        self._turns.append(self._turn_of())


def test_a_stop_that_waits_behind_many_is_read_in_as_many_turns_as_it_takes_to_accept_them() -> None:
    """Each turn serves everybody else once; a batch waited for until its last one is read would take four of them."""
    before, turn, read = 10 * ACCEPTED_AT_ONCE, 0, list[int]()

    async def run() -> None:
        nonlocal turn
        connections, turns = Connections(2 * before, lambda *_: False), Turns()
        with socket.create_server(("127.0.0.1", 0), backlog=2 * before) as listening, ExitStack() as stack:
            listening.setblocking(False)
            address = listening.getsockname()
            for _ in range(before):
                stack.enter_context(socket.create_connection(address))
            stop = stack.enter_context(socket.create_connection(address))
            stop.sendall(b"POST /api/v1/benches/simulated/stop HTTP/1.1\r\n\r\n")
            accepting = asyncio.create_task(
                accept(
                    listening,
                    connections,
                    lambda: FirstBytes(connections, turns, lambda: Handed(lambda: turn, read)),
                )
            )
            while not read and turn < 10 * before:
                turn += 1
                await asyncio.sleep(0)
            accepting.cancel()
            await asyncio.gather(accepting, return_exceptions=True)

    asyncio.run(run())
    assert read
    assert read[0] <= before // ACCEPTED_AT_ONCE + 8


class OpenTransport(asyncio.Transport):
    """A transport whose other end takes everything."""

    def __init__(self) -> None:
        super().__init__({"peername": ("127.0.0.1", 9), "sockname": ("127.0.0.1", 8765)})
        self.protocol: Any = None

    def set_protocol(self, protocol: Any) -> None:
        self.protocol = protocol

    def write(self, data: Any) -> None: ...

    def is_closing(self) -> bool:
        return False

    def close(self) -> None: ...


def test_the_end_of_a_websocket_is_noted() -> None:
    async def app(_scope: Any, _receive: Any, _send: Any) -> None: ...

    async def run() -> None:
        connections, transport = Connections(MOST, lambda *_: False), OpenTransport()
        config = uvicorn.Config(app, ws="websockets-sansio", lifespan="off", log_config=None)
        transport.protocol = http = WatchedProtocol(
            connections, config=config, server_state=uvicorn.server.ServerState(), app_state={}
        )
        connections.came(transport, 0.0)
        http.connection_made(transport)
        http.data_received(
            b"GET /live HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        assert transport.protocol is not http
        assert len(connections) == 1
        transport.protocol.connection_lost(None)
        assert len(connections) == 0

    asyncio.run(run())


def test_what_made_room_is_said_once_a_minute_and_counted(caplog: pytest.LogCaptureFixture) -> None:
    server = Server()
    with caplog.at_level(logging.WARNING, "musclewire.live"):
        for second in range(int(2 * REPORT_S)):
            server.now_s = float(second)
            server.came(10)
            server.connections.look(float(second))
    assert len(caplog.messages) == 2
    assert caplog.messages[0].startswith("closed 2 connections: ")
    assert sum(int(text.split()[1]) for text in caplog.messages) > 10 * REPORT_S - MOST - 10
