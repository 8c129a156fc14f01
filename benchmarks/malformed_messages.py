"""Malformed requests and messages against the real server with the real simulated rig.

    python -m benchmarks.malformed_messages [--count 10000] [--seed 1] [--quick]

A program takes control, switches the rig on and keeps control. Then half of the messages go to the HTTP routes and
half to the WebSocket, from eight clients at once that have no control: valid commands without a lease or with a guessed
one; commands, messages and bodies with values of the wrong kind, out of range, nested, enormous, cut off, not UTF-8;
methods, paths, hosts, origins, kinds of content and headers that no page sends; bytes that are no HTTP; stops and
takings of control by pages of other sites. A viewer's own stop is left out: it may stop.

Nothing may change: the state's revision and phase, who has control, the drive of every row (the sense voltage). The
server must still answer, with no status of 5xx, no traceback and no process ended. Prints JSON; exit code 1 if
anything fails.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import random
import string
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
import numpy as np
from benchmarks.live_server import RunningServer, running_server
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from musclewire.extras.live import LiveClient

COUNT, QUICK_COUNT, CLIENTS = 10_000, 1_000, 8
BENCH = "/api/v1/benches/simulated"
COMMANDS: list[dict[str, Any]] = [
    {"do": "switch_on"},
    {"do": "doctor"},
    {"do": "pulse", "drive_voltage_v": 2.0, "duration_s": 1.0},
    {"do": "characterize", "amplitude_v": 3.0, "period_s": 90.0, "cycles": 2},
    {"do": "fit", "quantity": "strain"},
    {"do": "home"},
    {"do": "choose_pretension", "pretension_n": 1.7},
    {"do": "control", "reference": {"kind": "steer"}, "settings": {"rule_base": "/etc/passwd"}},
    {"do": "control", "reference": {"kind": "path", "time_s": [0.0, 1.0], "target": [0.01, 0.02]}},
    {"do": "target", "value": 0.02},
    {"do": "end"},
    {"do": "clock_speed", "factor": 10.0},
    {"do": "load_model", "name": "../../model.json"},
    {"do": "open_rig", "rig": "python:os:system"},
]
ODD: list[Any] = [
    *(None, True, False, 0, -1, 2**63, 10**400, 1e308, -0.0, "", "\0", "\ud800", "a" * 5000, [], {}, [[]]),
    {"do": "stop "},
    *("../../etc/passwd", "bench.toml", "NaN", "; rm -rf /", "<script>", [1e308] * 50, {"kind": "nidaq"}),
]  # fmt: skip
PATHS = [
    *("/", BENCH, f"{BENCH}/rows", f"{BENCH}/commands", f"{BENCH}/control", f"{BENCH}/nothing", "/api/v1/live"),
    *("/api/v1/benches", "/api/v1/recordings", "/api/v1/recordings/x.h5", "/api/v1/recordings/x.h5/rows"),
    *("/page/main.js", "/page/../../messages.py", "/page/%2e%2e/messages.py", "/api/v1/openapi.json"),
    *("/api/v1/recordings/..%2f..%2fetc%2fpasswd", "/api/v1/benches/bench.toml", "/api/v1/benches/%00/commands"),
]
FOREIGN = [
    {"Host": "evil.example"},
    {"Origin": "http://evil.example"},
    {"Origin": "null"},
    {"Sec-Fetch-Site": "cross-site"},
]
NOT_HTTP = [
    *(b"\0" * 100, b"GET / HTTP/9.9\r\n\r\n", b"POST /api\r\n\r\n", b"\x16\x03\x01\x02\x00", b"GET /" + b"a" * 70_000),
    *(b"GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
    b"POST /api/v1/benches/simulated/commands HTTP/1.1\r\nHost: localhost\r\nContent-Length: -5\r\n\r\n",
    b"POST /api/v1/benches/simulated/commands HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n"
    b"Transfer-Encoding: chunked\r\nContent-Type: application/json\r\n\r\nzz\r\n",
    b"GET /api/v1/live HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
]


class Makes:
    """Makes malformed requests and messages; the same seed, the same ones. None of them is a viewer's valid stop."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def value(self) -> Any:
        """Return a value that hardly any field takes."""
        chosen = self.random.choice(ODD)
        return chosen if self.random.random() < 0.7 else {self.word(): self.random.choice(ODD)}

    def word(self) -> str:
        """Return a word that means nothing."""
        return "".join(self.random.choices(string.printable, k=self.random.randint(0, 12)))

    def altered(self, record: dict[str, Any]) -> dict[str, Any]:
        """Return a record with a field added, taken away, renamed or given another value; some stay as they are."""
        changed, key = dict(record), self.random.choice(list(record))
        how = self.random.randrange(5)
        if how == 0:
            changed[key] = self.value()
        elif how == 1:
            del changed[key]
        elif how == 2:
            changed[self.word()] = self.value()
        elif how == 3:
            changed[self.word()] = changed.pop(key)
        return changed

    def damaged(self, text: bytes) -> bytes:
        """Return bytes cut off, doubled, or with some of them changed."""
        how = self.random.randrange(4)
        if how == 0:
            return text[: self.random.randrange(len(text) + 1)]
        if how == 1:
            return text * self.random.randint(2, 50)
        found = bytearray(text)
        for _ in range(self.random.randint(1, 8)):
            found[self.random.randrange(len(found))] = self.random.randrange(256)
        return bytes(found)

    def json(self, record: dict[str, Any]) -> bytes:
        """Return a record as JSON, altered or damaged; now and then as it is."""
        if self.random.random() < 0.03:
            return b"[" * 20_000 + b"]" * 20_000
        if self.random.random() < 0.02:
            return b'{"do":' + b"9" * self.random.choice([5_000, 600_000]) + b"}"
        text = json.dumps(self.altered(record) if self.random.random() < 0.7 else record).encode("utf-8", "replace")
        return self.damaged(text) if self.random.random() < 0.3 else text

    def message(self) -> bytes:
        """Return a message for the WebSocket."""
        command = self.altered(self.random.choice(COMMANDS))
        record = self.random.choice(
            [
                {"type": "command", "id": 1, "bench": "simulated", "command": command},
                {"type": "answer_control", "bench": "simulated", "give": True},
                {"type": "give_up_control", "bench": "simulated"},
                {"type": "pong", "n": self.random.randrange(2**40)},
                {"type": "hello", "you": "the holder"},
            ]
        )
        return self.json(record)

    def request(self) -> tuple[str, str, dict[str, str], bytes]:
        """Return method, path, headers and body of a request."""
        rolled = self.random.random()
        if rolled < 0.1:
            foreign = self.random.choice(FOREIGN)
            return "POST", self.random.choice([f"{BENCH}/stop", f"{BENCH}/control"]), dict(foreign), b""
        method = self.random.choice(["GET", "POST", "PUT", "DELETE", "HEAD", "OPTIONS", "PATCH", "TRACE", "BREW"])
        path = self.random.choice(PATHS)
        if rolled < 0.6:
            method, path = "POST", f"{BENCH}/commands"
        if self.random.random() < 0.2:
            path += "?after=" + self.random.choice(["-1", "x", "9" * 30, "1e9", "%00", "NaN"])
        body = self.json(self.random.choice(COMMANDS))
        return method, path, self.headers(), b"" if method in ("GET", "HEAD") else body

    def headers(self) -> dict[str, str]:
        """Return headers, most of them as a program sends them."""
        headers = {"Content-Type": "application/json"}
        if self.random.random() < 0.2:
            headers["Content-Type"] = self.random.choice(
                ["text/plain", "application/x-www-form-urlencoded", "", "json"]
            )
        if self.random.random() < 0.3:
            headers["Musclewire-Lease"] = self.random.choice(["", "x", "viewer 1", "a" * 4000, "{}", "true"])
        if self.random.random() < 0.1:
            headers |= self.random.choice(FOREIGN)
        if self.random.random() < 0.1:
            headers["Cookie"] = self.random.choice(["musclewire_8765=", "a=b; a", '"', "x" * 3000])
        return headers


