"""The server's session by a clock of the test's own: leases while a run heats, old pongs, when a stop is answered."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx
import pytest
from tests.extras.live.bench_stand_in import BenchStandIn

from musclewire.controllers import protection_table
from musclewire.errors import RigError
from musclewire.extras.live import Session, _silence
from musclewire.extras.live._bench.orders import NumberedOrder
from musclewire.extras.live._client import POLL_S
from musclewire.extras.live._server import application, bench_routes
from musclewire.extras.live._server import session as server_session
from musclewire.extras.live._server.access import LEASE_AT_REST_S
from musclewire.extras.live._server.connections import Connections, Turns
from musclewire.extras.live._server.running import ListenAddress, ServerSettings, configuration
from musclewire.extras.live._silence import LEASE_S

BENCH = "http://localhost/api/v1/benches/simulated"
TURNS = 50
TOKEN = "a-token-of-the-test-0123"


class Held:
    """A session whose bench Ann has control of, with a clock."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 0.0
        monkeypatch.setattr(server_session, "ListeningClock", lambda: SimpleNamespace(now_s=lambda: self.now_s))
        self.handle: Any = BenchStandIn()
        self.session = Session([self.handle], Path())
        self.bench = self.session.bench("simulated")
        self.session.ask(self.bench, "ann", "Ann")

    def at(self, now_s: float) -> Held:
        self.now_s = now_s
        self.session.end_lost_leases()
        return self

    @property
    def is_held(self) -> bool:
        return self.bench.control.holder is not None


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> Held:
    """A session at rest."""
    return Held(monkeypatch)


def test_a_lease_is_long_at_rest_and_short_as_soon_as_something_is_done(held: Held) -> None:
    assert held.at(0.9 * LEASE_AT_REST_S).is_held
    held.handle.change(doing={"experiment": "pulse"})
    assert not held.at(held.now_s).is_held
    assert [what for what, _ in held.handle.told] == ["release"]


@pytest.mark.parametrize(("seconds", "doing", "is_held"), [
    (0.7, {"experiment": "pulse"}, True), (0.8, {"experiment": "pulse"}, False), (4.9, None, True), (5.1, None, False),
])  # fmt: skip
def test_a_lease_lasts_as_long_as_the_route_that_gives_it_says(
    seconds: float, doing: dict[str, str] | None, is_held: bool, held: Held
) -> None:
    """Without a sign for 0.75 s, at rest 5 s."""
    if doing:
        held.handle.change(doing=doing)
    assert held.at(seconds).is_held is is_held


def test_five_questions_without_an_answer_end_a_lease_and_a_sleep_counts_as_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_s = [100.0]
    monkeypatch.setattr(_silence, "time", SimpleNamespace(monotonic=lambda: now_s[0]))
    clock = _silence.ListeningClock()
    now_s[0] += 3600.0
    assert 5.0 * clock.now_s() == pytest.approx(LEASE_S)
    now_s[0] += 0.1
    assert clock.now_s() == pytest.approx(LEASE_S / 5.0 + 0.1)


def test_a_program_that_waits_for_control_looks_again_well_within_the_lease_it_may_have_got() -> None:
    assert 0.0 < 5.0 * POLL_S <= LEASE_S


def test_only_the_answer_to_a_recent_ping_keeps_a_lease(held: Held) -> None:
    held.handle.change(doing={"experiment": "pulse"})
    held.session.ping()  # number 1, at 0 s
    held.at(0.8 * LEASE_S).session.ping()
    held.session.pong("ann", 2)
    held.at(1.5 * LEASE_S).session.pong("ann", 1)
    assert held.is_held
    assert not held.at(1.9 * LEASE_S).is_held


