"""One at a time has control of a bench, over real connections: by page, by program, handed over, and lost."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from websockets.sync.client import ClientConnection, connect

from musclewire.errors import RigError
from musclewire.extras.live import LiveClient

BENCH = "/api/v1/benches/simulated"
PATIENCE_S = 20.0


class Page:
    """A page: answers pings while it is read, and keeps what else it is sent."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket, self.answers_pings = socket, True

    def send(self, **message: Any) -> None:
        self.socket.send(json.dumps(message))

    def command(self, number: int, do: str, **fields: Any) -> None:
        self.send(type="command", id=number, bench="simulated", command={"do": do, **fields})

    def until(self, condition: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Read, as a page does, until a message fulfils a condition."""
        ends_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < ends_s:
            message = json.loads(self.socket.recv(timeout=PATIENCE_S))
            if message["type"] == "ping" and self.answers_pings:
                self.send(type="pong", n=message["n"])
            if condition(message):
                return message
        raise AssertionError("no such message came")

    def until_control(self, *, you_hold: bool, holder: str | None = None) -> dict[str, Any]:
        return self.until(
            lambda one: one["type"] == "control" and one["you_hold"] is you_hold and holder in (None, one["holder"])
        )


@contextmanager
def page(server: Any) -> Iterator[Page]:
    with connect(server.socket) as socket:
        yield Page(socket)


@pytest.mark.slow
def test_the_first_messages_say_who_you_are_and_all_there_is_to_know(server: Any) -> None:
    with page(server) as one:
        kinds = [json.loads(one.socket.recv())["type"] for _ in range(3)]
        assert kinds == ["hello", "control", "state"]


@pytest.mark.slow
def test_a_watcher_may_stop_and_nothing_else(server: Any) -> None:
    with page(server) as one:
        one.command(1, "switch_on")
        assert not one.until(lambda said: said.get("id") == 1)["accepted"]
        one.command(2, "stop")
        assert one.until(lambda said: said.get("id") == 2)["accepted"]
    assert [what for what, _ in server.bench.told] == ["start", "stop"]


@pytest.mark.slow
def test_who_has_control_sends_commands_and_keeps_it_by_answering_pings(server: Any) -> None:
    with page(server) as one:
        one.send(type="ask_control", bench="simulated", name="Ann")
        one.until_control(you_hold=True, holder="Ann")
        pings = iter(range(12))
        one.until(lambda said: said["type"] == "ping" and next(pings) == 11)  # three leases long
        one.command(1, "switch_on")
        assert one.until(lambda said: said.get("id") == 1)["accepted"]
    assert server.bench.signs_of_life >= 8


@pytest.mark.slow
def test_control_goes_over_when_the_holder_gives_it_and_the_run_is_not_ended(server: Any) -> None:
    with page(server) as ann, LiveClient(server.running.address.url) as program:
        ann.send(type="ask_control", bench="simulated", name="Ann")
        ann.until_control(you_hold=True)
        with pytest.raises(RigError, match="Ann has control"), program.control("Ben", timeout_s=0.0):
            pass
        with page(server) as ben:
            ben.send(type="ask_control", bench="simulated", name="Ben")
            ann.until(lambda said: said["type"] == "control" and said["asked_by"] == "Ben")
            ann.send(type="answer_control", bench="simulated", give=True)
            ann.until_control(you_hold=False, holder="Ben")
            ben.until_control(you_hold=True)
            assert "release" not in [what for what, _ in server.bench.told]
            ann.command(3, "switch_on")
            assert not ann.until(lambda said: said.get("id") == 3)["accepted"]


@pytest.mark.slow
@pytest.mark.parametrize("how", ["freezes", "closes", "gives up"])
def test_a_holder_who_is_gone_has_lost_control_and_the_bench_is_released(server: Any, how: str) -> None:
    with page(server) as watcher:
        with page(server) as holder:
            holder.send(type="ask_control", bench="simulated", name="Ann")
            watcher.until(lambda said: said["type"] == "control" and said["holder"] == "Ann")
            if how == "freezes":
                holder.answers_pings = False
                watcher.until(lambda said: said["type"] == "control" and said["holder"] is None)
            elif how == "gives up":
                holder.send(type="give_up_control", bench="simulated")
        if how != "freezes":
            watcher.until(lambda said: said["type"] == "control" and said["holder"] is None)
    assert [what for what, _ in server.bench.told].count("release") == 1


@pytest.mark.full
def test_pongs_to_pings_that_were_never_sent_keep_no_lease(server: Any) -> None:
    with page(server) as watcher, page(server) as holder:
        holder.answers_pings = False
        holder.send(type="ask_control", bench="simulated", name="Ann")
        watcher.until(lambda said: said["type"] == "control" and said["holder"] == "Ann")

        def is_lost(said: dict[str, Any]) -> bool:
            holder.send(type="pong", n=10**9)
            return said["type"] == "control" and said["holder"] is None

        watcher.until(is_lost)


@pytest.mark.slow
def test_a_program_keeps_control_inside_its_block_and_leaves_it_at_its_end(server: Any) -> None:
    with LiveClient(server.running.address.url) as program:
        with pytest.raises(RigError, match="take control first"):
            program.command("switch_on")
        with program.control("a test"):
            time.sleep(1.0)  # longer than a lease: the client's thread keeps it
            program.command("switch_on")
            assert program.asked_by() is None
        assert server.http.get(BENCH.replace("/simulated", "")).json()["benches"][0]["holder"] is None
        with pytest.raises(RigError, match="take control first"):
            program.command("switch_on")
        assert [what for what, _ in server.bench.told].count("command") == 1
        assert program.stop() == "stopped"


@pytest.mark.slow
def test_a_stolen_or_old_lease_is_worth_nothing(server: Any) -> None:
    lease = server.http.post(f"{BENCH}/control", json={"name": "x"}).json()["lease"]
    for offered in ("", "x", lease[:-1], lease + "x", "viewer 1"):
        answer = server.http.post(f"{BENCH}/commands", json={"do": "switch_on"}, headers={"Musclewire-Lease": offered})
        assert answer.status_code == 403
    server.http.delete(f"{BENCH}/control", headers={"Musclewire-Lease": lease})
    answer = server.http.post(f"{BENCH}/commands", json={"do": "switch_on"}, headers={"Musclewire-Lease": lease})
    assert answer.status_code == 403
    assert "command" not in [what for what, _ in server.bench.told]


@pytest.mark.slow
def test_a_rule_base_is_named_and_never_a_path(server: Any) -> None:
    with LiveClient(server.running.address.url) as program, program.control("a test"):
        for path in ("/etc/rules.toml", "rules.toml", 7, None):
            with pytest.raises(ValueError, match="no rule base of that name"):
                program.command("control", reference={"kind": "steer"}, settings={"rule_base": path})
    assert "command" not in [what for what, _ in server.bench.told]


@pytest.mark.slow
def test_a_viewer_that_reads_nothing_delays_nobody_and_is_closed_in_the_end(server: Any) -> None:
    """Rows come for it all the time; another viewer gets its own, and pings go on."""
    with page(server) as reading, connect(server.socket, max_queue=1, close_timeout=0.1):
        # A large state, sent often: what the deaf viewer does not take in fills its connection's buffers.
        for index in range(40):
            server.bench.change(why="x" * 1_000_000, health=str(index))
            reading.until(
                lambda said, index=index: said["type"] == "state" and said["state"].get("health") == str(index)
            )


@pytest.mark.slow
def test_rows_arrive_with_columns_once_and_what_follows_from_them(server: Any) -> None:
    with page(server) as one:
        one.until(lambda said: said["type"] == "ping")
        messages = []
        for index in range(3):
            time.sleep(0.1)
            server.bench.add_row(0.05 * index, float("nan"), 0.5, 3.0, 0.5)
            messages.append(one.until(lambda said: said["type"] == "rows"))
    assert [("columns" in message) for message in messages] == [True, False, False]
    row = dict(zip(messages[0]["columns"], messages[0]["rows"][0], strict=True))
    assert row["run_s"] is None
    assert (row["current_a"], row["power_w"], row["resistance_ohm"]) == (0.25, 0.75, 12.0)


@pytest.mark.slow
def test_a_number_of_the_state_that_is_not_known_is_null_and_ends_nothing(server: Any) -> None:
    with page(server) as one:
        server.bench.change(metrics={"mae_mean_pct": float("nan"), "steps": [float("inf"), 1.0]})
        state = one.until(lambda said: said["type"] == "state" and said["state"].get("metrics"))["state"]
        assert state["metrics"] == {"mae_mean_pct": None, "steps": [None, 1.0]}
    assert server.http.get(BENCH).json()["metrics"]["mae_mean_pct"] is None


@pytest.mark.slow
def test_a_key_that_is_there_twice_is_refused_by_both_doors(server: Any) -> None:
    twice = '{"do": "pulse", "drive_voltage_v": 0.3, "drive_voltage_v": 3.5}'
    lease = server.http.post(f"{BENCH}/control").json()["lease"]
    headers = {"Content-Type": "application/json", "Musclewire-Lease": lease}
    answer = server.http.post(f"{BENCH}/commands", content=twice, headers=headers)
    assert answer.status_code == 422
    said = [answer.json()["problem"]]
    with page(server) as one:
        one.socket.send('{"type": "command", "id": 1, "bench": "simulated", "command": ' + twice + "}")
        said.append(one.until(lambda message: message["type"] == "problem")["message"])
    assert all("'drive_voltage_v' is there twice" in text for text in said)
    assert ("pulse", None) not in server.bench.told
    assert [what for what, _ in server.bench.told] == ["start"]


@pytest.mark.slow
def test_a_name_is_plain_text_by_both_doors(server: Any) -> None:
    """What would colour a terminal or turn its text around is left out, and of nothing no name is made."""
    name, unseen = "\x1b[31mAnn\u202e\n", "\u202e\x1b"
    assert server.http.post(f"{BENCH}/control", json={"name": unseen}).status_code == 422
    with page(server) as one:
        one.send(type="ask_control", bench="simulated", name=unseen)
        assert "name" in one.until(lambda message: message["type"] == "problem")["message"]
        one.send(type="ask_control", bench="simulated", name=name)
        assert one.until_control(you_hold=True)["holder"] == "[31mAnn"
    assert server.http.post(f"{BENCH}/control", json={"name": name}).json()["holder"] == "[31mAnn"