def changes_only_the_asker(message: bytes) -> bool:
    """Return whether damage has by chance made a valid stop of a message; a viewer may stop, so it is left out."""
    return b'"stop"' in message


async def attack_over_http(server: RunningServer, makes: Makes, count: int, client: int) -> Counter[str]:
    """Send requests from an address of this client's own, and count the answers by status."""
    seen: Counter[str] = Counter()
    parts = urlsplit(server.url)
    transport = httpx.AsyncHTTPTransport(local_address=f"127.0.1.{client + 1}")
    async with httpx.AsyncClient(
        base_url=server.url, headers=server.headers, transport=transport, timeout=30.0
    ) as http:
        for _ in range(count):
            if makes.random.random() < 0.05:
                seen[await sent_raw(str(parts.hostname), int(parts.port or 80), makes.random.choice(NOT_HTTP))] += 1
                continue
            method, path, headers, body = makes.request()
            if changes_only_the_asker(body):
                continue
            try:
                seen[str((await http.request(method, path, headers=headers, content=body)).status_code)] += 1
            except (httpx.TransportError, httpx.InvalidURL, UnicodeEncodeError) as error:
                seen[f"connection: {type(error).__name__}"] += 1
            await asyncio.sleep(1.0 / 200.0)
    return seen


async def sent_raw(host: str, port: int, data: bytes) -> str:
    """Send bytes that are no request of HTTP, and return the status that answers them, or how the connection ended."""
    reader, writer = await asyncio.open_connection(host, port)
    try:
        writer.write(data)
        await writer.drain()
        answer = await asyncio.wait_for(reader.read(100), 0.2)
        return answer[9:12].decode("ascii", "replace") or "no HTTP: closed"
    except TimeoutError:
        return "no HTTP: waits for more"
    except ConnectionError:
        return "no HTTP: closed"
    finally:
        writer.close()


