"""How long a stop takes from a request or a message: the real server, the simulated rig, in the middle of a heated run.

    python -m benchmarks.live_stop [--stops 40] [--quick] [--while-switching-on 200]

Each stop comes at a random moment of the sample period of a run that heats. Prints JSON, times in ms as {median, p95,
max}: from before the request or the message is sent until the same client has received that the drive is off, which is
longer than the time from its receipt to the safe drive. ``bars_met`` says whether every one took at most 20 ms; exit
code 1 if not.

With ``--while-switching-on`` it counts instead: so many stops, by WebSocket, HTTP, ``LiveClient`` and Ctrl-C on
``serve`` (one in forty, each with a server of its own), each at a random moment after an order to switch on. A stop is
lost if it is not answered, or if afterwards the state says anything but stopped or a sample comes. Exit code 1 then.
"""

from __future__ import annotations

import argparse
import json
import random
import signal
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from benchmarks.live_server import running_server
from websockets.sync.client import ClientConnection, connect

from musclewire.errors import CallerError, RigError
from musclewire.extras.live import LiveClient

BAR_MS, STOPS, QUICK_STOPS = 20.0, 40, 6
# From the order to switch on to the stop at most, and how long afterwards nothing may come of the order.
MAX_DELAY_S, AFTER_S = 0.6, 0.3
SIGNALS_OF = 40
BENCH, MAX_ANSWER_S = "simulated", 30.0
SAMPLE_S = 0.05


def heated(client: LiveClient) -> None:
    """Begin a run that heats, and wait for a few of its samples."""
    ends_s = time.monotonic() + 10.0
    while True:
        try:
            client.command("switch_on")
            break
        except CallerError:  # the run that was stopped is still ending
            if time.monotonic() > ends_s:
                raise
            time.sleep(SAMPLE_S)
    client.wait_for("ready")
    client.command("characterize", cycles=1, period_s=30.0)
    client.wait_for("busy")


def stop_over_http(client: LiveClient) -> float:
    """Return the time of one stop over HTTP [ms]."""
    began_s = time.perf_counter()
    assert client.stop() == "stopped"
    return 1e3 * (time.perf_counter() - began_s)


def stop_over_websocket(socket: ClientConnection) -> float:
    """Return the time of one stop over the WebSocket until the state says that the drive is off [ms]."""
    began_s = time.perf_counter()
    socket.send(json.dumps({"type": "command", "id": 1, "bench": "simulated", "command": {"do": "stop"}}))
    while True:
        message = json.loads(socket.recv(timeout=10.0))
        if message["type"] == "state" and message["state"]["phase"] == "stopped":
            return 1e3 * (time.perf_counter() - began_s)


def drain(socket: ClientConnection) -> None:
    """Read what waits, so that a stop's answer is not behind it."""
    try:
        while True:
            socket.recv(timeout=0.01)
    except TimeoutError:
        return


def stops(link: str, count: int, seed: int) -> dict[str, list[float]]:
    """Return the times of stops over both ways [ms]."""
    chance = random.Random(seed)
    found: dict[str, list[float]] = {"http_ms": [], "websocket_ms": []}
    url = link.replace("http", "ws") + "api/v1/live"
    with LiveClient(link) as client, client.control("the benchmark"), connect(url, proxy=None) as socket:
        for index in range(count):
            heated(client)
            time.sleep(0.2 + SAMPLE_S * chance.random())
            drain(socket)
            if index % 2:
                found["http_ms"].append(stop_over_http(client))
            else:
                found["websocket_ms"].append(stop_over_websocket(socket))
    return found


class Page:
    """A page with control, whose order to switch on is the one that stops come after."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket, self._id = socket, 0
        socket.send(json.dumps({"type": "ask_control", "bench": BENCH, "name": "the benchmark"}))

    def order(self, do: str) -> int:
        """Send a command and return its number."""
        self._id += 1
        self._socket.send(json.dumps({"type": "command", "id": self._id, "bench": BENCH, "command": {"do": do}}))
        return self._id

    def accepted(self, number: int) -> bool:
        """Read, and answer pings, until a command is answered; return whether it was accepted."""
        while True:
            message = json.loads(self._socket.recv(timeout=MAX_ANSWER_S))
            if message["type"] == "ping":
                self._socket.send(json.dumps({"type": "pong", "n": message["n"]}))
            elif message["type"] == "answer" and message["id"] == number:
                return bool(message["accepted"])

    def switch_on(self, *, is_read: bool) -> None:
        """Order to switch on; return at once, or when the rig's process has read the order."""
        self.order("switch_on")
        if is_read:
            self.accepted(self.order("end"))  # answered by the thread that reads, and ends nothing


