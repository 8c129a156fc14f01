"""Runs the server of a session: where it listens, how it ends, and that every rig is safe before anything else ends."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import gc
import os
import signal
import socket
import sys
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import uvicorn

from musclewire.controllers import FuzzyPidSettings
from musclewire.errors import CallerError
from musclewire.extras.live._bench_handle import BenchHandle
from musclewire.extras.live._server.access import Access, is_loopback
from musclewire.extras.live._server.application import make_app
from musclewire.extras.live._server.connections import (
    Connections,
    FirstBytes,
    Turns,
    WatchedProtocol,
    accept,
    max_connections,
)
from musclewire.extras.live._server.fired_rules import FiredRules
from musclewire.extras.live._server.gate import Gate
from musclewire.extras.live._server.json_texts import MAX_BYTES
from musclewire.extras.live._server.session import Session, repeat

# If the usual port is taken, these next to it are tried.
PORTS_TRIED = 20
# What a connection may have sent that is not read yet: small, so that a flood is taken in small portions.
RECEIVE_BUFFER_BYTES = 4 * 1024
# Whoever does not fit into the system's queue tries again after a second at the earliest, a stop among them.
BACKLOG = 4096
CLOSE_S = 2.0  # [s] that open connections have to end with the server
LOOK_S = 0.5  # [s] from one look at the connections to the next


@dataclass(frozen=True)
class ListenAddress:
    """Where a server listens."""

    host: str = "127.0.0.1"  # name or address of the interface
    port: int = 8765  # 0 for any that is free

    @property
    def is_local(self) -> bool:
        """Whether it can be reached from this machine only."""
        return is_loopback(self.host)

    @property
    def url(self) -> str:
        """The address for a browser."""
        host = socket.gethostname() if self.host in ("0.0.0.0", "::") else self.host
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}/"


@dataclass(frozen=True)
class ServerSettings:
    """How a session is served."""

    folder: Path
    address: ListenAddress = field(default_factory=ListenAddress)
    token: str | None = None  # what everybody must show; None for nothing, on loopback only
    cpu: int | None = None  # core of the loop, which the server then leaves to it; None if it has none of its own

    def __post_init__(self) -> None:
        """Refuse to listen beyond this machine without a token."""
        if not self.address.is_local and self.token is None:
            raise CallerError(
                f"--host {self.address.host} can be reached from other machines: a token is needed, give --token-file"
            )


@dataclass(frozen=True)
class RunningServer:
    """A server that is ready: its address, and the link that opens its page."""

    address: ListenAddress
    link: str


class Server(uvicorn.Server):
    """The server of uvicorn, which leaves signals to us, as the rigs come first, and accepts by a rule of ours."""

    def __init__(self, config: uvicorn.Config, connections: Connections, turns: Turns) -> None:
        """Take them."""
        super().__init__(config)
        self._connections, self._turns = connections, turns
        self._tasks: list[asyncio.Task[None]] = []

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Accept connections by a rule of our own."""
        self.servers = []
        loop = asyncio.get_running_loop()
        self._tasks = [asyncio.create_task(accept(one, self._connections, self._protocol)) for one in sockets or []]
        self._tasks.append(asyncio.create_task(repeat(LOOK_S, lambda: self._connections.look(loop.time()))))
        self.started = True

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Accept no more, then end as uvicorn does."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await super().shutdown(sockets)

    def _protocol(self) -> FirstBytes:
        return FirstBytes(self._connections, self._turns, self._http)

    def _http(self) -> WatchedProtocol:
        return WatchedProtocol(
            self._connections, config=self.config, server_state=self.server_state, app_state=self.lifespan.state
        )

    @contextmanager
    def capture_signals(self) -> Generator[None, None, None]:
        """Take no signals."""
        yield


class ServerEnd:
    """Whether the server is to end, and by which signal."""

    def __init__(self) -> None:
        """Begin with neither."""
        self.now = asyncio.Event()
        self.by: signal.Signals | None = None


async def serve(
    handles: list[BenchHandle], settings: ServerSettings, on_ready: Callable[[RunningServer], None]
) -> signal.Signals | None:
    """Serve a session until it is to end; then every rig is safe and its process has ended.

    ``on_ready`` is called once the page can be opened; returned is the signal that ended the session, or None. Raises
    CallerError if nothing can listen there.
    """
    with noted_signals() as ended:
        await serve_until(ended, handles, settings, on_ready)
    return ended.by


