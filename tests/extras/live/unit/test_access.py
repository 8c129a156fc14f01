"""Who may talk to the server: names, origins and tokens, by examples of attacks and by properties."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.extras.live._serve_command import AddressOptions, announce, identifiers
from musclewire.extras.live._server.access import Access, is_loopback, name_in_host, new_token, read_token
from musclewire.extras.live._server.connections import Connections, Turns
from musclewire.extras.live._server.gate import Gate
from musclewire.extras.live._server.running import ListenAddress, ServerSettings, running

TOKEN = "a-token-of-the-tests-0123456789"
LOCAL = Access()
ABROAD = Access("a-token-of-the-test-0123", frozenset({"bench.lab"}), any_address=True)


@pytest.mark.parametrize(
    "host", ["127.0.0.1:8765", "localhost:8765", "LOCALHOST", "[::1]:8765", "127.1.2.3", "localhost:9000"]
)
def test_loopback_is_always_a_name_of_the_server(host: str) -> None:
    assert LOCAL.host_is_ours(host)
    assert ABROAD.host_is_ours(host)


@pytest.mark.parametrize(
    "host",
    [
        *(None, "", "evil.example", "evil.example:8765", "127.0.0.1.evil.example", "localhost.evil.example"),
        *("192.168.1.7:8765", "user@localhost", "localhost:8765:1", "localhost:", "[::1", "::1", "localhost evil"),
        *("localhost\n", "10.0.0.1", "0x7f.1", "2130706433"),
    ],
)
def test_a_name_that_points_here_but_is_not_ours_is_refused(host: str | None) -> None:
    """DNS rebinding: the browser asks this machine under the attacker's own name."""
    assert not LOCAL.host_is_ours(host)


def test_beyond_loopback_the_servers_own_names_and_plain_addresses_count() -> None:
    assert ABROAD.host_is_ours("bench.lab:8765")
    assert ABROAD.host_is_ours("192.168.1.7:8765")
    assert not ABROAD.host_is_ours("evil.example")


@given(st.text(max_size=40))
def test_whatever_is_sent_as_host_it_is_ours_only_as_a_loopback_name(text: str) -> None:
    if LOCAL.host_is_ours(text):
        name = name_in_host(text)
        assert name is not None
        assert is_loopback(name)


@pytest.mark.parametrize(
    ("origin", "site", "permitted"),
    [
        ("http://localhost:8765", "same-origin", True),
        ("https://localhost:8765", None, True),
        (None, None, True),
        (None, "same-origin", True),
        (None, "none", True),
        (None, "cross-site", False),
        (None, "same-site", False),
        ("null", None, False),
        ("http://localhost:8766", "same-site", False),
        ("http://localhost", None, False),
        ("http://evil.example", "cross-site", False),
        ("http://localhost:8765.evil.example", None, False),
        ("http://localhost:8765/", None, False),
        ("file://", None, False),
        ("", None, False),
    ],
)
def test_only_our_own_page_and_programs_may_change_something(
    origin: str | None, site: str | None, permitted: bool
) -> None:
    assert LOCAL.origin_is_ours(origin, site, "localhost:8765") is permitted


async def never_called(*_arguments: object) -> None:
    raise AssertionError("it was passed on")


@pytest.mark.parametrize("origins", [("http://localhost:8765", "http://evil.example"), ("http://localhost:8765",) * 2])
def test_of_several_origins_none_passes_whichever_comes_first(origins: tuple[str, ...]) -> None:
    gate = Gate(never_called, LOCAL, "cookie", Connections(8, lambda: (set(), set())), Turns(), dict)
    for several, status in ((origins, 403), (origins[::-1], 403), (origins[:1], None)):
        headers = [(b"host", b"localhost:8765"), *((b"origin", one.encode()) for one in several)]
        refusal = gate.refusal({"type": "http", "method": "POST", "path": "/", "headers": headers})
        assert (refusal and refusal.status) == status


CHUNKED, LENGTH, NOTHING = (b"transfer-encoding", b"chunked"), (b"content-length", b"2"), (b"content-length", b"0")
JSON, FORM = (b"content-type", b"application/json; charset=utf-8"), (b"content-type", b"text/plain")


@pytest.mark.parametrize(
    ("headers", "passes"),
    [
        *(((CHUNKED,), False), ((CHUNKED, NOTHING), False), ((CHUNKED, FORM), False), ((LENGTH, FORM), False)),
        *(((CHUNKED, JSON), True), ((LENGTH, JSON), True), ((NOTHING,), True), ((), True)),
    ],
)
def test_what_is_not_json_passes_only_as_a_stop(headers: tuple[tuple[bytes, bytes], ...], passes: bool) -> None:
    gate = Gate(never_called, LOCAL, "cookie", Connections(8, lambda: (set(), set())), Turns(), dict)
    request = {"type": "http", "method": "POST", "headers": [(b"host", b"localhost:8765"), *headers]}
    refusal = gate.refusal({**request, "path": "/api/v1/benches/simulated/commands"})
    assert (refusal and refusal.status) == (None if passes else 415)
    assert gate.refusal({**request, "path": "/api/v1/benches/simulated/stop"}) is None


@given(st.text())
def test_no_other_token_than_ours_is_right(text: str) -> None:
    assert ABROAD.token_is_right(text) is (text == ABROAD.token)


def test_without_a_token_nobody_needs_one_and_with_one_everybody_does() -> None:
    assert LOCAL.token_is_right(None)
    assert not ABROAD.token_is_right(None)
    assert not ABROAD.token_is_right("")


def test_tokens_are_long_and_different() -> None:
    tokens = {new_token() for _ in range(100)}
    assert len(tokens) == 100
    assert min(len(token) for token in tokens) >= 43  # 256 bits in base 64


def test_by_default_a_server_listens_on_loopback_and_beyond_it_a_token_is_needed(tmp_path: Path) -> None:
    assert ServerSettings(tmp_path).address.is_local
    with pytest.raises(CallerError, match="a token is needed"):
        ServerSettings(tmp_path, ListenAddress("0.0.0.0"))


def test_a_token_file_is_for_its_owner_only_and_holds_one_long_token(tmp_path: Path) -> None:
    path = tmp_path / "token"
    path.write_text(TOKEN + "\n")
    path.chmod(0o600)
    assert read_token(path) == TOKEN
    path.chmod(stat.S_IRUSR | stat.S_IROTH)
    with pytest.raises(CallerError, match="chmod 600"):
        read_token(path)
    path.chmod(0o600)
    for text in ("short", "two tokens of some length", "x" * 600, ""):
        path.write_text(text)
        with pytest.raises(CallerError, match="needs one token"):
            read_token(path)
    with pytest.raises(CallerError, match="cannot be read"):
        read_token(tmp_path / "none")


def test_each_rig_has_a_name_of_its_own_that_fits_into_addresses() -> None:
    assert identifiers(["simulated", "benches/my bench.toml", "simulated", "ä.toml"]) == [
        "simulated",
        "my-bench",
        "simulated-2",
        "rig",
    ]


@pytest.mark.parametrize("named", [True, False])
def test_the_token_is_printed_once_and_not_at_all_if_its_file_was_named(
    named: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    address = ListenAddress("0.0.0.0", 8765)
    announce(running(address, TOKEN), AddressOptions(address.host, 8765, Path("my-token") if named else None))
    printed = capsys.readouterr()
    assert printed.out.startswith(address.url)
    assert printed.out.count(TOKEN) == (0 if named else 1)
    assert TOKEN not in printed.err
    assert ("the token of my-token" in printed.err) is named