def test_a_bench_is_told_that_somebody_is_there_only_while_its_holder_gives_signs(held: Held) -> None:
    """Without a sign for a while a bench ends what heats, whatever the server still believes of its holder."""
    held.now_s = 0.9 * LEASE_S
    held.session.ping()
    assert held.handle.signs_of_life == 1
    held.now_s = 1.1 * LEASE_S  # before the server has looked at its leases again
    held.session.ping()
    assert held.is_held
    assert held.handle.signs_of_life == 1


def test_the_end_of_a_session_closes_every_rig_once_whatever_one_of_them_raises() -> None:
    """A rig's process would also notice the end of its pipe; this is the order that comes before."""
    closed: list[str] = []

    class Closing(BenchStandIn):
        async def close(self) -> None:
            closed.append("closed")
            if len(closed) == 1:
                raise RigError("the rig's process cannot be ended: cut the supply")

    async def run() -> None:
        first, second = Closing(), Closing()
        second.identifier = "another"
        session = Session([first, second], Path())
        with pytest.raises(RigError, match="cut the supply"):
            await session.close()
        await session.close()

    asyncio.run(run())
    assert closed == ["closed", "closed"]


class Said:
    """A WebSocket that says what it was made with, and then that its client is gone."""

    application_state = None

    def __init__(self, *texts: str) -> None:
        self._texts = iter(texts)

    async def receive(self) -> dict[str, str]:
        text = next(self._texts, None)
        return {"type": "websocket.disconnect"} if text is None else {"type": "websocket.receive", "text": text}

    async def send_text(self, _text: str) -> None:
        """Send to nobody."""


