"""The same firmware on an ATmega328P in simavr: ten bits, one hundred ticks a second, and it counts cycles."""

from __future__ import annotations

import re
import struct
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from emulation.board import EmulatedBoard, firmware_for
from tests.extras.board.firmware.conftest import ARM, HELLO, IDENTITY, INJECT, STREAM, TARGET, Host
from tests.extras.board.firmware.test_the_emulated_board import (
    COMMAND_MISSING,
    STATED_S,
    WATCHDOG,
    off_after_s,
    running,
)
from tests.tools import require_tool

pytestmark = pytest.mark.emulated

STEP_V = 5.0 / 1023


@pytest.fixture(scope="module")
def arduino_elf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    require_tool("avr-gcc", "gcc-avr avr-libc")
    require_tool("simavr", "simavr libsimavr-dev libelf-dev gcc libc6-dev")
    return firmware_for("arduino-uno", tmp_path_factory.mktemp("avr"), ["--fault-injection"])


@pytest.fixture
def board(arduino_elf: Path) -> Iterator[EmulatedBoard]:
    with EmulatedBoard(board="arduino-uno", elf=arduino_elf) as made:
        yield made


@pytest.fixture
def host(board: EmulatedBoard) -> Iterator[Host]:
    made = Host(board)
    yield made
    made.close()


def test_it_says_who_it_is_arms_drives_streams_and_expires(board: EmulatedBoard, host: Host) -> None:
    assert host.command(HELLO) == 0
    identity = host.wait_for(IDENTITY)[-1]
    assert identity[31:47].rstrip(b"\0") == b"arduino-uno"
    assert struct.unpack_from("<I", identity, 4) == (10_000,)
    assert host.command(STREAM, struct.pack("<H", 5)) == 0
    running(host, 1.5)
    host.drive(1.5)
    host.listen(0.05)
    sample, log = host.samples()[-1], board.log()
    assert log["output_voltage_v"][-1] == pytest.approx(1.5, abs=STEP_V)
    # Ten readings of ten bits, five ticks: a tenth of a step is 0.5 mV, at the shunt a twentieth of it.
    assert sample.wire_voltage_v == pytest.approx(log["wire_voltage_v"][-1], rel=0.02)
    assert sample.resistance_ohm == pytest.approx(17.4, rel=0.02)
    since_s = time.monotonic()
    assert off_after_s(board, since_s) < STATED_S
    host.wait_for(0x82, len(host.samples()) + 2)
    assert host.samples()[-1].event == COMMAND_MISSING


def test_a_stuck_loop_is_off_and_told_after_the_reset(board: EmulatedBoard, host: Host) -> None:
    running(host)
    since_s = time.monotonic()
    host.frames.clear()  # what it said when it was switched on
    host.command(INJECT, b"\x01")
    assert off_after_s(board, since_s) < STATED_S
    identity = host.wait_for(IDENTITY)[-1]
    assert (identity[3], identity[30]) == (2, WATCHDOG)


def test_it_closes_the_loop_and_has_cycles_left(board: EmulatedBoard, host: Host) -> None:
    host.command(STREAM, struct.pack("<H", 5))
    end_s = time.monotonic() + 60.0
    while not reached(host, 0.012):
        assert time.monotonic() < end_s, [sample.estimate for sample in host.samples()[-30:]]
        if host.command(TARGET, struct.pack("<f", 0.012)) != 0:
            host.command(ARM)  # not armed yet, or this host was too late and the board has gone off
        host.listen(0.03)
    counted = re.findall(r"mean (\d+), most (\d+) of (\d+)", board.messages())
    assert counted
    assert all(int(most) < int(whole) for _, most, whole in counted)


def reached(host: Host, target: float) -> bool:
    """Whether the board's estimate has been near a target for 1.5 s."""
    last = [sample.estimate for sample in host.samples()[-30:]]
    return len(last) == 30 and bool(np.mean(last) == pytest.approx(target, abs=0.0015)) and float(np.std(last)) < 0.001


def test_alone_it_follows_its_knob_from_press_to_press(tmp_path: Path, arduino_elf: Path) -> None:
    assert arduino_elf.exists()  # the tools are there
    alone = firmware_for("arduino-uno", tmp_path, ["--standalone"])
    with EmulatedBoard(board="arduino-uno", elf=alone) as board:
        board.turn_knob(0.3)  # of the stroke, 0.42 to 3.58 %
        time.sleep(0.3)
        assert board.log()["output_voltage_v"].max() == 0.0
        board.press()
        end_s = time.monotonic() + 60.0
        while board.log()["strain"][-1] < 0.008:
            assert time.monotonic() < end_s, "the wire did not contract"
            time.sleep(0.2)
        assert board.log()["output_voltage_v"][-1] > 1.0
        board.press()
        time.sleep(0.2)
        assert board.log()["output_voltage_v"][-1] == 0.0
