"""The firmware's binary in QEMU with the simulated wire on its pins, judged by what truly was at the wire.

Faults of board and line on it are rows of the fault matrix.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from emulation.board import EmulatedBoard
from tests.extras.board.firmware.conftest import ARM, HELLO, IDENTITY, KEEP, OFF, STREAM, TARGET, Host, Sample

SENSE_V = 0.3
# The output's step at the emulated board: 5 V over 14 bits.
STEP_V = 5.0 / (2**14 - 1)
WATCHDOG, COMMAND_MISSING, POWER_LOST = 20, 15, 21
# Every fault must end in the safe state within this time [s].
STATED_S = 0.5


@pytest.fixture
def board(elf: Path) -> Iterator[EmulatedBoard]:
    with EmulatedBoard(elf=elf) as made:
        yield made


@pytest.fixture
def host(board: EmulatedBoard) -> Iterator[Host]:
    made = Host(board)
    yield made
    made.close()


# On a busy machine this host may be too late itself; the board has rightly gone off then, and it tries again.
TRIES = 20


def running(host: Host, voltage_v: float = 1.5) -> float:
    """Arm and drive for a moment; return when the last command was sent."""
    for _ in range(TRIES):
        assert host.command(ARM) == 0
        for _ in range(4):
            since_s = time.monotonic()
            if host.drive(voltage_v) != 0:
                break
            host.listen(0.03)
        else:
            return since_s
    raise AssertionError(f"in {TRIES} tries the board was never driven for 0.12 s")


def off_after_s(board: EmulatedBoard, since_s: float) -> float:
    """Return how long after a time the output went to 0 V for good."""
    end_s = time.monotonic() + 3.0
    while time.monotonic() < end_s:
        log = board.log()
        if log["output_voltage_v"][-1] == 0.0 and log["clock_s"][-1] > since_s + STATED_S:
            break
        time.sleep(0.05)
    later = log["clock_s"] >= since_s
    driven = log["clock_s"][later][log["output_voltage_v"][later] > 0.0]
    return float(driven[-1] - since_s) if driven.size else 0.0


@pytest.mark.emulated
def test_a_board_says_who_it_is_arms_drives_and_goes_off(board: EmulatedBoard, host: Host) -> None:
    assert host.command(HELLO) == 0
    (identity,) = host.wait_for(IDENTITY)[-1:]
    assert identity[31:47].rstrip(b"\0") == b"mps2-an386"
    assert host.drive(1.0) == 1  # refused: not armed
    since_s = running(host, 1.5)
    log = board.log()
    # The highest since then, not the last: a busy host may read the log when the drive has expired.
    assert log["output_voltage_v"][log["clock_s"] >= since_s].max() == pytest.approx(1.5, abs=STEP_V)
    assert host.command(OFF) == 0
    host.listen(0.05)
    assert board.log()["output_voltage_v"][-1] == 0.0


@pytest.mark.emulated
def test_a_board_that_restarts_in_a_run_is_off_and_says_so_unasked(board: EmulatedBoard, host: Host) -> None:
    running(host, 1.5)
    before = len(host.of_kind(IDENTITY))
    board.reset()
    identity = host.wait_for(IDENTITY, before + 1)[-1]
    assert identity[30] == POWER_LOST
    assert board.log()["output_voltage_v"][-1] == 0.0


@pytest.mark.emulated
def test_without_commands_the_drive_is_held_then_sensed_then_off(board: EmulatedBoard, host: Host) -> None:
    since_s = running(host, 2.0)
    assert off_after_s(board, since_s) < STATED_S
    log = board.log()
    after = log["clock_s"] > since_s
    levels = log["output_voltage_v"][after]
    assert np.isclose(levels, SENSE_V, atol=STEP_V).sum() > 20  # on its way down it sensed
    host.listen(0.05)
    assert host.command(STREAM, struct.pack("<H", 10)) == 0
    host.wait_for(0x82)
    assert (host.samples()[-1].state, host.samples()[-1].event) == (4, COMMAND_MISSING)


@pytest.mark.emulated
def test_a_paused_processor_leaves_its_output_and_is_not_believed_afterwards(board: EmulatedBoard, host: Host) -> None:
    """Where the clock of the processor itself stops, its watchdog stops too: the text says so, the test shows it."""
    running(host)
    board.pause()
    time.sleep(0.4)
    assert board.log()["output_voltage_v"][-1] > 0.0
    since_s = time.monotonic()
    board.resume()
    assert off_after_s(board, since_s) < STATED_S


def lockstep_run(elf: Path, seed: int) -> tuple[list[Sample], np.ndarray]:
    with EmulatedBoard(elf=elf, pace="lockstep", seed=seed) as board:
        host = Host(board)
        host.command(ARM)
        host.command(STREAM, struct.pack("<H", 50))
        for number in range(20):
            host.drive(1.0 + 0.1 * number)
            host.wait_for(0x82, number + 1)
        log = board.log()
        host.close()
        return host.samples(), np.column_stack([log[name] for name in log if name != "clock_s"])


@pytest.mark.emulated
def test_in_lockstep_a_run_is_the_same_again_for_the_same_seed(elf: Path) -> None:
    first, second, other = (lockstep_run(elf, seed) for seed in (3, 3, 4))
    # The target is no number in an open loop; NaN equals nothing.
    assert [sample[:-2] for sample in first[0]] == [sample[:-2] for sample in second[0]]
    assert np.array_equal(first[1], second[1])
    assert [sample.wire_voltage_v for sample in first[0]] != [sample.wire_voltage_v for sample in other[0]]


@pytest.mark.slow
def test_samples_are_what_truly_was_at_the_wire(elf: Path) -> None:
    samples, log = lockstep_run(elf, 3)
    # Columns without the clock: tick, code, powered, output, current, wire voltage, shunt voltage, ...
    wire_v = log[:, 5].reshape(-1, 50).mean(axis=1)
    shunt_v = log[:, 6].reshape(-1, 50).mean(axis=1)
    assert [sample.wire_voltage_v for sample in samples] == pytest.approx(list(wire_v), rel=2e-4)
    assert [sample.shunt_voltage_v for sample in samples] == pytest.approx(list(shunt_v), rel=1e-3)


@pytest.mark.emulated
def test_the_board_closes_the_loop_by_itself(elf: Path) -> None:
    with EmulatedBoard(elf=elf, pace="lockstep") as board:
        host = Host(board)
        host.command(ARM)
        host.command(STREAM, struct.pack("<H", 50))
        for number in range(160):
            host.command(TARGET, struct.pack("<f", 0.015))
            host.wait_for(0x82, number + 1)
        reached = [sample.estimate for sample in host.samples()[-40:]]
        truth = board.log()["strain"][-2000:].mean()
        host.close()
    assert np.mean(reached) == pytest.approx(0.015, abs=0.001)
    # What is true differs from what is estimated by the model's hysteresis gap at most.
    assert truth == pytest.approx(0.015, abs=0.01)


def kept(board: EmulatedBoard, host: Host) -> tuple[set[int], int]:
    """Keep a drive for 0.8 s without another command; return the states seen and how many conversions there were."""
    running(host, 1.0)
    before = board.figures()
    host.frames.clear()
    host.command(STREAM, struct.pack("<H", 1))
    for _ in range(20):
        host.command(KEEP)
        host.listen(0.04)
    host.command(STREAM, struct.pack("<H", 0))
    after = board.figures()
    conversions = after["ticks"] - before["ticks"] - (after["overwritten"] - before["overwritten"])
    return {sample.state for sample in host.samples()}, conversions


@pytest.mark.emulated
def test_a_keep_is_enough_and_a_stream_of_every_tick_loses_no_frame(board: EmulatedBoard, host: Host) -> None:
    for _ in range(TRIES):
        states, conversions = kept(board, host)
        assert set(np.diff([frame.sequence for frame in host.frames])) == {1}
        assert len(host.samples()) > 0.8 * conversions
        if states <= {1, 2}:
            return
    raise AssertionError(f"in {TRIES} tries the drive was never kept")
