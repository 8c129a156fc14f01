"""A really started ``musclewire serve`` on the simulated rig, and what it says over its API: never by the page.

Its lease is longer than a user's, unless a test is about the lease itself.
"""

from __future__ import annotations

import json
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.live_server import RunningServer, running_server

__all__ = ["BENCH", "Served", "serving", "until"]

BENCH = "simulated"
# Only so that a fault does not hang a test: compiling may come before everything else.
MAX_START_S, MAX_WAIT_S = 180.0, 60.0
# Proxies of the environment are for other machines.
LONG_LEASE = Path(__file__).with_name("long_lease.py")
DIRECT = urllib.request.build_opener(urllib.request.ProxyHandler({}))


def until(condition: Callable[[], Any], what: str, *, max_wait_s: float = MAX_WAIT_S, pause_s: float = 0.02) -> Any:
    """Return what a condition returns as soon as it is true; AssertionError that names it after ``max_wait_s`` [s]."""
    ends_s = time.monotonic() + max_wait_s
    while not (found := condition()):
        assert time.monotonic() < ends_s, f"not within {max_wait_s:g} s: {what}"
        time.sleep(pause_s)
    return found


class Served:
    """A running server: its process, its address, its folder, and requests to its API.

    Parameters
    ----------
    process
        The process of ``musclewire serve``.
    link
        What it printed: the address with the token.
    url
        The address alone, with a slash at its end.
    folder
        The session's folder.
    """

    def __init__(self, server: RunningServer, folder: Path) -> None:
        """Take a running process."""
        self.process, self.link, self.url, self.folder = server.process, server.link, server.url, folder
        self._shown = server.headers

    def request(self, path: str, body: Any = None, method: str | None = None, **headers: str) -> Any:
        """Return the JSON answer to a request to the API."""
        data = None if body is None else json.dumps(body).encode()
        method = method or ("GET" if body is None else "POST")
        sent = self._shown | {name.replace("_", "-"): value for name, value in headers.items()}
        if body is not None:
            sent["Content-Type"] = "application/json"
        request = urllib.request.Request(f"{self.url}api/v1/{path}", data, sent, method=method)
        with DIRECT.open(request, timeout=30.0) as answer:
            return json.load(answer)

    @property
    def state(self) -> dict[str, Any]:
        """The state of the bench."""
        return dict(self.request(f"benches/{BENCH}"))

    @property
    def phase(self) -> str:
        """What the bench is doing."""
        return str(self.state["phase"])

    @property
    def holder(self) -> str | None:
        """The name of who has control."""
        holder: str | None = self.request("benches")["benches"][0]["holder"]
        return holder

    def said(self) -> str:
        """Return what the bench says of itself, for whoever reads why a test has failed."""
        state = self.state
        named = {name: state[name] for name in ("phase", "why", "doing", "messages")}
        return f"The bench: {json.dumps(named)}"

    def stop(self) -> str:
        """Stop the bench."""
        return str(self.request(f"benches/{BENCH}/stop", method="POST")["phase"])

    def until_phase(self, *phases: str, max_wait_s: float = MAX_WAIT_S) -> dict[str, Any]:
        """Return the state once the bench is in one of these phases."""
        until(lambda: self.phase in phases, f"phase {' or '.join(phases)}", max_wait_s=max_wait_s)
        return self.state

    def rows(self) -> Rows:
        """Return the rows from now on."""
        return Rows(self)

    def is_heating(self) -> bool:
        """Return whether the drive of the newest row is above the sense voltage; what is off drives nothing."""
        state = self.state
        if state["phase"] in ("off", "stopped", "failed"):
            return False
        newest = self.rows().wait()[-1]
        return bool(newest["drive_voltage_v"] > 1.01 * state["rig"]["sense_voltage_v"])

    def until_safe(self, began_s: float, max_wait_s: float) -> float:
        """Return how long [s] after ``began_s`` the bench was first seen without a run and without heat."""
        until(lambda: self.phase != "busy" and not self.is_heating(), "end of the run", max_wait_s=max_wait_s)
        return time.monotonic() - began_s


class Rows:
    """Rows of the bench, read over HTTP with a cursor."""

    def __init__(self, served: Served) -> None:
        """Begin now."""
        self._served = served
        self._cursor = self._answer(-1)["cursor"]

    def _answer(self, after: int) -> Any:
        return self._served.request(f"benches/{BENCH}/rows?after={after}")

    def new(self) -> list[dict[str, float | None]]:
        """Return the rows since the last time."""
        answer = self._answer(self._cursor)
        self._cursor = answer["cursor"]
        return [dict(zip(part["columns"], row, strict=True)) for part in answer["parts"] for row in part["rows"]]

    def wait(self) -> list[dict[str, Any]]:
        """Return the next rows, at least one."""
        return list(until(self.new, "a row"))


@contextmanager
def serving(folder: Path, *arguments: str, program: Sequence[str] = (str(LONG_LEASE),)) -> Iterator[Served]:
    """Start ``musclewire serve`` with a folder named ``session``, and end it."""
    with running_server(folder.parent, *arguments, rigs=(), program=program) as server:
        served = Served(server, folder)
        served.until_phase("off", max_wait_s=MAX_START_S)
        try:
            yield served
        except Exception as trouble:
            trouble.add_note(served.said())
            raise
