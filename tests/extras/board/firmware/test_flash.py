"""`musclewire flash` up to the loader: the images are what the manifest says, the board's port and loader are found."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest
from tests.command_line import CommandLine

from musclewire.errors import CallerError, RigError
from musclewire.extras.board import FOLDER
from musclewire.extras.board._serial import flash
from musclewire.extras.board._serial.flash import find_image, firmware_images, require_sound
from musclewire.extras.board._serial.ports import SerialPort

UNO = SerialPort("/dev/ttyACM0", "arduino-uno", "Arduino Uno")
OTHER = SerialPort("/dev/ttyS0", "", "")


def test_every_image_is_listed_and_has_its_checksum() -> None:
    for image in firmware_images():
        require_sound(image)
    assert {image.file for image in firmware_images()} == {file.name for file in FOLDER.iterdir()} - {"manifest.toml"}


def hex_bytes(text: str) -> bytes:
    """Return the data of an Intel HEX file (Intel 1988), each record's own checksum kept to."""
    data = b""
    for line in text.split():
        record = bytes.fromhex(line.removeprefix(":"))
        assert sum(record) % 256 == 0
        if record[3] == 0:
            assert int.from_bytes(record[1:3], "big") == len(data)
            data += record[4 : 4 + record[0]]
    return data


@pytest.mark.parametrize("wire", ["paper-100um", "flexinol-0.10-lt"])
def test_an_image_leaves_the_boot_loader_its_place(wire: str) -> None:
    # Old Nanos have the largest boot loader, of 2 kB at the end of 32 kB.
    assert len(hex_bytes(find_image("nano", wire).path.read_text("ascii"))) <= 30 * 1024


def test_a_changed_image_is_not_flashed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    image = find_image("uno", "paper-100um")
    (tmp_path / image.file).write_bytes(image.path.read_bytes()[:-1])
    monkeypatch.setattr(flash, "FOLDER", tmp_path)
    with pytest.raises(CallerError, match="damaged or changed"):
        require_sound(image)


def test_no_wire_and_a_wrong_wire_list_what_there_is() -> None:
    with pytest.raises(
        CallerError, match=r"name the wire that is mounted.*--wire flexinol-0.10-lt \(140 mm, .*3.515 V\)"
    ):
        find_image("nano", None)
    with pytest.raises(CallerError, match=r"no built firmware for wire paper-200um.*build your own"):
        find_image("nano", "paper-200um")
    with pytest.raises(CallerError, match=r"did you mean 'nano'"):
        find_image("nanno", None)


def test_the_one_port_that_looks_like_the_board_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flash, "serial_ports", lambda: [UNO, OTHER])
    assert flash.find_port("arduino-uno") == "/dev/ttyACM0"
    monkeypatch.setattr(flash, "serial_ports", lambda: [OTHER])
    with pytest.raises(RigError, match=r"no port looks like an arduino-uno.*--serial-port; ports here now: /dev/ttyS0"):
        flash.find_port("arduino-uno")
    monkeypatch.setattr(flash, "serial_ports", lambda: [UNO, UNO])
    with pytest.raises(RigError, match="2 ports look like"):
        flash.find_port("arduino-uno")


@pytest.mark.parametrize(("old", "baud"), [((), "115200"), (("--old-bootloader",), "57600")])
def test_a_dry_run_shows_the_command(old: tuple[str, ...], baud: str, musclewire: CommandLine) -> None:
    given = ["flash", "nano", "--wire", "paper-100um", "--serial-port", "/dev/ttyACM0", *old, "--dry-run", "--json"]
    command = musclewire(*given).json["command"]
    assert command[:9] == ["avrdude", "-p", "m328p", "-c", "arduino", "-P", "/dev/ttyACM0", "-b", baud]
    assert command[-1].endswith("arduino-uno_paper-100um.hex:i")


def test_a_missing_loader_is_named_with_its_installation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flash.shutil, "which", lambda _: None)
    for board, program in (("uno", "avrdude"), ("stm32f411", "dfu-util")):
        loader = flash.loader_for(find_image(board, "paper-100um"), "PORT")
        with pytest.raises(RigError, match=f"{program}, which writes .*apt-get install {program}; macOS: .*Windows: "):
            flash.run_loader(loader)


def test_what_a_loader_says_is_in_the_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any, **__: Any) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess([], 1, "", "avrdude: not in sync\n\navrdude done.  Thank you.\n")

    monkeypatch.setattr(flash.shutil, "which", lambda program: program)
    monkeypatch.setattr(flash.subprocess, "run", fails)
    loader = flash.loader_for(find_image("uno", "paper-100um"), "/dev/ttyACM0")
    with pytest.raises(RigError, match=r"avrdude failed: avrdude: not in sync; .*needs --old-bootloader"):
        flash.run_loader(loader)