async def attack_over_websocket(server: RunningServer, makes: Makes, count: int, _client: int) -> Counter[str]:
    """Send messages over WebSockets, one after the other as the server closes them; count what it answers."""
    seen: Counter[str] = Counter()
    left = count
    while left > 0:
        try:
            async with connect(
                server.socket_url, open_timeout=30.0, proxy=None, additional_headers=server.headers
            ) as socket:
                reading = asyncio.create_task(count_answers(socket, seen))
                while left > 0:
                    left -= 1
                    message = makes.message()
                    if not changes_only_the_asker(message):
                        binary = makes.random.random() < 0.05
                        await socket.send(message if binary else message.decode("utf-8", "replace"))
                    await asyncio.sleep(1.0 / 180.0)
                await asyncio.sleep(0.5)
                reading.cancel()
        except (WebSocketException, OSError) as error:
            seen[f"connection: {type(error).__name__}"] += 1
    return seen


async def count_answers(socket: ClientConnection, seen: Counter[str]) -> None:
    """Count what the server sends, by its type."""
    with suppress(ConnectionClosed):
        async for text in socket:
            message = json.loads(text)
            kind = str(message["type"])
            seen["accepted" if kind == "answer" and message["accepted"] else kind] += 1


async def attack(server: RunningServer, seed: int, count: int) -> dict[str, Counter[str]]:
    """Send all messages from all clients at once."""
    kinds: dict[str, Callable[..., Any]] = {"http": attack_over_http, "websocket": attack_over_websocket}
    each = count // (len(kinds) * CLIENTS)
    found = {}
    for kind, sends in kinds.items():
        jobs = (sends(server, Makes(seed + client), each, client) for client in range(CLIENTS))
        found[kind] = sum(await asyncio.gather(*jobs), Counter())
    return found


def judged(client: LiveClient, before: dict[str, Any], drives_v: list[float]) -> dict[str, Any]:
    """Return what has changed, which is nothing."""
    after = client.state()
    parts = ("revision", "phase", "doing", "steps", "model", "recordings", "clock_speed", "protection")
    return {
        "changed": {name: [before[name], after[name]] for name in parts if before[name] != after[name]},
        "rows": len(drives_v),
        "drive_voltage_v": [min(drives_v), max(drives_v)],
        "sense_voltage_v": after["rig"]["sense_voltage_v"],
    }


def run(folder: Path, seed: int, count: int) -> dict[str, Any]:
    """Attack a server of its own; return what came of it."""
    with running_server(folder, "--port", "8901") as server, LiveClient(server.link) as client:
        with client.control("the holder"):
            client.command("switch_on")
            client.wait_for("ready")
            time.sleep(1.0)
            client.rows()
            before, drives_v = client.state(), []
            answers = asyncio.run(attack(server, seed, count))
            for name, values in client.rows().items():
                drives_v += list(values) if name == "drive_voltage_v" else []
            found = judged(client, before, drives_v)
            client.command("clock_speed", factor=1.0)  # control is still the holder's, and the bench answers
        alive, said = server.process.poll() is None, server.said
    statuses = answers["http"]
    found |= {
        "messages": count,
        "seed": seed,
        "http": dict(sorted(statuses.items())),
        "websocket": dict(sorted(answers["websocket"].items())),
        "server_errors": sum(number for status, number in statuses.items() if status.startswith("5")),
        "tracebacks": said.count("Traceback"),
        "alive": alive,
        "exit_code": server.process.returncode,
    }
    found["passed"] = passes(found)
    return found


def passes(found: dict[str, Any]) -> bool:
    """Return whether nothing changed and nothing failed."""
    sense_v = found["sense_voltage_v"]
    steady = bool(np.allclose(found["drive_voltage_v"], sense_v, rtol=0.01))
    quiet = not (
        found["changed"] or found["server_errors"] or found["tracebacks"] or found["websocket"].get("accepted")
    )
    return steady and quiet and found["alive"] and found["exit_code"] == 143


def main() -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = run(Path(folder), given.seed, QUICK_COUNT if given.quick else given.count)
    print(json.dumps(found, indent=2))
    return 0 if found["passed"] else 1


if __name__ == "__main__":
    sys.exit(main())
