"""The serial ports of this computer and the programs that hold them, for messages and for finding a board."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from musclewire.extras.board._serial.boards import USB_DEVICES


class SerialPort(NamedTuple):
    """A serial port: its name, the board that its USB numbers belong to ("" if unknown), and what it says it is."""

    name: str
    board: str
    description: str


def ports_as_listed() -> list[Any]:
    """Return pyserial's list of the ports that exist now."""
    from serial.tools import list_ports

    return list(list_ports.comports())


def serial_ports() -> list[SerialPort]:
    """Return the serial ports that exist now."""
    found = []
    for port in sorted(ports_as_listed(), key=lambda port: str(port.device)):
        board, name = USB_DEVICES.get((port.vid, port.pid), ("", ""))
        said = "" if port.description in (None, "n/a") else str(port.description)
        found.append(SerialPort(str(port.device), board, name or said))
    return found


def identity_of(port: str) -> str:
    """Return a board's USB serial number, by which it is known again, or its port if two ports have the same number."""
    if "://" in port:
        return port
    place = os.path.normcase(port if os.name == "nt" else os.path.realpath(port))
    numbers = {
        os.path.normcase(str(found.device)): (found.vid, found.pid, found.serial_number)
        for found in ports_as_listed()
        if found.serial_number and found.vid is not None
    }
    number = numbers.get(place)
    if number is None or list(numbers.values()).count(number) > 1:
        return place
    vendor, product, serial_number = number
    return f"USB {vendor:04x}:{product:04x} {serial_number}"


def ports_text(ports: list[SerialPort]) -> str:
    """Return the ports that exist as the end of a message."""
    if not ports:
        return "no serial port exists here now: is the cable one for data, and the board powered?"
    listed = (f"{port.name} ({port.description})" if port.description else port.name for port in ports)
    return f"ports here now: {', '.join(listed)}"


# Linux shows its processes here; other systems have no such folder, or no ``locks`` in it.
PROCESSES = Path("/proc")
# So much of a command line says which program it is.
MAX_PROGRAM = 80


class PortHolder(NamedTuple):
    """A program that has a port open: its process, and its command line ("" if the system keeps it to itself)."""

    process_id: int
    program: str


def holder_of(port: str) -> PortHolder | None:
    """Return the program that locks a local port, or of one's own that has it open; None if the system shows none."""
    try:
        node = Path(port).stat()
        processes = [*locking_processes(node, lines_of(PROCESSES / "locks")), *opening_processes(node)]
    except OSError:
        return None
    return next((PortHolder(process, program_of(process)) for process in processes), None)


def lines_of(path: Path) -> list[str]:
    """Return the lines of a file of the system, none if it cannot be read."""
    with suppress(OSError):
        return path.read_text("utf-8", "replace").splitlines()
    return []


def locking_processes(node: os.stat_result, locks: Iterable[str]) -> Iterator[int]:
    """Yield the processes that lock a file, by lines as ``7: FLOCK ADVISORY WRITE 1234 00:1a:3 0 EOF``."""
    file = f"{os.major(node.st_dev):02x}:{os.minor(node.st_dev):02x}:{node.st_ino}"
    for line in locks:
        words = line.split()
        # A line with an arrow is of a process that waits; 0 is a process that this container does not see.
        if len(words) > 5 and words[1] == "FLOCK" and words[5] == file and words[4].isdecimal() and int(words[4]):
            yield int(words[4])


def opening_processes(node: os.stat_result) -> Iterator[int]:
    """Yield the processes, other than this one, that have a file open and let it be seen."""
    for folder in PROCESSES.glob("[0-9]*"):
        if folder.name == str(os.getpid()):
            continue
        with suppress(OSError):
            for link in (folder / "fd").iterdir():
                with suppress(OSError):
                    if os.path.samestat(link.stat(), node):
                        yield int(folder.name)


def program_of(process: int) -> str:
    """Return a process's command line as text that a terminal can show, "" if the system keeps it to itself."""
    words = " ".join(lines_of(PROCESSES / str(process) / "cmdline")).replace("\0", " ").split()
    if words:
        words[0] = Path(words[0]).name
    said = "".join(letter if letter.isprintable() else "?" for letter in " ".join(words))
    return said if len(said) <= MAX_PROGRAM else f"{said[: MAX_PROGRAM - 3]}..."
