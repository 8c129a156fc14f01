"""The guardian on a card in memory: what it applies, what it answers, how it switches off whatever the card does."""

from __future__ import annotations

import io
import signal
import socket
from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest
from tests.extras.board.unit.nidaq.card_in_memory import OFF_V, ORDERS, CardInMemory

from musclewire.extras.board._nidaq import guardian as module
from musclewire.extras.board._nidaq.driver import DaqFaultError
from musclewire.extras.board._nidaq.guardian import BEGIN, COMMAND, END, KEEP, PUT, REPLY, SAFE, OutputGuardian


@dataclass
class Clock:
    """Time that passes only while somebody sleeps."""

    now_s: float = 100.0

    def monotonic(self) -> float:
        return self.now_s

    def sleep(self, duration_s: float) -> None:
        self.now_s += duration_s


@dataclass
class Bench:
    """A guardian, its card, and the host's end of the line."""

    card: CardInMemory
    clock: Clock
    host: socket.socket
    line: socket.socket

    def guardian(self) -> OutputGuardian:
        return OutputGuardian(ORDERS, self.line)

    def send(self, *commands: tuple[bytes, float]) -> None:
        self.host.sendall(b"".join(COMMAND.pack(*command) for command in commands))

    def reply(self) -> tuple[bytes, float, int, str]:
        what, number, code, length = REPLY.unpack(self.host.recv(REPLY.size, socket.MSG_WAITALL))
        text = self.host.recv(length, socket.MSG_WAITALL).decode() if length else ""
        return what, number, code, text


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    card, clock = CardInMemory(), Clock()
    monkeypatch.setattr(module, "OutputLine", lambda _settings: card)
    monkeypatch.setattr(module, "time", clock)
    monkeypatch.setattr(
        module.signal, "signal", lambda *_: None
    )  # the guardian ends after run(); this process does not
    host, line = socket.socketpair()
    for end in (host, line):
        end.settimeout(60.0)
    with host, line:
        yield Bench(card, clock, host, line)


def test_it_begins_at_0_v_and_says_the_rate_of_the_cards_clock(bench: Bench) -> None:
    bench.card.clock = 20.0
    bench.guardian()
    assert bench.card.out == [("now", OFF_V)]
    assert bench.reply() == (b"A", 20.0, 0, "")


def test_a_card_without_a_clock_has_a_rate_of_0(bench: Bench) -> None:
    guardian = bench.guardian()
    guardian._obey(BEGIN, 0.0)
    assert bench.reply() == (b"A", 0.0, 0, "")


def test_a_card_that_refuses_0_v_at_the_beginning_is_closed(bench: Bench) -> None:
    bench.card.refuses = ["now"]
    with pytest.raises(DaqFaultError):
        bench.guardian()
    assert bench.card.closed


def test_commands_go_out_in_volts_of_the_card_and_end_at_0_v(bench: Bench) -> None:
    guardian = bench.guardian()
    bench.send((BEGIN, 0.0), (PUT, 2.0), (KEEP, 0.0), (SAFE, 0.3), (END, 0.0))
    assert guardian.run()
    assert bench.card.out[1:] == [("begin", OFF_V), ("edge", 1.1), ("now", 0.25), ("now", OFF_V)]
    # Its start, four commands, and the end.
    assert [bench.reply()[0] for _ in range(6)] == [b"A"] * 6
    assert (bench.card.closed, bench.card.released) == (True, False)


@pytest.mark.parametrize("bytes_left", [0, 3])
def test_a_host_that_is_gone_even_within_a_message_ends_at_0_v_and_frees_the_card(
    bench: Bench, bytes_left: int
) -> None:
    guardian = bench.guardian()
    bench.send((PUT, 2.0))
    bench.host.sendall(COMMAND.pack(PUT, 3.0)[:bytes_left])
    bench.host.shutdown(socket.SHUT_WR)
    assert guardian.run()
    assert bench.card.out[-1] == ("now", OFF_V)
    assert ("edge", 1.6) not in bench.card.out
    assert (bench.card.closed, bench.card.released) == (True, True)


