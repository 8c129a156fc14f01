"""The firmware for the STM32F411 has no emulator with its converter: it is built, and its start and line are tried.

QEMU's nearest board has an STM32F405: the same core, serial line and addresses, without watchdog, pins, PWM or a
converter that ever finishes. That the firmware then refuses to drive is part of the test.
"""

from __future__ import annotations

import socket
import struct
import subprocess
import time
from pathlib import Path

import pytest
from emulation.board import firmware_for
from tests.extras.board.firmware.conftest import PATIENCE_S
from tests.tools import require_tool

from musclewire.extras.board import FrameParser, SerialFrame, encode_frame

pytestmark = pytest.mark.emulated

ARM, IDENTITY, EVENT, TRIPPED, SAMPLE_LATE = 2, 0x81, 0x83, 4, 19
# Priorities in a Cortex-M4 (Arm DDI 0403): of exceptions 12 to 15, SysTick the last; of interrupts 36 to 39.
SYSTEM_PRIORITIES, LINE_PRIORITIES = 0xE000ED20, 0xE000E424


@pytest.fixture(scope="module")
def elf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    require_tool("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi")
    require_tool("qemu-system-arm", "qemu-system-arm")
    return firmware_for("stm32f411", tmp_path_factory.mktemp("stm32"))


def test_it_starts_says_who_it_is_and_goes_off_without_a_converter(elf: Path) -> None:
    frames = said_by(elf, [SerialFrame(ARM, 1, b"")], EVENT, 3)
    identity = next(frame.payload for frame in frames if frame.kind == IDENTITY)
    assert identity[31:47].rstrip(b"\0") == b"stm32f411"
    states = [frame.payload[4:6] for frame in frames if frame.kind == EVENT]
    assert states[-1] == bytes([TRIPPED, SAMPLE_LATE])


def said_by(image: Path, commands: list[SerialFrame], kind: int, count: int) -> list[SerialFrame]:
    """Start an image; send commands, and listen until so many frames of a kind have come."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        line = f"socket,id=line,host=127.0.0.1,port={server.getsockname()[1]}"
        quiet = ["-display", "none", "-monitor", "none", "-net", "none", "-serial", "null"]
        command = ["qemu-system-arm", "-M", "netduinoplus2", *quiet, "-chardev", line, "-serial", "chardev:line"]
        with subprocess.Popen([*command, "-kernel", str(image)]) as machine:
            connection, _ = server.accept()
            with connection:
                frames = said(connection, commands, kind, count)
            machine.kill()
    return frames


def said(connection: socket.socket, commands: list[SerialFrame], kind: int, count: int) -> list[SerialFrame]:
    """Send commands once the board has said who it is; listen until so many frames of a kind have come."""
    parser, frames, told = FrameParser(), [], False
    end_s = time.monotonic() + PATIENCE_S
    connection.settimeout(0.5)
    while sum(frame.kind == kind for frame in frames) < count:
        assert time.monotonic() < end_s, frames
        try:
            frames += parser.feed(connection.recv(4096))
        except TimeoutError:
            continue
        if frames and not told:
            told = True
            connection.sendall(b"".join(map(encode_frame, commands)))
    return frames


@pytest.mark.parametrize("board", ["mps2-an386", "stm32f411", "arduino-uno"])
def test_every_board_can_be_built_to_run_alone(board: str, tmp_path: Path) -> None:
    require_tool("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi")
    require_tool("avr-gcc", "gcc-avr avr-libc")
    built = firmware_for(board, tmp_path, ["--standalone"])
    assert struct.unpack_from("<4s", built.read_bytes()) == (b"\x7fELF",)


def test_the_lines_interrupt_may_interrupt_the_conversions(elf: Path) -> None:
    """SysTick waits for two conversions, longer than a byte takes at 1 MBd: at equal priority bytes would be lost."""
    quiet = ["-display", "none", "-net", "none", "-serial", "null", "-serial", "null", "-monitor", "stdio"]
    command = ["qemu-system-arm", "-M", "netduinoplus2", *quiet, "-kernel", str(elf)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as machine:
        try:
            end_s, systick = time.monotonic() + PATIENCE_S, 0
            while systick == 0 and time.monotonic() < end_s:  # until the firmware has come so far
                systick = word(machine, SYSTEM_PRIORITIES) >> 24
            line = word(machine, LINE_PRIORITIES) >> 16 & 0xFF
        finally:
            machine.kill()
    assert line < systick


def word(machine: subprocess.Popen[str], address: int) -> int:
    """What the running board's memory holds at an address, asked of the emulator's monitor."""
    assert machine.stdin
    assert machine.stdout
    machine.stdin.write(f"x /1wx {address:#x}\n")
    machine.stdin.flush()
    answer = next(text for text in machine.stdout if text.startswith(f"{address:08x}: "))
    return int(answer.split()[1], 16)