def is_stopped_by(way: str, page: Page, client: LiveClient, http: httpx.Client) -> bool:
    """Stop by a way; return whether it is answered and no sample comes afterwards."""
    if way == "client":
        answered = client.stop() == "stopped"
    elif way == "http":
        answered = http.post(f"benches/{BENCH}/stop").status_code == httpx.codes.OK
    else:
        answered = page.accepted(page.order("stop"))
        with suppress(RigError):  # stopped, which is what is waited for
            client.wait_for("stopped", timeout_s=1.0)
    client.rows()
    time.sleep(AFTER_S)
    return answered and client.state()["phase"] == "stopped" and not client.rows()


def lost_while_switching_on(link: str, count: int, chance: random.Random) -> Counter[str]:
    """Stop so many times at a random moment after an order to switch on; return how many were lost, by the way."""
    lost = Counter(dict.fromkeys(("websocket", "http", "client"), 0))
    url = link.replace("http", "ws") + "api/v1/live"
    with (
        LiveClient(link) as client,
        httpx.Client(base_url=f"{link}api/v1/", trust_env=False) as http,
        connect(url, proxy=None) as socket,
    ):
        page = Page(socket)
        client.wait_for("off")
        for index in range(count):
            way = tuple(lost)[index % len(lost)]
            page.switch_on(is_read=way != "websocket")  # over one socket the order of both is certain
            time.sleep(MAX_DELAY_S * chance.random())
            lost[way] += not is_stopped_by(way, page, client, http)
    return lost


def is_off_by_signal(folder: Path, chance: random.Random) -> bool:
    """Press Ctrl-C on a server at a random moment after an order to switch on; return whether all of it has ended."""
    with running_server(folder, "--port", "8922") as server:
        url = server.link.replace("http", "ws") + "api/v1/live"
        with LiveClient(server.link) as client, connect(url, proxy=None) as socket:
            client.wait_for("off")
            Page(socket).switch_on(is_read=True)
            benches = Path(f"/proc/{server.process.pid}/task/{server.process.pid}/children").read_text().split()
            time.sleep(MAX_DELAY_S * chance.random())
            server.process.send_signal(signal.SIGINT)
            code = server.process.wait(MAX_ANSWER_S)
        ended = not any(Path(f"/proc/{pid}").exists() for pid in benches)
        return bool(benches) and ended and code == 128 + signal.SIGINT and "every drive is off" in server.said


def run_while_switching_on(folder: Path, count: int, seed: int) -> dict[str, Any]:
    """Return how many stops were tried and lost."""
    chance, signals = random.Random(seed), max(1, count // SIGNALS_OF)
    with running_server(folder, "--port", "8921") as server:
        lost = lost_while_switching_on(server.link, count - signals, chance)
    lost["signal"] = sum(not is_off_by_signal(folder, chance) for _ in range(signals))
    return {"stops": count, "signals": signals, "seed": seed, "lost": dict(lost), "bars_met": not lost.total()}


def spread(times_ms: list[float]) -> dict[str, float]:
    """Return median, 95th percentile and largest of times."""
    median, p95 = np.percentile(times_ms, (50, 95))
    return {"median": round(float(median), 2), "p95": round(float(p95), 2), "max": round(max(times_ms), 2)}


def run(folder: Path, count: int, seed: int) -> dict[str, Any]:
    """Return the spreads of stops of a server of its own."""
    with running_server(folder, "--port", "8921") as server:
        found = stops(server.link, count, seed)
    worst_ms = max(max(times_ms) for times_ms in found.values())
    spreads = {name: spread(times_ms) for name, times_ms in found.items()}
    return {"stops": count, "seed": seed, **spreads, "bar_ms": BAR_MS, "bars_met": worst_ms <= BAR_MS}


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stops", type=int, default=STOPS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--while-switching-on", type=int, metavar="COUNT")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if given.while_switching_on is not None:
            found = run_while_switching_on(Path(folder), given.while_switching_on, given.seed)
        else:
            found = run(Path(folder), QUICK_STOPS if given.quick else given.stops, given.seed)
    print(json.dumps(found, indent=2))
    return 0 if found["bars_met"] else 1


if __name__ == "__main__":
    sys.exit(main())
