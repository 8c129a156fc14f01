"""The ports that a message lists, and the names that people use for boards."""

from __future__ import annotations

from pathlib import Path

import pytest
from serial.tools import list_ports, list_ports_common

from musclewire.errors import RigError
from musclewire.extras.board._serial.line import open_line
from musclewire.extras.board._serial.ports import ports_text, serial_ports
from musclewire.rigs import rig_configuration


def port(name: str, vendor: int | None, product: int | None, description: str = "n/a") -> object:
    made = list_ports_common.ListPortInfo(name)
    made.vid, made.pid, made.description = vendor, product, description
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


@pytest.mark.parametrize("name", ["nano", "uno", "arduino-nano", "arduino-uno"])
def test_rigs_are_known_by_the_names_of_their_boards(name: str) -> None:
    configuration, where = rig_configuration(name)
    assert (configuration.kind, where) == ("serial", "rig arduino-uno")
