"""The images that ship: built again they have the same bytes, and they run as they are in simavr and QEMU."""

from __future__ import annotations

from pathlib import Path

import pytest
from emulation.board import EmulatedBoard, rig_file_text
from firmware.prebuilt import compiler_of, image_of
from tests.extras.board.firmware.conftest import HELLO, IDENTITY
from tests.extras.board.firmware.test_the_small_cortex import said_by
from tests.tools import require_tool

from musclewire.experiment import characterize
from musclewire.extras.board import SerialFrame
from musclewire.extras.board._serial import flash
from musclewire.extras.board._serial.flash import FirmwareImage, find_image, firmware_images
from musclewire.rigs import open_rig

WIRES = [
    pytest.param("paper-100um", marks=pytest.mark.emulated),
    pytest.param("flexinol-0.10-lt", marks=pytest.mark.full),
]


@pytest.mark.emulated
@pytest.mark.parametrize("image", firmware_images(), ids=lambda image: image.file)
def test_the_same_compiler_gives_the_same_bytes(image: FirmwareImage, tmp_path: Path) -> None:
    require_tool("avr-gcc", "gcc-avr avr-libc")
    require_tool("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi")
    assert compiler_of(image.board) == image.compiler, "build with the compiler that the manifest names"
    assert image_of(image.board, image.wire, tmp_path).read_bytes() == image.path.read_bytes()


@pytest.mark.parametrize("wire", WIRES)
def test_the_hex_file_runs_greets_and_characterizes_the_wire(wire: str, tmp_path: Path) -> None:
    require_tool("simavr", "simavr libsimavr-dev libelf-dev gcc libc6-dev")
    image = find_image("uno", wire)
    with EmulatedBoard(wire, board="arduino-uno", elf=image.path, settings={"pretension_n": 1.3}) as board:
        assert flash.greet(image, board.port_url).board == "arduino-uno"
        text = rig_file_text("arduino-uno", wire, board.port_url)
        limits = f'maximum_voltage = "{image.maximum_voltage_v:g} V"'
        (tmp_path / "board.toml").write_text(text.replace('maximum_voltage = "3.6 V"', limits), "utf-8")
        with open_rig(tmp_path / "board.toml", wire_temperature_k=295.15) as rig:
            loop = characterize(rig, cycles=1, period_s=20.0)
    # Eq. 1, where the drive is above the half of its amplitude and the converter's steps are small.
    hot = loop["shunt_voltage_v"] > 0.5 * loop["shunt_voltage_v"].max()
    ohm = (loop["wire_voltage_v"] / loop["shunt_voltage_v"] * image.shunt_resistance_ohm)[hot]
    assert 14.0 < ohm.min() < 0.95 * ohm.max() < 18.0


@pytest.mark.parametrize("wire", WIRES)
def test_the_binary_file_starts_and_says_who_it_is(wire: str) -> None:
    require_tool("qemu-system-arm", "qemu-system-arm")
    frames = said_by(find_image("stm32f411", wire).path, [SerialFrame(HELLO, 1, b"")], IDENTITY, 2)
    assert all(frame.payload[31:47].rstrip(b"\0") == b"stm32f411" for frame in frames if frame.kind == IDENTITY)
