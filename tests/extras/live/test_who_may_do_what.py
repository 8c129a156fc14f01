"""The server lets in whom it should, over real connections: hosts, origins, tokens, kinds of content, sizes, rates."""

from __future__ import annotations

import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import httpx
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

pytestmark = pytest.mark.slow

TOKEN = "a-token-of-the-tests-0123456789"
BENCH = "/api/v1/benches/simulated"


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "192.168.1.7"])
def test_a_request_by_another_name_is_refused_even_for_reading(server: Any, host: str) -> None:
    answer = server.http.get(BENCH, headers={"Host": host})
    assert answer.status_code == 421
    assert server.http.post(f"{BENCH}/stop", headers={"Host": host}).status_code == 421
    assert ("stop", "a program") not in server.bench.told


@pytest.mark.parametrize(
    "headers", [{"Origin": "http://evil.example"}, {"Origin": "null"}, {"Sec-Fetch-Site": "cross-site"}]
)
@pytest.mark.parametrize(
    ("method", "path"),
    [("POST", "/stop"), ("POST", "/commands"), ("POST", "/control"), ("PUT", "/control"), ("DELETE", "/control")],
)
def test_another_sites_page_changes_nothing(server: Any, headers: dict[str, str], method: str, path: str) -> None:
    body = {"do": "stop"} if path == "/commands" else {}
    assert server.http.request(method, BENCH + path, json=body, headers=headers).status_code == 403
    assert server.bench.told == [("start", None)]


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://localhost:1"])
def test_another_sites_page_gets_no_websocket(server: Any, origin: str) -> None:
    with pytest.raises(InvalidStatus) as caught, connect(server.socket, origin=origin):  # type: ignore[arg-type]
        pass
    assert caught.value.response.status_code == 403


def test_our_own_page_gets_one(server: Any) -> None:
    own = server.running.address.url.rstrip("/")
    with connect(server.socket, origin=own) as socket:
        assert '"hello"' in socket.recv()


@pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x"])
def test_what_a_form_can_send_is_no_command(server: Any, kind: str) -> None:
    answer = server.http.post(f"{BENCH}/commands", content=b'{"do":"stop"}', headers={"Content-Type": kind})
    assert answer.status_code == 415
    assert server.bench.told == [("start", None)]


def test_a_stop_needs_no_body_no_control_and_no_kind_of_content(server: Any) -> None:
    assert server.http.post(f"{BENCH}/stop").json() == {"phase": "stopped"}
    assert server.http.post(f"{BENCH}/stop", content=b"x", headers={"Content-Type": "text/plain"}).status_code == 200
    assert server.bench.told[1:] == [("stop", "a program")] * 2


def test_a_body_that_is_too_large_is_refused_whether_it_says_so_or_not(server: Any) -> None:
    large = b" " * (512 * 1024 + 1)
    kind = {"Content-Type": "application/json"}
    assert server.http.post(f"{BENCH}/commands", content=large, headers=kind).status_code == 413
    chunks = (large[start : start + 65536] for start in range(0, len(large), 65536))
    assert server.http.post(f"{BENCH}/commands", content=chunks, headers=kind).status_code == 413


@pytest.mark.parametrize(
    "body",
    [
        *(b'{"do":"control","reference":{"kind":"steer"},"settings":{"kp":NaN}}', b"[" * 100_000, b"{", b"\xff"),
        *(
            b'{"do":"target","value":Infinity}',
            b'{"do":"target","value":"1"}',
            b'{"do":"switch_on","rig":"x"}',
            b"null",
        ),
    ],
)
def test_what_is_no_command_is_one_line_and_reaches_no_bench(server: Any, body: bytes) -> None:
    lease = server.http.post(f"{BENCH}/control").json()["lease"]
    headers = {"Content-Type": "application/json", "Musclewire-Lease": lease}
    answer = server.http.post(f"{BENCH}/commands", content=body, headers=headers)
    assert answer.status_code in (400, 422)
    assert len(answer.json()["problem"].splitlines()) == 1
    assert server.bench.told == [("start", None)]


