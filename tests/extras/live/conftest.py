"""A server with a bench that stands in for a rig's process, run by a thread of the test."""

from __future__ import annotations

import asyncio
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import httpx
import pytest

sys.path.insert(0, str(Path(__file__).parent))  # for bench_stand_in

from bench_stand_in import BenchStandIn

from musclewire.extras.live._server.running import (
    ListenAddress,
    RunningServer,
    ServerEnd,
    ServerSettings,
    serve_until,
)

READY_S = 60.0


class Served(NamedTuple):
    """A running server: its link, its bench, and a client of HTTP that has shown no token."""

    running: RunningServer
    bench: BenchStandIn
    http: httpx.Client

    @property
    def socket(self) -> str:
        return self.running.address.url.replace("http", "ws") + "api/v1/live"


@contextmanager
def served(folder: Path, **settings: Any) -> Iterator[Served]:
    """Serve a bench that stands in for a rig's until the block ends."""
    bench, ready, loop = BenchStandIn(), threading.Event(), asyncio.new_event_loop()
    found: list[Any] = []

    def on_ready(running: RunningServer) -> None:
        found.append(running)
        ready.set()

    async def run() -> None:
        found.append(ServerEnd())
        await serve_until(found[0], [bench], ServerSettings(folder, ListenAddress(port=0), **settings), on_ready)

    thread = threading.Thread(target=lambda: loop.run_until_complete(run()))
    thread.start()
    try:
        assert ready.wait(READY_S)
        with httpx.Client(base_url=found[1].address.url, trust_env=False) as http:
            yield Served(found[1], bench, http)
    finally:
        loop.call_soon_threadsafe(found[0].now.set)
        thread.join(READY_S)
        loop.close()


@pytest.fixture
def serving(tmp_path: Path) -> Iterator[Callable[..., Served]]:
    """Return what starts a server with settings; it ends with the test."""
    with ExitStack() as stack:
        yield lambda **settings: stack.enter_context(served(tmp_path, **settings))


@pytest.fixture
def server(serving: Callable[..., Served]) -> Served:
    """A server on loopback."""
    return serving()
