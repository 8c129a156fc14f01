"""Thousands of connections that send nothing, and the real server: a stop with the token is answered, the log short."""

from __future__ import annotations

import socket
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import httpx
import pytest
from benchmarks.live_server import RunningServer, running_server
from benchmarks.live_stop import run_among

from musclewire.extras.live import LiveClient

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="limits another process's open files, uses all of 127.0.0.0/8"
)

TOKEN = "a-token-of-the-tests-0123456789"
MAX_STOP_S, MAX_LOG_BYTES = 1.0, 100_000
BETWEEN_STOPS = 100


@contextmanager
def server_with_few_files(folder: Path, files: int, *, is_tried: bool = True) -> Iterator[RunningServer]:
    """Run a server that needs a token and may open so many files, its bench off, and a stop tried."""
    import resource

    token = folder / "token"
    token.write_text(TOKEN)
    token.chmod(0o600)
    with running_server(folder, "--port", "8931", "--token-file", str(token)) as server:
        resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (files, files))
        with LiveClient(server.link, token=TOKEN) as client:
            client.wait_for("off")
            assert not is_tried or client.stop() == "stopped"
        yield server


def idle(address: tuple[str, int], source: str) -> socket.socket:
    """Open a connection that sends nothing; it does not wait for the server."""
    one = socket.socket()
    one.setblocking(False)
    one.bind((source, 0))
    one.connect_ex(address)
    return one


def stop_s(url: str) -> float:
    """Stop with the token over a connection of its own; return how long the answer took [s]."""
    began_s = time.perf_counter()
    with socket.create_connection((httpx.URL(url).host, httpx.URL(url).port or 80), timeout=30.0) as line:
        line.sendall(b"POST /api/v1/benches/simulated/stop HTTP/1.1\r\nHost: localhost\r\n")
        line.sendall(f"Authorization: Bearer {TOKEN}\r\n\r\n".encode())
        assert line.recv(4096).startswith(b"HTTP/1.1 200")
    return time.perf_counter() - began_s


@pytest.mark.parametrize(
    ("files", "count", "addresses"),
    [
        pytest.param(1024, 2000, 200, marks=pytest.mark.slow),
        pytest.param(256, 300, 1, marks=pytest.mark.slow),
        pytest.param(1024, 2000, 1, marks=pytest.mark.full),
        pytest.param(256, 300, 200, marks=pytest.mark.full),
    ],
)
def test_no_number_of_idle_connections_keeps_a_stop_with_the_token_out(
    files: int, count: int, addresses: int, tmp_path: Path
) -> None:
    """Few files are permitted only after the start: the limit on connections is that of a server that may open many."""
    with server_with_few_files(tmp_path, files) as server, ExitStack() as stack:
        parts = urlsplit(server.link)
        assert parts.hostname is not None
        assert parts.port is not None
        took_s = []
        for number in range(count):
            source = f"127.0.{1 + number % addresses}.1"
            stack.enter_context(idle((parts.hostname, parts.port), source))
            if number % BETWEEN_STOPS == BETWEEN_STOPS - 1:
                took_s.append(stop_s(server.link))
        assert max(took_s) <= MAX_STOP_S
        assert "Traceback" not in server.said
        assert len(server.said) <= MAX_LOG_BYTES


@pytest.mark.slow
def test_a_first_stop_imports_nothing_neither_in_the_server_nor_at_the_bench(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An import needs a descriptor, memory and time: none may be left by then."""
    monkeypatch.setenv("PYTHONPROFILEIMPORTTIME", "1")
    with (
        server_with_few_files(tmp_path, 1024, is_tried=False) as server,
        LiveClient(server.link, token=TOKEN) as client,
    ):
        with client.control("a test"):
            client.command("switch_on")
            client.wait_for("ready")
            client.command("characterize", cycles=1, period_s=30.0)
            client.wait_for("busy")
            said = server.said
            assert "import time" in said
            stop_s(server.link)
        assert server.said.removeprefix(said) == ""


@pytest.mark.parametrize(
    ("files", "count"),
    [pytest.param(256, 300, marks=pytest.mark.slow), pytest.param(1024, 1100, marks=pytest.mark.full)],
)
def test_a_stop_is_answered_among_others_that_are_silent_talk_or_stand_half_sent(
    files: int, count: int, tmp_path: Path
) -> None:
    """All others have the token; how long an answer takes is the benchmark's to judge."""
    found = run_among(tmp_path, count, files, stops_wanted=10, seed=1)
    assert (found["answered"], found["traceback"]) == (10, False)
    assert found["log_bytes"] <= MAX_LOG_BYTES
