"""The command serve: the real program, its rig's process, its exit codes, and what it says."""

from __future__ import annotations

import signal
import socket
import stat
from pathlib import Path

import httpx
import pytest
from benchmarks import live_stop, malformed_messages
from benchmarks.live_server import running_server
from tests.command_line import CommandLine

from musclewire.errors import CallerError
from musclewire.extras.live import LiveClient
from musclewire.rigs import state_folder


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--cpu", "0", "simulated", "finger"], "--cpu keeps one loop on one core"),
        (["--host", "no.such.host.invalid"], "cannot listen at no.such.host.invalid"),
        (["--host", "x" * 70], "is no host's name"),
        (["simulatd"], "did you mean 'simulated'"),
        (["--token-file", "none.txt"], "--token-file none.txt cannot be read"),
        (["--output", "/proc/none"], "--output /proc/none cannot be made"),
    ],
)
def test_what_cannot_be_served_is_one_line(
    options: list[str], said: str, musclewire: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = musclewire("serve", *options)
    assert (answer.code, answer.out) == (2, "")
    assert said in answer.err
    assert len(answer.err.strip().splitlines()) == 1
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize(
    ("number", "code"),
    [
        pytest.param(signal.SIGINT, 130, marks=pytest.mark.full),
        pytest.param(signal.SIGTERM, 143, marks=pytest.mark.slow),
    ],
)
def test_a_signal_switches_off_and_ends_with_its_code_and_a_taken_port_is_said(
    number: int, code: int, tmp_path: Path
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        with running_server(tmp_path, "--port", port) as server:
            with LiveClient(server.link) as client, client.control("a test"):
                live_stop.heated(client)
                server.process.send_signal(number)
                assert server.process.wait(30) == code
            assert f"port {port} is in use: this is port" in server.said
            assert "every drive is off" in server.said
            assert "Traceback" not in server.said
    assert len(list((tmp_path / "session").glob("*.h5"))) == 1


@pytest.mark.slow
def test_beyond_loopback_the_link_has_a_token_and_nothing_is_shown_without_it(tmp_path: Path) -> None:
    with running_server(tmp_path, "--host", "0.0.0.0") as server:
        link = httpx.URL(server.link)
        there = link.copy_with(host="127.0.0.1")
        assert len(link.params["token"]) >= 43
        assert "not encrypted" in server.said
        with httpx.Client(trust_env=False) as http:
            assert http.get(there.copy_with(query=None)).status_code == 401
            assert http.get(there).status_code == 200
        with LiveClient(str(there)) as client:
            assert client.state()["bench"] == "simulated"


@pytest.mark.slow
def test_on_loopback_the_token_is_the_users_own_which_programs_find_and_others_cannot_read(tmp_path: Path) -> None:
    with running_server(tmp_path) as server:
        kept = state_folder() / "live_token"
        assert server.token == kept.read_text()
        with httpx.Client(trust_env=False) as http:
            assert http.post(f"{server.url}api/v1/benches/simulated/stop").status_code == 401
        with LiveClient(server.url) as client:
            assert client.state()["bench"] == "simulated"
        assert stat.S_IMODE(kept.stat().st_mode) == 0o600
        kept.chmod(0o640)
        with pytest.raises(CallerError, match="can be read by others"):
            LiveClient(server.url)


@pytest.mark.slow
def test_a_rig_is_switched_on_again_right_after_a_stop_and_stays_on(tmp_path: Path) -> None:
    """Half a second after a stop the server looks whether it was confirmed; by then the rig may be on again."""
    with running_server(tmp_path) as server, LiveClient(server.link) as client, client.control("a test"):
        for _ in range(4):
            live_stop.heated(client)
            assert client.stop() == "stopped"
        live_stop.heated(client)
        client.command("end")
        assert client.wait_for("ready")["phase"] == "ready"


@pytest.mark.slow
def test_two_rigs_are_served_next_to_each_other(tmp_path: Path) -> None:
    with running_server(tmp_path, rigs=("simulated", "finger")) as server:
        with LiveClient(server.link, bench="finger") as finger, finger.control("a test"):
            finger.command("switch_on")
            assert finger.wait_for("ready")["bench"] == "finger"
            with LiveClient(server.link, bench="simulated") as other:
                assert other.state()["phase"] == "off"
        with pytest.raises(ValueError, match="several benches"):
            LiveClient(server.link)


@pytest.mark.full
def test_stops_over_http_and_websocket_end_in_a_state_that_says_so(tmp_path: Path) -> None:
    # Each stop is awaited; the benchmark holds the bar of 20 ms.
    assert live_stop.run(tmp_path, 6, 1)["stops"] == 6


@pytest.mark.slow
def test_no_stop_is_lost_by_any_way_while_a_rig_is_switched_on(tmp_path: Path) -> None:
    assert live_stop.run_while_switching_on(tmp_path, 10, 1)["bars_met"]


@pytest.mark.full
def test_of_two_hundred_stops_while_a_rig_is_switched_on_none_is_lost(tmp_path: Path) -> None:
    found = live_stop.run_while_switching_on(tmp_path, 200, 1)
    assert (found["bars_met"], found["signals"]) == (True, 5), found


@pytest.mark.full
def test_ten_thousand_malformed_messages_change_nothing(tmp_path: Path) -> None:
    found = malformed_messages.run(tmp_path, 1, 10_000)
    assert found["passed"], found
    assert sum(found["http"].values()) > 4000
    assert found["websocket"]["problem"] > 1000
