"""The serial rigs of the contract suite: the real firmware in an emulator, the simulated wire on its pins.

In lockstep: time passes only for commands, so that a busy machine changes nothing.
"""

from __future__ import annotations

import tempfile
import weakref
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from emulation.board import EmulatedBoard, firmware_for
from tests.contract.rig_subject import PAPERS_WIRE_OHM, Opened, RigSubject
from tests.extras.board.micropython.interpreters import require_interpreter
from tests.tools import require_tool

from musclewire.extras.board import SerialConfiguration
from musclewire.rigs import GuardedRig, open_rig, rig_configuration

__all__ = ["COLD_K", "SERIAL_RIGS", "SUBJECTS", "built_firmware", "mounted", "on_board", "unwatched"]

BOARD, PICO = "mps2-an386", "pico"
# A busy machine may take long over a sample; the board's own clock stands still meanwhile.
PATIENCE_S = 10.0
# The wire of a board that has just been switched on [K].
COLD_K = 295.15


def require_board(board: str = BOARD) -> None:
    """Skip the test, or fail it in CI, where the compiler, the emulator or the interpreter is missing."""
    if board == PICO:
        require_interpreter()
        return
    require_tool("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi")
    require_tool("qemu-system-arm", "qemu-system-arm")


@cache
def built_firmware(fault_injection: bool = False, board: str = BOARD) -> Path:
    """Return the firmware, built once for all tests of a run."""
    folder = tempfile.TemporaryDirectory(prefix="musclewire-firmware-")
    built_firmware.folders.append(folder)  # type: ignore[attr-defined]
    return firmware_for(board, Path(folder.name), ["--fault-injection"] if fault_injection else [])


built_firmware.folders = []  # type: ignore[attr-defined]


def mounted(port: str, rig: str = "serial-board", **changed: Any) -> SerialConfiguration:
    """Return a rig file that comes with musclewire, on a port, with some keys changed."""
    shipped = rig_configuration(rig)[0]
    assert isinstance(shipped, SerialConfiguration)
    return SerialConfiguration.model_validate({**shipped.model_dump(), "port": port, **changed})


def on_board(**changed: Any) -> GuardedRig:
    """Return a rig on a board of its own that has just been switched on, its wire cold; the board ends with it."""
    return rig_and_board(**changed)[0]


def on_pico(**changed: Any) -> GuardedRig:
    """Return such a rig on a board with MicroPython."""
    return rig_and_board(PICO, **changed)[0]


def for_a_test(name: str) -> Opened:
    """Return what opens such a rig, whose board ends with the test and not with its last reference."""

    def opened(request: pytest.FixtureRequest, _folder: Path) -> GuardedRig:
        rig, board = rig_and_board(name)
        request.addfinalizer(board.close)
        request.addfinalizer(rig.close)
        return rig

    return opened


def rig_and_board(name: str = BOARD, **changed: Any) -> tuple[GuardedRig, EmulatedBoard]:
    """Return a rig and its board, which ends with the rig at the latest."""
    require_board(name)
    board = EmulatedBoard(pace="lockstep", board=name, elf=built_firmware(board=name))
    try:
        file = PICO if name == PICO else "serial-board"
        on_port = mounted(board.port_url, file, patience=PATIENCE_S, lockstep=True, **changed)
        rig = open_rig(on_port, wire_temperature_k=COLD_K)
    except BaseException:
        board.close()
        raise
    weakref.finalize(rig, board.close)
    return rig, board


def unwatched(rig: GuardedRig) -> None:
    """Let nothing look for how long nobody talks to a rig by the clock, for its time is another one."""
    assert rig._watch is not None
    rig._watch.end()


SERIAL_RIGS: dict[str, Callable[[], GuardedRig]] = {
    "serial, emulated Cortex-M4F": on_board,
    "serial, emulated Pico": on_pico,
}
SUBJECTS = tuple(
    RigSubject(name, for_a_test(board), PAPERS_WIRE_OHM, emulated=True, by_the_clock=False)
    for name, board in zip(SERIAL_RIGS, (BOARD, PICO), strict=True)
)
