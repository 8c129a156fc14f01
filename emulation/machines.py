"""The emulators that run a board's firmware, and how they are connected to the bench."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path

from emulation.interpreter import interpreter
from musclewire.errors import CallerError
from musclewire.extras.board import circuit_names

__all__ = ["prepared", "start_machine"]

FOLDER = Path(__file__).resolve().parent


# In lockstep QEMU's clock counts instructions (32 ns each): a machine that lets the emulator wait for half a second, as
# busy ones do, must not look like a hung firmware to the board's watchdog.
BY_INSTRUCTIONS = ("-icount", "shift=5")


def start_machine(
    board: str, elf: str, host_port: int, wire_port: int, log: Path, *, lockstep: bool = False
) -> subprocess.Popen[bytes]:
    """Start the emulator of a board; it connects to two ports of this machine; its standard input is its monitor."""
    command = COMMANDS[board](elf, host_port, wire_port)
    if lockstep and command[0].startswith("qemu"):
        command += BY_INSTRUCTIONS
    with log.open("ab") as messages:
        return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=messages, stderr=messages)


def prepared(board: str, elf: Path, folder: Path) -> Path:
    """Return the firmware at the path that its emulator requires; for simavr the runner is compiled next to it.

    Raises CallerError if a compiler or a library is missing.
    """
    if board not in ("mps2-an386", "arduino-uno"):
        interpreter()
        return elf  # the folder of its program
    emulator = {"mps2-an386": "qemu-system-arm", "arduino-uno": "gcc"}[board]
    packages = {"mps2-an386": "qemu-system-arm", "arduino-uno": "gcc libc6-dev libsimavr-dev libelf-dev"}[board]
    found = shutil.which(emulator)
    if found is None:
        raise CallerError(f"{emulator} is missing: apt-get install --no-install-recommends -y {packages}")
    if board == "mps2-an386":
        return elf
    placed = folder / elf.name
    if elf.suffix == ".hex":
        placed.write_text(without_start_addresses(elf.read_text("ascii")), "ascii")
    elif placed != elf:
        shutil.copy(elf, placed)
    command = [found, "-O2", str(FOLDER / "simavr_board.c"), "-o", str(folder / "simavr_board"), "-lsimavr", "-lelf"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        line = f"apt-get install --no-install-recommends -y {packages}"
        raise CallerError(f"emulation/simavr_board.c does not compile ({line}):\n{done.stderr.strip()}")
    return placed


def without_start_addresses(text: str) -> str:
    """Return an Intel HEX file without its records 03 and 05, which an AVR has no use for and simavr refuses."""
    return "".join(line for line in text.splitlines(keepends=True) if line[7:9] not in ("03", "05"))


def qemu(elf: str, host_port: int, wire_port: int) -> list[str]:
    """Return the command of QEMU's MPS2 board with AN386: UART0 the host's line, UART1 converter and output."""
    sockets = [
        f"socket,id=host,host=127.0.0.1,port={host_port},nodelay=on",
        f"socket,id=wire,host=127.0.0.1,port={wire_port},nodelay=on",
    ]
    return [
        *("qemu-system-arm", "-M", "mps2-an386", "-display", "none", "-monitor", "stdio", "-net", "none"),
        *("-chardev", sockets[0], "-chardev", sockets[1], "-serial", "chardev:host", "-serial", "chardev:wire"),
        *("-kernel", elf),
    ]


def simavr(elf: str, host_port: int, wire_port: int) -> list[str]:
    """Return the command of the ATmega328P in simavr, run by the small program next to this file."""
    return [str(Path(elf).with_name("simavr_board")), elf, str(host_port), str(wire_port)]


def node(folder: str, host_port: int, wire_port: int) -> list[str]:
    """Return the command of the MicroPython interpreter with a board's files and the numbers of its circuit."""
    found, program = interpreter(), str(FOLDER / "micropython" / "board.mjs")
    return [str(found.node), program, str(found.folder), folder, str(host_port), str(wire_port)]


COMMANDS: Mapping[str, Callable[[str, int, int], list[str]]] = {
    "mps2-an386": qemu,
    "arduino-uno": simavr,
    **dict.fromkeys(circuit_names(), node),
}
