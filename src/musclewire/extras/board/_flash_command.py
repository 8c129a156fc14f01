"""The command that puts the firmware on a board, without a compiler and without a checkout: flash."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app import AnswerModel, Result, tell
from musclewire.extras.board._options import DRY_RUN, MOUNTED_WIRE, OLD_BOOTLOADER, SERIAL_PORT

if TYPE_CHECKING:
    from musclewire.extras.board._serial.flash import FirmwareImage

# What stands for the port in a command that is only shown.
NO_PORT = "PORT"


class GreetedBoard(AnswerModel):
    """What the flashed board says it is."""

    board: str
    firmware: str
    started_by: str


class FlashAnswer(AnswerModel):
    """Of ``flash``: the image, how it was written, and who answered."""

    board: str
    wire: str
    file: str
    sha256: str
    wire_length_m: float
    shunt_resistance_ohm: float
    maximum_voltage_v: float
    serial_port: str | None
    command: tuple[str, ...]
    answered: GreetedBoard | None


def flash(
    board: Annotated[str, typer.Argument(help="Board: 'uno', 'nano' (both are 'arduino-uno'), 'stm32f411'.")],
    wire: Annotated[str | None, MOUNTED_WIRE] = None,
    serial_port: Annotated[str | None, SERIAL_PORT] = None,
    old_bootloader: Annotated[bool, OLD_BOOTLOADER] = False,
    dry_run: Annotated[bool, DRY_RUN] = False,
) -> Result:
    """Put the built firmware for a wire on a board, and ask the board whether it runs."""
    from musclewire.extras.board._serial.flash import find_image, loader_for, require_sound, run_loader

    image = find_image(board, wire)
    require_sound(image)
    port = chosen_port(image, serial_port, dry_run)
    loader = loader_for(image, port, old_bootloader)
    greeted = None
    if not dry_run:
        limits = f"shunt {image.shunt_resistance_ohm:g} ohm, at most {image.maximum_voltage_v:g} V"
        tell(f"{image.file}: wire {image.wire} of {1e3 * image.wire_length_m:g} mm, {limits}")
        run_loader(loader, old_bootloader)
        greeted = who(image, port) if port else None
    answer = FlashAnswer.read_from(image, serial_port=port or None, command=loader.command, answered=greeted)
    return Result(answer, text(answer, dry_run))


def chosen_port(image: FirmwareImage, given: str | None, dry_run: bool) -> str:
    """Return the board's port: as given, the one that looks like it, or "" for a board that is flashed without."""
    from musclewire.errors import RigError
    from musclewire.extras.board._serial.flash import find_port

    if given is not None or image.board != "arduino-uno":
        return given or ""
    try:
        return find_port(image.board)
    except RigError:
        if dry_run:
            return NO_PORT
        raise


def who(image: FirmwareImage, port: str) -> GreetedBoard:
    """Return what the flashed board says it is. Raises RigError if it is silent or another."""
    from musclewire.extras.board._serial.flash import greet

    identity = greet(image, port)
    return GreetedBoard(board=identity.board, firmware=identity.firmware_version, started_by=identity.reset_by)


def text(answer: FlashAnswer, dry_run: bool) -> str:
    """Return what was done for people; of a dry run the command alone."""
    from musclewire.extras.board._serial.flash import shown

    if dry_run:
        return shown(answer.command)
    if answer.answered is None:
        return "written; not asked who it is: give the port of its serial line by --serial-port for that"
    return f"written; {answer.serial_port} answers: {answer.answered.board}, firmware {answer.answered.firmware}"