async def serve_until(
    ended: ServerEnd, handles: list[BenchHandle], settings: ServerSettings, on_ready: Callable[[RunningServer], None]
) -> None:
    """Serve a session until it is to end, as ``serve`` does."""
    # Compiled, or loaded, before anybody has control: later it would take longer than a lease.
    FiredRules(FuzzyPidSettings(), 0.05).warm_up()
    with listening_socket(settings.address) as listening:
        address = ListenAddress(settings.address.host, listening.getsockname()[1])
        session = Session(handles, settings.folder, token_needed=settings.token is not None)
        try:
            await session.start()
            leave_core(settings.cpu)
            connections = Connections(max_connections(), session.is_kept)
            turns = Turns()
            server = Server(configuration(session, settings, address, connections, turns), connections, turns)
            # To walk through all that is loaded by now would hold up pings for as long as a good part of a lease.
            gc.freeze()
            await until_ended(server, session, listening, ended, lambda: on_ready(running(address, settings.token)))
        finally:
            await session.close()


def running(address: ListenAddress, token: str | None) -> RunningServer:
    """Return address and link of a server."""
    return RunningServer(address, address.url if token is None else f"{address.url}?token={token}")


def listening_socket(address: ListenAddress) -> socket.socket:
    """Return a socket that listens at a port or, if it is taken, at one of the next. CallerError if there is none."""
    ports = range(address.port, min(address.port + PORTS_TRIED, 65536))
    for port in ports:
        try:
            return bound(address.host, port)
        except UnicodeError as error:  # a name that is none of the Internet's
            raise CallerError(f"cannot listen at {address.host:.60}: it is no host's name ({error})") from None
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise CallerError(f"cannot listen at {address.host}, port {port}: {error.strerror or error}") from None
    raise CallerError(f"ports {ports[0]} to {ports[-1]} of {address.host} are in use: choose another with --port")


def bound(host: str, port: int) -> socket.socket:
    """Return a socket that listens at a host and port. Raises OSError."""
    family, kind, protocol, _, place = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
    listening = socket.socket(family, kind, protocol)
    try:
        if os.name == "posix":
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        listening.bind(place)
        listening.listen(BACKLOG)
        listening.setblocking(False)
    except OSError:
        listening.close()
        raise
    return listening


def configuration(
    session: Session, settings: ServerSettings, address: ListenAddress, connections: Connections, turns: Turns
) -> uvicorn.Config:
    """Return how uvicorn runs the application."""
    local = settings.address.is_local
    names = frozenset() if local else frozenset({address.host.lower(), *own_names()})
    access = Access(settings.token, names, any_address=not local)

    cookie = f"musclewire_{address.port}"  # browsers do not keep the cookies of two ports apart
    return uvicorn.Config(
        Gate(make_app(session), access, cookie, connections, turns, session.stops),
        loop="asyncio",
        ws="websockets-sansio",
        ws_max_size=MAX_BYTES,
        ws_per_message_deflate=False,
        lifespan="off",
        interface="asgi3",
        access_log=False,
        log_level="error",
        proxy_headers=False,
        server_header=False,
        timeout_keep_alive=10,
        timeout_graceful_shutdown=int(CLOSE_S),
    )


def own_names() -> set[str]:
    """Return the names of this machine in its network."""
    name = socket.gethostname().lower()
    return {name, f"{name}.local", socket.getfqdn().lower()}


def leave_core(cpu: int | None) -> None:
    """Leave a core to the loop, if there is another one."""
    if cpu is None or sys.platform != "linux":
        return
    others = os.sched_getaffinity(0) - {cpu}
    if others:
        os.sched_setaffinity(0, others)


@contextmanager
def noted_signals() -> Iterator[ServerEnd]:
    """Let Ctrl-C and SIGTERM end the server in order inside this block."""
    ended, loop = ServerEnd(), asyncio.get_running_loop()

    def on_signal(number: int, _frame: object) -> None:
        ended.by = ended.by or signal.Signals(number)
        loop.call_soon_threadsafe(ended.now.set)

    before = {number: signal.signal(number, on_signal) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield ended
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


async def until_ended(
    server: Server, session: Session, listening: socket.socket, ended: ServerEnd, on_ready: Callable[[], None]
) -> None:
    """Serve until it is to end or something fails; then the rigs are made safe first, and connections closed after."""
    tasks = [
        asyncio.create_task(one)
        for one in (server.serve([listening]), session.run(), ended.now.wait(), announced(on_ready, server))
    ]
    try:
        serving, watching, ending, _ = tasks
        await asyncio.wait([serving, watching, ending], return_when=asyncio.FIRST_COMPLETED)
        await session.close()
        for task in (serving, watching):
            if task.done():
                task.result()  # what ended by itself has failed: say so
        server.should_exit = True
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(serving, 2 * CLOSE_S)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def announced(on_ready: Callable[[], None], server: Server) -> None:
    """Say that the server is ready once it is."""
    while not server.started:
        await asyncio.sleep(0.01)
    on_ready()