def test_a_body_that_does_not_come_is_not_waited_for(server: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("musclewire.extras.live._server.gate.BODY_S", 0.1)

    address = server.running.address
    with socket.create_connection((address.host, address.port), timeout=60.0) as connection:
        connection.sendall(
            f"POST {BENCH}/commands HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
            "Content-Length: 20\r\n\r\n{".encode()
        )
        assert b" 408 " in connection.recv(1000)


def test_every_answer_carries_the_headers_that_keep_a_browser_safe(server: Any) -> None:
    for path, host in (("/", None), (BENCH, None), ("/nothing", None), ("/", "evil.example")):
        headers = server.http.get(path, headers={} if host is None else {"Host": host}).headers
        assert "script-src 'self'" in headers["Content-Security-Policy"]
        assert "unsafe-inline" not in headers["Content-Security-Policy"]
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Cache-Control"] == "no-store"
        assert "access-control-allow-origin" not in headers
        assert "server" not in headers


@pytest.fixture
def guarded(serving: Callable[..., Any]) -> Any:
    """A server that needs a token, as it does beyond loopback."""
    return serving(token=TOKEN)


def test_without_the_token_nothing_is_shown_and_nothing_stops(guarded: Any) -> None:
    for method, path in (("GET", "/"), ("GET", BENCH), ("POST", f"{BENCH}/stop"), ("GET", "/api/v1/recordings")):
        assert guarded.http.request(method, path).status_code == 401
    wrong = {"Authorization": f"Bearer {TOKEN[:-1]}"}
    assert guarded.http.post(f"{BENCH}/stop", headers=wrong).status_code == 401
    assert guarded.http.get(f"/?token={TOKEN}x").status_code == 401
    assert guarded.http.get(f"/?token={TOKEN}&token={TOKEN}").status_code == 401
    assert guarded.http.get(f"{BENCH}?token={TOKEN}").status_code == 401
    with pytest.raises(InvalidStatus), connect(guarded.socket):
        pass
    assert guarded.bench.told == [("start", None)]


def test_the_printed_link_leaves_a_cookie_that_scripts_and_other_sites_cannot_use(guarded: Any) -> None:
    with httpx.Client(trust_env=False) as browser:
        answer = browser.get(guarded.running.link)
        assert answer.status_code == 200
        said = answer.headers["Set-Cookie"]
        assert "HttpOnly" in said
        assert "SameSite=Strict" in said
        assert TOKEN not in answer.text
        assert browser.get(guarded.running.address.url + BENCH[1:]).status_code == 200
        cookie = said.partition(";")[0]
    with connect(guarded.socket, additional_headers={"Cookie": cookie}) as socket:
        assert '"token_needed":true' in socket.recv()


def test_a_program_shows_its_token_in_a_header(guarded: Any) -> None:
    headers = {"Authorization": f"Bearer {TOKEN}"}
    assert guarded.http.get(BENCH, headers=headers).status_code == 200
    with connect(guarded.socket, additional_headers=headers) as socket:
        assert '"hello"' in socket.recv()


def read_all(socket: ClientConnection) -> None:
    while True:
        socket.recv(timeout=10)


def test_a_flood_of_messages_is_not_read_but_a_stop_in_it_is_and_its_sender_is_disconnected(
    server: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("musclewire.extras.live._server.application.MESSAGES_A_SECOND", 5)
    with connect(server.socket) as flooding, connect(server.socket) as other:
        for _ in range(20):
            flooding.send('{"type":"ask_control","bench":"simulated"}')
        flooding.send('{"type":"command","id":1,"bench":"simulated","command":{"do":"stop"}}')
        while '"answer"' not in (said := str(flooding.recv(timeout=10))):
            pass
        assert '"accepted":true' in said
        with suppress(ConnectionClosed):
            for _ in range(20_000):
                flooding.send("x" * 300)
        with pytest.raises(ConnectionClosed):
            read_all(flooding)
        assert '"hello"' in other.recv(timeout=10)
    assert [what for what, _ in server.bench.told].count("stop") == 1


@pytest.mark.parametrize(
    "name",
    [
        *("..", "../secret.h5", "..%2fsecret.h5", "%2e%2e%2fsecret.h5", "link.h5", "folder.h5", ".hidden.h5"),
        *("run.h5%00", "run.h5/", "/etc/passwd", "a..h5", "notes.txt", "c:run.h5", "run.H5"),
    ],
)
def test_only_recordings_of_the_sessions_folder_can_be_named(server: Any, tmp_path: Path, name: str) -> None:
    (tmp_path.parent / "secret.h5").write_bytes(b"secret")
    (tmp_path / "notes.txt").write_bytes(b"secret")
    (tmp_path / ".hidden.h5").write_bytes(b"secret")
    (tmp_path / "run.h5").write_bytes(b"a run")
    (tmp_path / "link.h5").symlink_to(tmp_path.parent / "secret.h5")
    (tmp_path / "folder.h5").mkdir()
    for tail in ("", "/rows"):
        answer = server.http.get(f"/api/v1/recordings/{name}{tail}")
        assert answer.status_code in (404, 405, 422)
        assert b"secret" not in answer.content.replace(b"secret.h5", b"")
    assert [one["name"] for one in server.http.get("/api/v1/recordings").json()["recordings"]] == ["run.h5"]
    assert server.http.get("/api/v1/recordings/run.h5").content == b"a run"
