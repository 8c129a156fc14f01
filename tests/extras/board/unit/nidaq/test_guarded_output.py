"""The host's end of the guardian: its answers, and who switches off when it is gone, without a process or a card."""

from __future__ import annotations

import io
import socket
import subprocess
from collections.abc import Iterator
from typing import Any, ClassVar

import pytest
from tests.extras.board.unit.nidaq.card_in_memory import OFF_V, ORDERS, CardInMemory

from musclewire.errors import RigError
from musclewire.extras.board._nidaq import output as module
from musclewire.extras.board._nidaq.driver import DaqFaultError
from musclewire.extras.board._nidaq.guardian import COMMAND, END, KEEP, PUT, REPLY, GuardianOrders
from musclewire.extras.board._nidaq.output import GuardedOutput, GuardianLostError, HostStalledError

DONE = REPLY.pack(b"A", 0.0, 0, 0)


def failed(text: str, code: int) -> bytes:
    return REPLY.pack(b"E", 0.0, code, len(text)) + text.encode()


class GuardianInMemory:
    """Stands in for ``subprocess.Popen``: connects as a guardian does, and says what a test wants it to say."""

    first = DONE
    strangers: tuple[bytes, ...] = ()  # what others say to the host's port before it
    exit_code = 0
    line: socket.socket
    made: ClassVar[list[GuardianInMemory]]

    def __init__(self, *_: Any, **__: Any) -> None:
        self.ended = False
        self.stdin = io.StringIO()
        self.stdin.close = self.connect  # type: ignore[method-assign]

    def connect(self) -> None:
        first, orders = self.stdin.getvalue().splitlines()
        port, word = first.split()
        assert GuardianOrders.from_text(orders) == ORDERS
        for said in self.strangers:
            with socket.create_connection(("127.0.0.1", int(port))) as other:
                other.sendall(said)
        self.line = socket.create_connection(("127.0.0.1", int(port)), timeout=60.0)
        self.made.append(self)
        self.line.sendall(word.encode() + self.first)

    def heard(self) -> tuple[bytes, float]:
        what, drive_v = COMMAND.unpack(self.line.recv(COMMAND.size, socket.MSG_WAITALL))
        return what, drive_v

    def poll(self) -> int | None:
        return self.exit_code if self.ended else None

    def kill(self) -> None:
        self.ended, self.exit_code = True, -9
        for one in self.made:
            one.line.close()

    def wait(self, timeout: float | None = None) -> int:
        if timeout is not None and self.exit_code == -9:
            raise subprocess.TimeoutExpired("guardian", timeout)
        self.ended = True
        return self.exit_code


@pytest.fixture
def card(monkeypatch: pytest.MonkeyPatch) -> CardInMemory:
    card = CardInMemory()
    monkeypatch.setattr(module, "OutputLine", lambda _settings: card)
    return card


@pytest.fixture
def guardian(monkeypatch: pytest.MonkeyPatch) -> Iterator[type[GuardianInMemory]]:
    """The kind of guardian that the next output starts; a test changes it before."""
    kind = type("Guardian", (GuardianInMemory,), {"made": []})
    monkeypatch.setattr(module.subprocess, "Popen", kind)
    yield kind
    for one in kind.made:
        one.line.close()


def started() -> tuple[GuardedOutput, GuardianInMemory]:
    output = GuardedOutput(ORDERS)
    process: Any = output._process
    return output, process


@pytest.mark.parametrize(("rate_hz", "clock_hz"), [(20.0, 20.0), (0.0, None)])
def test_its_first_answer_is_the_rate_of_the_cards_clock(
    guardian: type[GuardianInMemory], rate_hz: float, clock_hz: float | None
) -> None:
    guardian.first = REPLY.pack(b"A", rate_hz, 0, 0)
    output, _ = started()
    assert output.clock_hz == clock_hz
    assert output.close()


@pytest.mark.parametrize("said", [b"", b"abc", b"0" * module.WORD_BYTES])
def test_whoever_does_not_know_the_word_is_not_taken_for_the_guardian(
    guardian: type[GuardianInMemory], said: bytes
) -> None:
    guardian.strangers = (said,)
    output, process = started()
    process.line.sendall(DONE)
    output.put(2.0)
    assert process.heard() == (PUT, 2.0)
    assert output.close()


