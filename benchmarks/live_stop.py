"""How long a stop takes from a request or a message: the real server, the simulated rig, in the middle of a heated run.

    python -m benchmarks.live_stop [--stops 40] [--quick]

Each stop comes at a random moment of the sample period of a run that heats. Prints JSON, times in ms as {median, p95,
max}: from before the request or the message is sent until the same client has received that the drive is off, which is
longer than the time from its receipt to the safe drive. ``bars_met`` says whether every one took at most 20 ms; exit
code 1 if not.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.live_server import running_server
from websockets.sync.client import ClientConnection, connect

from musclewire.errors import CallerError
from musclewire.extras.live import LiveClient

BAR_MS, STOPS, QUICK_STOPS = 20.0, 40, 6
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
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = run(Path(folder), QUICK_STOPS if given.quick else given.stops, given.seed)
    print(json.dumps(found, indent=2))
    return 0 if found["bars_met"] else 1


if __name__ == "__main__":
    sys.exit(main())
