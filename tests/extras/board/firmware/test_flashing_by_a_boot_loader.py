"""`musclewire flash` for real: avrdude, the boot loader of an Arduino in simavr, our image, the board's own answer.

An emulated board has no DTR line: its bench pulls the reset pin when a host opens the port, as a USB converter does.
"""

from __future__ import annotations

import json

import pytest
from emulation.board import EmulatedBoard
from emulation.boot_loaders import FOLDER
from tests.tools import require_tool

from musclewire.app import run
from musclewire.extras.board._serial.flash import find_image, greet


@pytest.mark.parametrize(
    ("board", "boot_loader", "options"),
    [
        pytest.param("uno", "optiboot", (), marks=pytest.mark.emulated),
        pytest.param("nano", "atmegaboot", ("--old-bootloader",), marks=pytest.mark.full),
    ],
)
def test_a_boot_loader_writes_the_image_and_the_board_answers(
    board: str, boot_loader: str, options: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    require_tool("avrdude", "avrdude")
    require_tool("avr-gcc", "gcc-avr avr-libc")
    if not FOLDER.is_dir():
        require_tool("arduino-core-avr", "arduino-core-avr")  # says that it is not run, or fails in CI
    wire = "flexinol-0.10-lt"
    with EmulatedBoard(wire, board="arduino-uno", boot_loader=boot_loader) as emulated:
        code = run(["flash", board, "--wire", wire, "--serial-port", emulated.port_url, *options, "--json"])
        said = json.loads(capsys.readouterr().out)
        assert code == 0, said
        # Whoever opens the port resets the board again: the loader runs first, then what it has written.
        identity = greet(find_image(board, wire), emulated.port_url)
    assert identity.board == "arduino-uno"
    assert identity.maximum_voltage_v == pytest.approx(find_image(board, wire).maximum_voltage_v)