def test_a_host_whose_process_has_ended_is_gone_although_others_hold_its_socket(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    guardian = bench.guardian()
    monkeypatch.setattr(module.os, "getppid", lambda: 1)
    assert guardian.run()
    assert bench.card.released


def test_what_the_card_refuses_is_told_with_its_number_and_does_not_count_as_driven(bench: Bench) -> None:
    bench.card.refuses = ["edge"]
    guardian = bench.guardian()
    bench.send((PUT, 2.0), (END, 0.0))
    assert guardian.run()
    bench.reply()
    what, _, code, text = bench.reply()
    assert (what, code) == (b"E", -200045)
    assert "removed" in text
    assert guardian._watch.drive_v == 0.0


def test_silence_leads_to_the_sense_voltage_then_off_and_every_later_command_is_refused(bench: Bench) -> None:
    guardian = bench.guardian()
    guardian._obey(PUT, 2.0)
    guardian._look(100.05)
    assert bench.card.out[-1] == ("edge", 1.1)
    guardian._look(100.15)
    assert bench.card.out[-1] == ("now", 0.25)
    guardian._look(100.3)
    assert bench.card.out[-1] == ("now", OFF_V)
    assert not guardian._obey(PUT, 2.0)
    assert bench.card.out[-1] == ("now", OFF_V)
    replies = [bench.reply() for _ in range(3)]
    assert replies[-1][0] == b"T"
    assert replies[-1][1] == pytest.approx(0.3)


def test_a_silent_host_costs_no_more_time_than_was_ordered(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """However the guardian waits: time passes in its waits alone, and at each change of the card it is not late."""
    guardian, changed_s = bench.guardian(), []

    def select(_lines: object, _write: object, _error: object, wait_s: float) -> tuple[list[object], ...]:
        bench.clock.now_s += wait_s + 1e-6
        return [], [], []

    monkeypatch.setattr(module, "select", SimpleNamespace(select=select))
    guardian._obey(PUT, 2.0)
    for _ in range(20):
        before = len(bench.card.out)
        silent_at_s = guardian._silent_at_s()
        assert silent_at_s is not None
        guardian._look(silent_at_s)
        if len(bench.card.out) > before:
            changed_s.append(bench.clock.now_s - 100.0)
    assert changed_s == pytest.approx([ORDERS.sense_after_s, ORDERS.trip_after_s], abs=1e-3)
    assert bench.card.out[-1] == ("now", OFF_V)


def test_a_command_that_came_while_the_guardian_itself_was_delayed_ends_the_silence(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The wait ends without a command; then the machine holds the guardian up, and the host goes on meanwhile."""
    guardian = bench.guardian()
    guardian._obey(PUT, 2.0)
    waits: list[float] = []

    def select(lines: list[socket.socket], _write: object, _error: object, wait_s: float) -> tuple[list[object], ...]:
        waits.append(wait_s)
        if len(waits) > 1:
            return real(lines, [], [], 60.0)
        bench.clock.now_s += 1.0
        bench.send((KEEP, 0.0), (END, 0.0))
        return [], [], []

    real = module.select.select
    monkeypatch.setattr(module, "select", SimpleNamespace(select=select))
    assert guardian.run()
    assert bench.card.out == [("now", OFF_V), ("edge", 1.1), ("now", OFF_V)]
    assert bench.reply()[0] == bench.reply()[0] == bench.reply()[0] == b"A"


def test_silence_on_a_card_that_refuses_the_sense_voltage_ends_at_0_v(bench: Bench) -> None:
    guardian = bench.guardian()
    guardian._obey(PUT, 2.0)
    bench.card.refuses = ["now"]
    guardian._look(100.15)
    assert bench.card.out[-1] == ("now", OFF_V)


def test_a_card_that_refuses_a_write_is_reset(bench: Bench) -> None:
    guardian = bench.guardian()
    bench.card.refuses = ["now"]
    bench.send((END, 0.0))
    assert guardian.run()
    assert bench.card.out[-1] == ("reset", OFF_V)


@pytest.mark.parametrize(("goodbye", "persists_s"), [(True, module.PERSIST_S), (False, module.PERSIST_ALONE_S)])
def test_it_goes_on_trying_to_switch_off_and_for_longer_when_nobody_else_does(
    bench: Bench, goodbye: bool, persists_s: float
) -> None:
    guardian = bench.guardian()
    bench.card.refuses = ["now", "reset"] * 5000
    if goodbye:
        bench.send((END, 0.0))
    bench.host.shutdown(socket.SHUT_WR)
    assert not guardian.run()
    assert persists_s <= bench.clock.now_s - 100.0 <= persists_s + 3 * module.LOOK_S
    assert bench.card.closed


def test_a_card_that_comes_back_is_switched_off_at_last(bench: Bench) -> None:
    guardian = bench.guardian()
    bench.card.refuses = ["now", "reset"] * 4
    bench.send((END, 0.0))
    assert guardian.run()
    assert bench.card.out[-1] == ("now", OFF_V)


def test_it_asks_to_run_before_others_for_itself_and_goes_on_where_that_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[int] = []

    def refuse(process: int, *_: object) -> None:
        asked.append(process)
        raise PermissionError

    system = SimpleNamespace(sched_setscheduler=refuse, SCHED_FIFO=1, sched_param=float)
    monkeypatch.setattr(module, "os", system)
    module.go_first()
    assert asked == [0]  # this process


@pytest.mark.parametrize("error", [SystemExit(0), ConnectionResetError()], ids=["SIGTERM", "host died"])
def test_a_signal_that_ends_it_or_a_line_that_breaks_leaves_0_v_and_a_free_card(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    guardian = bench.guardian()

    def ended() -> bool:
        raise error

    monkeypatch.setattr(guardian, "_serve", ended)
    assert guardian.run()
    assert bench.card.out[-1] == ("now", OFF_V)
    assert (bench.card.closed, bench.card.released) == (True, True)
    assert signal.getsignal(signal.SIGTERM) is not signal.SIG_IGN


@pytest.mark.parametrize("off", [True, False])
def test_its_exit_code_says_whether_the_card_took_0_v(monkeypatch: pytest.MonkeyPatch, off: bool) -> None:
    monkeypatch.setattr(module, "go_first", lambda: None)
    monkeypatch.setattr(module, "sys", SimpleNamespace(stdin=io.StringIO("1 word\norders\n")))
    monkeypatch.setattr(module.GuardianOrders, "from_text", lambda _text: ORDERS)
    line = MagicMock()
    # Of this module alone: the process may have other threads that open connections.
    own = SimpleNamespace(**{**vars(socket), "create_connection": lambda *_, **__: line})
    monkeypatch.setattr(module, "socket", own)
    monkeypatch.setattr(module, "OutputGuardian", lambda _orders, _line: SimpleNamespace(run=lambda: off))
    assert (module.main() == 0) is off
    line.sendall.assert_called_once_with(b"word")
