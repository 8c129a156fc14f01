"""A board for somebody with nothing but a serial monitor: typed lines, labelled numbers, and it stops by itself."""

from __future__ import annotations

import re
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from emulation.board import EmulatedBoard, firmware_for
from tests.extras.board.firmware.conftest import HELLO, IDENTITY, PATIENCE_S, Host
from tests.tools import require_tool

pytestmark = pytest.mark.emulated

NUMBERS = re.compile(r"target_pct:(\S+) estimate_pct:(\S+) resistance_ohm:(\S+) drive_v:(\S+)")
COMPILERS = {"mps2-an386": "arm-none-eabi-gcc", "arduino-uno": "avr-gcc"}
EMULATORS = {"mps2-an386": "qemu-system-arm", "arduino-uno": "simavr"}


class Typist:
    """Types lines into a serial monitor and reads what comes, without any heartbeat."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._read = b""
        self.lines: list[str] = []

    def type(self, line: str) -> None:
        self.lines.clear()
        self._socket.sendall(line.encode() + b"\n")

    def listen(self) -> None:
        self._socket.settimeout(0.05)
        try:
            self._read += self._socket.recv(4096)
        except TimeoutError:
            return
        *whole, self._read = self._read.split(b"\r\n")
        self.lines += [line.decode("latin-1") for line in whole]

    def wait_for(self, seen: Callable[[Typist], bool]) -> None:
        end_s = time.monotonic() + PATIENCE_S
        while not seen(self):
            assert time.monotonic() < end_s, self.lines[-10:]
            self.listen()

    def said(self, text: str) -> bool:
        return any(text in line for line in self.lines)

    def numbers(self) -> tuple[float, ...]:
        found = [match for line in self.lines if (match := NUMBERS.fullmatch(line))]
        return tuple(float(number) for number in found[-1].groups()) if found else ()

    def switch_on(self) -> None:
        """Arm, also again where a busy emulator has been late."""
        self.type("plot")
        self.wait_for(lambda typist: bool(typist.numbers()))
        self.type("on")
        self.wait_for(lambda typist: typist.said("# on") and bool(typist.numbers()) and typist.numbers()[3] > 0.0)

    def close(self) -> None:
        self._socket.close()


@pytest.fixture(scope="module", params=sorted(COMPILERS))
def board(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[EmulatedBoard]:
    require_tool(COMPILERS[request.param], f"the compiler of {request.param}")
    require_tool(EMULATORS[request.param], f"the emulator of {request.param}")
    elf = firmware_for(request.param, tmp_path_factory.mktemp("text"))
    with EmulatedBoard(board=request.param, elf=elf) as made:
        yield made


@pytest.fixture
def typist(board: EmulatedBoard) -> Iterator[Typist]:
    made = Typist(board.port)
    yield made
    made.type("stop")
    made.close()


def test_a_typed_target_is_followed_and_the_plot_shows_it(typist: Typist, board: EmulatedBoard) -> None:
    typist.switch_on()
    typist.type("target 2.0 60")
    typist.wait_for(lambda typist: bool(typist.numbers()) and abs(typist.numbers()[1] - 2.0) < 0.1)
    target, _, ohm, drive_v = typist.numbers()
    assert (target, drive_v > 1.0) == (2.0, True)
    assert 14.0 < ohm < 18.0
    assert board.log()["strain"][-1] == pytest.approx(0.02, abs=0.004)
    typist.type("stop")
    typist.wait_for(lambda typist: bool(typist.numbers()) and typist.numbers()[3] == 0.0)
    assert board.log()["output_voltage_v"][-1] == 0.0


def test_a_host_takes_over_with_its_first_frame(board: EmulatedBoard) -> None:
    typist = Typist(board.port)
    typist.switch_on()
    typist.close()
    host = Host(board)
    host.raw(b"\0")
    assert host.command(HELLO) == 0
    assert host.wait_for(IDENTITY)
    assert board.log()["output_voltage_v"][-1] == 0.0
    host.close()


def test_a_firmware_for_the_plotter_begins_with_numbers(tmp_path: Path) -> None:
    require_tool("avr-gcc", "gcc-avr avr-libc")
    require_tool("simavr", "simavr libsimavr-dev libelf-dev gcc libc6-dev")
    elf = firmware_for("arduino-uno", tmp_path, ["--serial-plotter"])
    with EmulatedBoard(board="arduino-uno", elf=elf) as board:
        typist = Typist(board.port)
        typist.wait_for(lambda typist: bool(typist.numbers()))
        assert typist.numbers()[3] == 0.0
        typist.close()
