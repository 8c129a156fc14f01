"""The serial ports of this computer, for messages and for finding a board."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.errors import MissingExtraError
from musclewire.extras.board._serial.boards import USB_DEVICES


class SerialPort(NamedTuple):
    """A serial port: its name, the board that its USB numbers belong to ("" if unknown), and what it says it is."""

    name: str
    board: str
    description: str


def serial_ports() -> list[SerialPort]:
    """Return the serial ports that exist now. Raises MissingExtraError without pyserial."""
    try:
        from serial.tools import list_ports
    except ImportError:
        raise MissingExtraError("a board on a serial line", "serial") from None
    found = []
    for port in sorted(list_ports.comports(), key=lambda port: str(port.device)):
        board, name = USB_DEVICES.get((port.vid, port.pid), ("", ""))
        said = "" if port.description in (None, "n/a") else str(port.description)
        found.append(SerialPort(str(port.device), board, name or said))
    return found


def ports_text(ports: list[SerialPort]) -> str:
    """Return the ports that exist as the end of a message."""
    if not ports:
        return "no serial port exists here now: is the cable one for data, and the board powered?"
    listed = (f"{port.name} ({port.description})" if port.description else port.name for port in ports)
    return f"ports here now: {', '.join(listed)}"
