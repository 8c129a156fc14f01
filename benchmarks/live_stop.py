"""How long a stop takes from a request or a message: the real server, the simulated rig, in the middle of a heated run.

    python -m benchmarks.live_stop [--stops 40] [--quick] [--while-switching-on 200]
    python -m benchmarks.live_stop --among [--stops 50] [--kinds all idle talking half-sent websocket]

Each stop comes at a random moment of the sample period of a run that heats. Prints JSON, times in ms as {median, p95,
max}: from before the request or the message is sent until the same client has received that the drive is off, which is
longer than the time from its receipt to the safe drive. ``bars_met`` says whether every one took at most 20 ms; exit
code 1 if not.

With ``--while-switching-on`` it counts instead: so many stops, by WebSocket, HTTP, ``LiveClient`` and Ctrl-C on
``serve`` (one in forty, each with a server of its own), each at a random moment after an order to switch on. A stop is
lost if it is not answered, or if afterwards the state says anything but stopped or a sample comes. Exit code 1 then.

With ``--among`` connections of another process stand at the server, 300 at one that may open 256 files and 1,100 at one
that may open 1,024; a row for each kind of them and for all kinds by turns: idle ones that send nothing, talking ones
that ask for the state every second, ones that have sent half a request, and WebSockets; all show the token, and who is
thrown out comes again a second later. Each stop is a POST over a connection of its own; all the while a page controls
another bench, which it heats. ``bars_met``: every stop was answered within 2 s, the page has control and heats still.
``server_cpu``: how much of one core the server took meanwhile.
"""

from __future__ import annotations

import argparse
import asyncio
import itertools
import json
import multiprocessing
import os
import random
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import httpx
import numpy as np
from benchmarks.live_server import RunningServer, running_server
from websockets.sync.client import ClientConnection, connect

from musclewire.errors import CallerError, RigError
from musclewire.extras.live import LiveClient

BAR_MS, STOPS, QUICK_STOPS = 20.0, 40, 6
# From the order to switch on to the stop at most, and how long afterwards nothing may come of the order.
MAX_DELAY_S, AFTER_S = 0.6, 0.3
SIGNALS_OF = 40
BENCH, MAX_ANSWER_S = "simulated", 30.0
# Among others: the bar, how often one who talks asks, when one who was thrown out comes again, how long all have to
# come before the first stop, and how far apart stops are.
AMONG_BAR_S, TALK_S, AGAIN_S, GATHER_S, BETWEEN_S = 2.0, 1.0, 1.0, 5.0, 0.2
OTHER_BENCH = "finger"
# How many others, and how many files the server may open.
ROWS = ((300, 256), (1100, 1024))
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


def stops(server: RunningServer, count: int, seed: int) -> dict[str, list[float]]:
    """Return the times of stops over both ways [ms]."""
    chance = random.Random(seed)
    found: dict[str, list[float]] = {"http_ms": [], "websocket_ms": []}
    with (
        LiveClient(server.link) as client,
        client.control("the benchmark"),
        connect(server.socket_url, proxy=None, additional_headers=server.headers) as socket,
    ):
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