def test_a_card_that_refuses_at_the_start_is_the_cards_fault_and_ends_the_process(
    guardian: type[GuardianInMemory],
) -> None:
    guardian.first = failed("Dev1 has no such channel", -200170)
    with pytest.raises(DaqFaultError, match="no such channel") as caught:
        GuardedOutput(ORDERS)
    assert caught.value.code == -200170


def test_a_process_that_does_not_start_leaves_none_behind_and_nothing_on_the_card(
    guardian: type[GuardianInMemory], card: CardInMemory
) -> None:
    begun: list[GuardianInMemory] = []

    def broken(self: GuardianInMemory) -> None:
        begun.append(self)
        raise BrokenPipeError

    guardian.connect = broken  # type: ignore[method-assign]
    with pytest.raises(GuardianLostError):
        GuardedOutput(ORDERS)
    assert [one.ended for one in begun] == [True]
    assert card.out == []


@pytest.mark.usefixtures("guardian")
def test_what_the_guardian_says_of_a_command_is_raised() -> None:
    output, process = started()
    process.line.sendall(failed("Dev1 was removed from the system", -200045))
    with pytest.raises(DaqFaultError, match="removed"):
        output.begin(1.0)
    process.line.sendall(REPLY.pack(b"T", 0.31, 0, 0))
    with pytest.raises(HostStalledError, match=r"0\.310 s") as caught:
        output.put_now(0.3)
    assert caught.value.silent_s == pytest.approx(0.31)
    assert output.close()


@pytest.mark.usefixtures("guardian")
def test_a_sign_of_life_learns_of_a_guardian_that_has_switched_off() -> None:
    output, process = started()
    process.line.sendall(DONE)
    output.keep()
    assert process.heard() == (KEEP, 0.0)
    process.line.sendall(REPLY.pack(b"T", 0.31, 0, 0))
    with pytest.raises(HostStalledError, match=r"0\.310 s"):
        output.keep()
    assert process.heard() == (KEEP, 0.0)
    assert output.close()
    assert process.heard() == (END, 0.0)


@pytest.mark.usefixtures("guardian")
@pytest.mark.parametrize(("refuses", "how"), [((), "now"), (("now",), "reset")])
def test_a_guardian_that_is_gone_leaves_the_host_to_switch_off_by_a_reset_if_need_be(
    card: CardInMemory, refuses: tuple[str, ...], how: str
) -> None:
    output, process = started()
    process.line.close()
    card.refuses = list(refuses)
    with pytest.raises(GuardianLostError, match="this one has switched off"):
        output.put(2.0)
    assert card.out == [(how, OFF_V)]
    assert output.close()
    assert output.close()


@pytest.mark.usefixtures("guardian")
@pytest.mark.parametrize("opens", [True, False])
def test_nobody_says_that_a_card_which_refuses_or_cannot_be_opened_is_off(
    opens: bool, card: CardInMemory, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(_settings: object) -> CardInMemory:
        raise DaqFaultError("Dev1 was removed", -200324)

    output, process = started()
    process.line.close()
    card.refuses = ["now", "reset"]
    if not opens:
        monkeypatch.setattr(module, "OutputLine", gone)
    with pytest.raises(GuardianLostError, match="has ended, and Dev1 was removed"):
        output.put(2.0)
    assert card.closed is opens
    assert not output.close()


@pytest.mark.usefixtures("guardian")
@pytest.mark.parametrize(
    ("exit_code", "confirmed", "by_host"),
    [(0, True, False), (RigError.exit_code, False, False), (1, True, True), (-9, True, True)],
)
def test_the_guardians_end_says_whether_0_v_is_out_and_any_other_end_is_made_good(
    card: CardInMemory, exit_code: int, confirmed: bool, by_host: bool
) -> None:
    output, process = started()
    process.exit_code = exit_code
    assert output.close() is confirmed
    assert card.out == ([("now", OFF_V)] if by_host else [])


@pytest.mark.usefixtures("guardian")
def test_a_host_that_cannot_reach_its_guardian_at_the_end_switches_off_itself(card: CardInMemory) -> None:
    output, _ = started()
    output._line.close()
    assert output.close()
    assert card.out == [("now", OFF_V)]


@pytest.mark.usefixtures("guardian")
def test_a_broken_line_is_a_lost_guardian_whatever_is_sent() -> None:
    for command in ("keep", "put"):
        output, _ = started()
        output._line.close()
        with pytest.raises(GuardianLostError):
            output.keep() if command == "keep" else output.put(1.0)
