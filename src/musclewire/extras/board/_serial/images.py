"""The firmware images that ship with musclewire: one for each board and wire, whose limits are compiled in."""

from __future__ import annotations

import hashlib
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from musclewire.errors import CallerError, nearest_hint
from musclewire.extras.board._serial.boards import BOARD_NAMES

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
        raise CallerError(f"there is no firmware for board '{board}'{nearest_hint(board, named)}")
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
            "(docs/how-to/flash_the_firmware.md)"
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