def lost_while_switching_on(server: RunningServer, count: int, chance: random.Random) -> Counter[str]:
    """Stop so many times at a random moment after an order to switch on; return how many were lost, by the way."""
    lost = Counter(dict.fromkeys(("websocket", "http", "client"), 0))
    with (
        LiveClient(server.link) as client,
        httpx.Client(base_url=f"{server.url}api/v1/", headers=server.headers, trust_env=False) as http,
        connect(server.socket_url, proxy=None, additional_headers=server.headers) as socket,
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
        socket_of = connect(server.socket_url, proxy=None, additional_headers=server.headers)
        with LiveClient(server.link) as client, socket_of as socket:
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
        lost = lost_while_switching_on(server, count - signals, chance)
    lost["signal"] = sum(not is_off_by_signal(folder, chance) for _ in range(signals))
    return {"stops": count, "signals": signals, "seed": seed, "lost": dict(lost), "bars_met": not lost.total()}


KINDS = ("idle", "talking", "half-sent", "websocket")


class Crowd:
    """Connections of others, of some kinds by turns, in a process of their own."""

    def __init__(self, server: RunningServer, kinds: Sequence[str]) -> None:
        """Take the server."""
        address = httpx.URL(server.url)
        self._host, self._port, self._kinds = address.host, address.port, kinds
        shown = "".join(f"{name}: {value}\r\n" for name, value in server.headers.items())
        head = f"HTTP/1.1\r\nHost: {address.host}\r\n{shown}"
        path = f"/api/v1/benches/{BENCH}"
        json_kind = "Content-Type: application/json\r\nContent-Length: 20\r\n"
        key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
        self._says = {
            "idle": "",
            "talking": f"GET {path} {head}\r\n",
            "half-sent": f"POST {path}/control {head}{json_kind}\r\n{{",
            "websocket": f"GET /api/v1/live {head}Connection: Upgrade\r\nUpgrade: websocket\r\n{key}\r\n",
        }

    async def stand(self, kind: str) -> None:
        """Be one of them, and come again after each end."""
        says = self._says[kind].encode()
        while True:
            with suppress(OSError, asyncio.IncompleteReadError):
                reader, writer = await asyncio.open_connection(self._host, self._port)
                try:
                    writer.write(says)
                    while kind == "talking":
                        await asyncio.sleep(TALK_S)
                        writer.write(says)
                        if not await reader.read(65536):
                            break
                    while await reader.read(65536):
                        pass
                finally:
                    writer.close()
            await asyncio.sleep(AGAIN_S)

    async def all(self, count: int) -> None:
        """Be so many."""
        await asyncio.gather(*(self.stand(self._kinds[number % len(self._kinds)]) for number in range(count)))


def crowd(of: Crowd, count: int) -> None:
    """Run so many connections until the process is ended."""
    import resource

    most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    asyncio.run(of.all(count))


def one_stop_s(server: RunningServer) -> float | None:
    """Return the time of one stop over a connection of its own [s]; None if it is not answered as stopped."""
    with httpx.Client(base_url=server.url, headers=server.headers, trust_env=False, verify=False) as http:
        began_s = time.perf_counter()
        with suppress(httpx.HTTPError):
            answer = http.post(f"/api/v1/benches/{BENCH}/stop", timeout=MAX_ANSWER_S)
            return time.perf_counter() - began_s if answer.status_code == httpx.codes.OK else None
    return None


class HeatingPage:
    """A page that has control of a bench and heats it, in a thread that answers pings until the block ends."""

    def __init__(self, socket: ClientConnection) -> None:
        """Take control and begin."""
        self._socket, self.holds, self._ended = socket, False, threading.Event()
        self._phase = ""
        self._say(type="ask_control", name="the page")
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _say(self, **message: Any) -> None:
        self._socket.send(json.dumps({"bench": OTHER_BENCH, **message}))

    def order(self, **command: Any) -> None:
        """Send a command."""
        self._say(type="command", id=1, command=command)

    def _read(self) -> None:
        while not self._ended.is_set():
            with suppress(TimeoutError):
                message = json.loads(self._socket.recv(timeout=0.5))
                if message["type"] == "ping":
                    self._socket.send(json.dumps({"type": "pong", "n": message["n"]}))
                elif message["type"] == "control" and message["bench"] == OTHER_BENCH:
                    self.holds = message["you_hold"]
                elif message["type"] == "state" and message["state"]["bench"] == OTHER_BENCH:
                    self._phase = message["state"]["phase"]

    def wait_for(self, phase: str) -> None:
        """Wait until the bench is in a phase."""
        ends_s = time.monotonic() + MAX_ANSWER_S
        while self._phase != phase:
            assert time.monotonic() < ends_s, f"{self._phase} instead of {phase}"
            time.sleep(0.05)

    def end(self) -> tuple[bool, str]:
        """Return whether it has control, and what the bench does."""
        self._ended.set()
        self._thread.join()
        return self.holds, self._phase


def cpu_s(pid: int) -> float:
    """Return how much time a process has taken of a core [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def run_among(
    folder: Path, count: int, files: int, stops_wanted: int, seed: int, kinds: Sequence[str] = KINDS
) -> dict[str, Any]:
    """Return how stops are answered among so many connections of others."""
    chance, others = random.Random(seed), multiprocessing.get_context("spawn")
    with running_server(folder, "--port", "8923", rigs=(BENCH, OTHER_BENCH), files=files) as server:
        with connect(server.socket_url, proxy=None, additional_headers=server.headers) as socket:
            page = HeatingPage(socket)
            page.wait_for("off")
            page.order(do="switch_on")
            page.wait_for("ready")
            page.order(do="characterize", cycles=100, period_s=30.0)
            page.wait_for("busy")
            crowded = others.Process(target=crowd, args=(Crowd(server, kinds), count))
            crowded.start()
            began_s, took_before_s = time.monotonic(), cpu_s(server.process.pid)
            try:
                time.sleep(GATHER_S)
                took_s = []
                for _ in range(stops_wanted):
                    took_s.append(one_stop_s(server))
                    time.sleep(2.0 * BETWEEN_S * chance.random())
            finally:
                crowded.terminate()
                crowded.join()
            share = (cpu_s(server.process.pid) - took_before_s) / (time.monotonic() - began_s)
            kept, phase = page.end()
        said = server.said
    in_time = [each for each in took_s if each is not None and each <= AMONG_BAR_S]
    answered = [1e3 * each for each in took_s if each is not None]
    return {
        "kinds": " ".join(kinds),
        "among": count,
        "files": files,
        "stops": stops_wanted,
        "seed": seed,
        "answered": len(answered),
        "in_time": len(in_time),
        "stop_ms": spread(answered) if answered else None,
        "control_kept": kept,
        "heats": phase == "busy",
        "server_cpu": round(share, 2),
        "traceback": "Traceback" in said,
        "log_bytes": len(said),
        "bars_met": len(in_time) == stops_wanted and kept and phase == "busy" and "Traceback" not in said,
    }


def run_all_among(folder: Path, stops_wanted: int, seed: int, kinds: Sequence[str]) -> dict[str, Any]:
    """Print a row for each kind of connections at both limits of files; return whether all bars are met."""
    met = []
    for number, ((count, files), kind) in enumerate(itertools.product(ROWS, kinds)):
        own = folder / str(number)
        own.mkdir()
        row = run_among(own, count, files, stops_wanted, seed, KINDS if kind == "all" else (kind,))
        print(json.dumps(row), flush=True)
        met.append(row["bars_met"])
    return {"rows": len(met), "rows_that_meet_bars": sum(met), "bars_met": all(met)}


def spread(times_ms: list[float]) -> dict[str, float]:
    """Return median, 95th percentile and largest of times."""
    median, p95 = np.percentile(times_ms, (50, 95))
    return {"median": round(float(median), 2), "p95": round(float(p95), 2), "max": round(max(times_ms), 2)}


def run(folder: Path, count: int, seed: int) -> dict[str, Any]:
    """Return the spreads of stops of a server of its own."""
    with running_server(folder, "--port", "8921") as server:
        found = stops(server, count, seed)
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
    parser.add_argument("--among", action="store_true")
    parser.add_argument("--kinds", nargs="+", choices=("all", *KINDS), default=("all", *KINDS))
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        if given.among:
            found = run_all_among(Path(folder), given.stops, given.seed, given.kinds)
        elif given.while_switching_on is not None:
            found = run_while_switching_on(Path(folder), given.while_switching_on, given.seed)
        else:
            found = run(Path(folder), QUICK_STOPS if given.quick else given.stops, given.seed)
    print(json.dumps(found, indent=2))
    return 0 if found["bars_met"] else 1


if __name__ == "__main__":
    sys.exit(main())
