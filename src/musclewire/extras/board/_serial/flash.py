"""Put one of our firmware images on a board: find the port, call the board's loader, ask the board who it is."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import tomllib
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from musclewire.errors import CallerError, RigError, nearest_hint
from musclewire.extras.board._serial.board import Board
from musclewire.extras.board._serial.boards import BOARD_NAMES, BOARDS
from musclewire.extras.board._serial.line import open_line
from musclewire.extras.board._serial.messages import BoardIdentity
from musclewire.extras.board._serial.ports import ports_text, serial_ports

FOLDER = Path(str(files("musclewire.extras.board._serial"))) / "data" / "images"


class FirmwareImage(NamedTuple):
    """An image and what is compiled into it: wire, length, shunt and highest drive; ``sha256`` is of its file."""

    board: str
    wire: str
    file: str
    sha256: str
    compiler: str
    wire_length_m: float
    shunt_resistance_ohm: float
    maximum_voltage_v: float

    @property
    def path(self) -> Path:
        """Where the file is."""
        return FOLDER / self.file


def firmware_images() -> list[FirmwareImage]:
    """Return every image of the package, as its manifest lists them."""
    listed = tomllib.loads((FOLDER / "manifest.toml").read_text(encoding="utf-8"))["image"]
    return [FirmwareImage(**table) for table in listed]


def find_image(board: str, wire: str | None) -> FirmwareImage:
    """Return a board's image for a wire. Raises CallerError naming what there is, also where no wire is named."""
    images = firmware_images()
    boards = {image.board for image in images}
    known = BOARD_NAMES.get(board, board)
    if known not in boards:
        named = sorted(name for name, own in BOARD_NAMES.items() if own in boards)
        raise CallerError(
            f"there is no firmware for board '{board}'{nearest_hint(board, named)}; the code for another processor is "
            'a file of C that nobody has written yet (docs/how-to/drive_a_board.md, "Another board"): take one of '
            "these, or write it"
        )
    here = {image.wire: image for image in images if image.board == known}
    if wire is None or wire not in here:
        said = "name the wire that is mounted" if wire is None else f"there is no built firmware for wire {wire}"
        there = "; ".join(
            f"--wire {image.wire} ({1e3 * image.wire_length_m:g} mm, shunt {image.shunt_resistance_ohm:g} ohm, "
            f"at most {image.maximum_voltage_v:g} V)"
            for image in here.values()
        )
        raise CallerError(
            f"{said}, whose limits the firmware keeps: {there}; for another wire or length build your own "
            f"in a checkout: python firmware/build.py --board {known} --wire ... (docs/how-to/drive_a_board.md)"
        )
    return here[wire]


def require_sound(image: FirmwareImage) -> None:
    """Raise CallerError if an image's file is missing or has another checksum than the manifest's."""
    try:
        found = hashlib.sha256(image.path.read_bytes()).hexdigest()
    except OSError as error:
        raise CallerError(f"firmware image {image.path}: {error.strerror or error}; install musclewire again") from None
    if found != image.sha256:
        raise CallerError(
            f"firmware image {image.path} has SHA-256 {found[:12]}... and not the manifest's {image.sha256[:12]}...: "
            "it is damaged or changed, install musclewire again"
        )


BAUD = 115200  # of an Uno's boot loader
OLD_BAUD = 57600  # of that of Nanos made before 2018
FLASH_START = "0x08000000"
# Writing and reading back 32 kB takes 15 s at 57600 baud.
LOADER_S = 180.0
INSTALL = {
    "avrdude": "Debian: apt-get install avrdude; macOS: brew install avrdude; Windows: winget install AVRDudes.AVRDUDE",
    "dfu-util": "Debian: apt-get install dfu-util; macOS: brew install dfu-util; Windows: the archive of "
    "dfu-util.sourceforge.net",
}


class FlashLoader(NamedTuple):
    """The program that writes a board's flash, and its command."""

    program: str
    command: tuple[str, ...]


def find_port(board: str) -> str:
    """Return the one port whose USB numbers are the board's. Raises RigError listing the ports for none or several."""
    ports = serial_ports()
    fitting = [port for port in ports if port.board == board]
    if len(fitting) == 1:
        return fitting[0].name
    found = f"{len(fitting)} ports look like" if fitting else "no port looks like"
    raise RigError(f"{found} an {board}: name one by --serial-port; {ports_text(ports)}")


def loader_for(image: FirmwareImage, port: str, old_bootloader: bool = False) -> FlashLoader:
    """Return the loader of an image's board and its command. Raises CallerError for an option of another board."""
    if image.board == "arduino-uno":
        # avrdude's name of what pyserial calls a socket, by which an emulated board is reached.
        place = port.replace("socket://", "net:")
        baud = str(OLD_BAUD if old_bootloader else BAUD)
        write = f"flash:w:{image.path}:i"
        command: tuple[str, ...] = (
            "avrdude",
            "-p",
            "m328p",
            "-c",
            "arduino",
            "-P",
            place,
            "-b",
            baud,
            "-D",
            "-U",
            write,
        )
        return FlashLoader("avrdude", command)
    if old_bootloader:
        raise CallerError(f"--old-bootloader is for a Nano; {image.board} has one boot loader: leave it out")
    command = ("dfu-util", "-a", "0", "-s", f"{FLASH_START}:leave", "-D", str(image.path))
    return FlashLoader("dfu-util", command)


def run_loader(loader: FlashLoader, old_bootloader: bool = False) -> str:
    """Run a loader and return what it said. Raises RigError if it is missing, fails or does not end."""
    if shutil.which(loader.program) is None:
        raise RigError(f"{loader.program}, which writes the board's flash, is missing: {INSTALL[loader.program]}")
    try:
        done = subprocess.run(loader.command, capture_output=True, text=True, check=False, timeout=LOADER_S)
    except subprocess.TimeoutExpired:
        raise RigError(f"{loader.program} did not end within {LOADER_S:g} s: unplug the board and try again") from None
    if done.returncode != 0:
        raise RigError(f"{loader.program} failed: {last_words(done.stderr)}; {advice(loader, old_bootloader)}")
    return done.stderr + done.stdout


def last_words(text: str) -> str:
    """Return the last line of a program's messages that says something in addition to thanks."""
    lines = [line.strip() for line in text.splitlines() if line.strip() and "done.  Thank you" not in line]
    return lines[-1] if lines else "it said nothing"


def advice(loader: FlashLoader, old_bootloader: bool) -> str:
    """Return what to try when a loader has failed."""
    if loader.program == "dfu-util":
        return "hold BOOT0, press and release NRST, release BOOT0, and try again"
    if old_bootloader:
        return "is it the right port, and does no other program hold it? without --old-bootloader it speaks 115200 baud"
    return "is it the right port, and does no other program hold it? A Nano of before 2018 needs --old-bootloader"


def greet(image: FirmwareImage, port: str) -> BoardIdentity:
    """Return what the flashed board says it is. Raises RigError if it is silent or another board or circuit."""
    board = Board(open_line(port, BOARDS[image.board]["baud"]))
    try:
        identity = board.hello()
    finally:
        board.close()
    reported = (
        identity.board,
        identity.wire,
        round(identity.maximum_voltage_v, 4),
        round(identity.shunt_resistance_ohm, 4),
    )
    wanted = (image.board, image.wire, image.maximum_voltage_v, image.shunt_resistance_ohm)
    if reported != wanted:
        raise RigError(f"the board says that it is {reported}, and the image is {wanted}: flash it again")
    return identity


def shown(command: Sequence[str]) -> str:
    """Return a command as a shell takes it."""
    import shlex

    return shlex.join(command)