@pytest.mark.parametrize("is_too_fast", [False, True])
def test_of_messages_that_come_too_fast_only_stops_are_carried_out(
    is_too_fast: bool, held: Held, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A message with the word that a stop has, but which is none, is left out like any other."""
    monkeypatch.setattr(application, "time", SimpleNamespace(monotonic=lambda: 0.0))
    monkeypatch.setattr(application, "MESSAGES_A_SECOND", 0 if is_too_fast else 2)
    ask = '{"type": "ask_control", "bench": "simulated", "name": "stop"}'
    stop = '{"type": "command", "id": 1, "bench": "simulated", "command": {"do": "stop"}}'
    viewer = held.session.enter()
    assert viewer is not None
    connection: Any = Said(ask, stop)
    asyncio.run(application.ViewerConnection(connection, held.session, viewer).run())
    assert held.handle.stops == 1
    assert viewer.name == ("viewer 1" if is_too_fast else "stop")


@pytest.mark.parametrize(("sent", "taken"), [(100, 100), (1000, 400)])
def test_a_slider_is_not_too_fast_and_a_thousand_messages_a_second_are(
    sent: int, taken: int, held: Held, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(application, "time", SimpleNamespace(monotonic=lambda: 0.0))
    viewer = held.session.enter()
    assert viewer is not None
    texts = (f'{{"type": "ask_control", "bench": "simulated", "name": "{number}"}}' for number in range(1, sent + 1))
    connection: Any = Said(*texts)
    asyncio.run(application.ViewerConnection(connection, held.session, viewer).run())
    assert viewer.name == str(taken)


class LateStandIn(BenchStandIn):
    """A bench that confirms a stop when the test says so."""

    def stop(self, who: str) -> asyncio.Future[None]:
        super().stop(who)
        self.confirmation: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        return self.confirmation


def http_of(handle: Any, token: str | None = None) -> httpx.AsyncClient:
    """Return a client of the whole application, its gate included, without a connection."""
    session, settings = Session([handle], Path()), ServerSettings(Path(), token=token)
    app = configuration(session, settings, ListenAddress(), Connections(8, session.is_kept), Turns()).app
    return httpx.AsyncClient(transport=httpx.ASGITransport(app=app))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("headers", "status"), [({}, 401), ({"Authorization": f"Bearer {TOKEN}", "Host": "evil.example"}, 421)]
)
def test_only_who_shows_no_token_is_asked_for_one(headers: dict[str, str], status: int) -> None:
    """An answer 401 names the scheme (RFC 9110, 11.6.1); no other refusal asks for a secret."""

    async def run() -> None:
        async with http_of(BenchStandIn(), TOKEN) as http:
            answer = await http.get(BENCH, headers=headers)
            assert answer.status_code == status
            assert answer.headers.get("WWW-Authenticate") == ("Bearer" if status == 401 else None)

    asyncio.run(run())


@pytest.mark.parametrize(
    ("path", "enters"),
    [
        (f"/?token={TOKEN}", True),
        ("/?token=another", False),
        (f"/?token={TOKEN}&token={TOKEN}", False),
        ("/", False),
        (f"/api/v1/benches?token={TOKEN}", False),
        (f"/?token={TOKEN}&" + "&".join("abcdef"), False),
    ],
)
def test_only_the_link_as_it_was_printed_enters(path: str, enters: bool) -> None:
    async def run() -> None:
        async with http_of(BenchStandIn(), TOKEN) as http:
            answer = await http.get(f"http://localhost{path}")
            assert (answer.status_code, "Set-Cookie" in answer.headers) == ((200, True) if enters else (401, False))
            foreign = await http.get(f"http://localhost{path}", headers={"Host": "evil.example"})
            assert (foreign.status_code, "Set-Cookie" in foreign.headers) == (421, False)

    asyncio.run(run())


def test_an_order_is_answered_once() -> None:
    sent: list[object] = []
    order = NumberedOrder(7, Any, SimpleNamespace(send=sent.append))  # type: ignore[arg-type]
    order.answer(True)
    order.answer(False, "too late")
    assert sent == [{"answer": 7, "accepted": True, "message": ""}]


def test_a_stop_is_answered_when_it_is_confirmed_although_the_bench_is_shown_as_stopped_before() -> None:
    async def run() -> None:
        handle = LateStandIn()
        async with http_of(handle) as http:
            answering = asyncio.create_task(http.post(f"{BENCH}/stop"))
            for _ in range(TURNS):
                await asyncio.sleep(0)
            assert handle.state["phase"] == "stopped"
            assert not answering.done()
            handle.confirmation.set_result(None)
            answer = await answering
            assert (answer.status_code, answer.json()) == (200, {"phase": "stopped"})

    asyncio.run(run())


def test_a_stop_that_is_not_confirmed_in_time_is_answered_as_such(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_routes, "STOP_ANSWER_S", 0.0)

    async def run() -> None:
        async with http_of(LateStandIn()) as http:
            assert (await http.post(f"{BENCH}/stop")).status_code == 202

    asyncio.run(run())


def test_a_stop_is_answered_a_second_later_at_most_and_not_before_any_protection_is_off(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    waits_s = []

    async def stopped(_bench: object, _who: str, wait_s: float) -> bool:
        waits_s.append(wait_s)
        return True

    async def run() -> None:
        async with http_of(LateStandIn()) as http:
            await http.post(f"{BENCH}/stop")

    monkeypatch.setattr(server_session.OnlineBench, "stopped", stopped)
    asyncio.run(run())
    assert protection_table().trip_after_s < waits_s[0] <= 1.0


@pytest.mark.parametrize("is_stopped", [True, False])
def test_an_order_whose_body_is_on_its_way_while_somebody_stops_came_before_the_stop(is_stopped: bool) -> None:
    async def run() -> None:
        handle = BenchStandIn()

        async def body() -> AsyncIterator[bytes]:
            yield b'{"do": '
            if is_stopped:
                handle.stop("somebody")
            yield b'"switch_on"}'

        async with http_of(handle) as http:
            lease = (await http.post(f"{BENCH}/control", json={"name": "Ann"})).json()["lease"]
            headers = {"Musclewire-Lease": lease, "Content-Type": "application/json"}
            answer = await http.post(f"{BENCH}/commands", content=body(), headers=headers)
            assert answer.status_code == (409 if is_stopped else 200)

    asyncio.run(run())
