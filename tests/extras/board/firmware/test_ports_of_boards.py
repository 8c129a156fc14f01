"""The ports that a message lists, and the names that people use for boards."""

from __future__ import annotations

from pathlib import Path

import pytest
from serial.tools import list_ports, list_ports_common

from musclewire.errors import RigError
from musclewire.extras.board import open_line
from musclewire.extras.board._serial.ports import identity_of, ports_text, serial_ports
from musclewire.rigs import rig_configuration


def port(
    name: str, vendor: int | None, product: int | None, description: str = "n/a", number: str | None = None
) -> object:
    made = list_ports_common.ListPortInfo(name)
    made.vid, made.pid, made.description, made.serial_number = vendor, product, description, number
    return made


@pytest.fixture
def ports(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    found: list[object] = []
    monkeypatch.setattr(list_ports, "comports", lambda: found)
    return found


def test_ports_are_named_by_their_usb_numbers(ports: list[object]) -> None:
    ports += [
        port("/dev/ttyUSB3", 0x1A86, 0x7523),
        port("/dev/ttyACM0", 0x2341, 0x0043),
        port("/dev/ttyS0", None, None),
    ]
    found = serial_ports()
    assert [(one.name, one.board) for one in found] == [
        ("/dev/ttyACM0", "arduino-uno"),
        ("/dev/ttyS0", ""),
        ("/dev/ttyUSB3", "arduino-uno"),
    ]
    text = ports_text(found)
    assert text.startswith("ports here now: /dev/ttyACM0 (Arduino Uno), /dev/ttyS0, /dev/ttyUSB3 (CH340")


def test_a_port_that_is_missing_lists_those_that_are_there(ports: list[object], tmp_path: Path) -> None:
    ports.append(port("/dev/ttyACM7", 0x2341, 0x0043))
    with pytest.raises(RigError, match=r"ports here now: /dev/ttyACM7 \(Arduino Uno\)"):
        open_line(str(tmp_path / "nothing"), 115200)
    ports.clear()
    with pytest.raises(RigError, match="no serial port exists here now"):
        open_line(str(tmp_path / "nothing"), 115200)


def test_a_board_is_known_by_its_serial_number_at_whichever_port_and_by_whichever_name(
    ports: list[object], tmp_path: Path
) -> None:
    ports += [
        port("/dev/ttyACM0", 0x2341, 0x0043, number="8573F0"),
        port("/dev/ttyACM1", 0x2341, 0x0043, number="8573F1"),
    ]
    assert identity_of("/dev/ttyACM0") == "USB 2341:0043 8573F0"
    link = tmp_path / "by-id"
    link.symlink_to("/dev/ttyACM0")
    assert identity_of(str(link)) == "USB 2341:0043 8573F0"
    ports[:] = [port("/dev/ttyACM7", 0x2341, 0x0043, number="8573F0")]
    assert identity_of("/dev/ttyACM7") == "USB 2341:0043 8573F0"


def test_a_board_without_a_number_of_its_own_is_known_by_its_port(ports: list[object], tmp_path: Path) -> None:
    ports += [
        port("/dev/ttyUSB0", 0x10C4, 0xEA60, number="0001"),
        port("/dev/ttyUSB1", 0x10C4, 0xEA60, number="0001"),
        port("/dev/ttyUSB2", 0x1A86, 0x7523),
        port("/dev/ttyUSB3", 0x1A86, 0x7523, number=""),
        port("/dev/ttyS0", None, None),
    ]
    for name in ("/dev/ttyUSB0", "/dev/ttyUSB1", "/dev/ttyUSB2", "/dev/ttyUSB3", "/dev/ttyS0", "/dev/pts/7"):
        assert identity_of(name) == name
    link = tmp_path / "wire"
    link.symlink_to("/dev/ttyUSB2")
    assert identity_of(str(link)) == "/dev/ttyUSB2"
    for url in ("socket://127.0.0.1:4000", "loop://", "rfc2217://board.local:4000"):
        assert identity_of(url) == url


@pytest.mark.parametrize("name", ["nano", "uno", "arduino-nano", "arduino-uno"])
def test_rigs_are_known_by_the_names_of_their_boards(name: str) -> None:
    configuration, where = rig_configuration(name)
    assert (configuration.kind, where) == ("serial", "rig arduino-uno")
