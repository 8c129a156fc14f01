"""The command that writes the program of a board with MicroPython, for one wire in one circuit: export micropython."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from musclewire.app import RIG, AnswerModel, Result, own_help
from musclewire.extras.board._c.loops import FILTER, INVERSE_MODEL
from musclewire.extras.board._options import CIRCUIT, CONTROLLER_IN_C, ESTIMATOR_IN_C


class ExportMicropythonAnswer(AnswerModel):
    """Of ``export micropython``; without a model the host closes the loop, and quantity and names are null."""

    folder: str
    board: str
    wire: str
    files: tuple[str, ...]
    size_bytes: int
    quantity: str | None
    estimator: str | None
    controller: str | None
    lowest_drive_v: float
    maximum_voltage_v: float


def export_micropython(
    output: Annotated[Path, own_help("--output", "Folder for the program, made if need be.")],
    model: Annotated[
        Path | None, typer.Argument(help="Model that the board's own loop goes by; without one the host closes it.")
    ] = None,
    rig: Annotated[str, RIG] = "pico",
    board: Annotated[str, CIRCUIT] = "pico",
    estimator: Annotated[str, ESTIMATOR_IN_C] = FILTER,
    controller: Annotated[str, CONTROLLER_IN_C] = INVERSE_MODEL,
) -> Result:
    """The program of a board with MicroPython, for one wire in one circuit: copy its files to the board."""
    from musclewire.extras.board._micropython.program import program_of, write_program

    written = program_of(board, rig, model, (estimator, controller))
    write_program(written.texts, output)
    loop = written.loop
    answer = ExportMicropythonAnswer(
        folder=str(output),
        board=written.circuit.board,
        wire=written.wire,
        files=tuple(written.texts),
        size_bytes=sum(len(text.encode()) for text in written.texts.values()),
        quantity=None if loop is None else loop.model.quantity,
        estimator=None if loop is None else estimator,
        controller=None if loop is None else controller,
        lowest_drive_v=written.circuit.lowest_drive_v,
        maximum_voltage_v=written.limits.maximum_voltage_v,
    )
    closes = f"{answer.quantity} by {estimator} and {controller}" if loop else "the host closes the loop"
    text = (
        f"{output}: {len(answer.files)} files, {answer.size_bytes / 1024:.0f} kB, {answer.wire} on {answer.board}; "
        f"{closes}; at most {answer.maximum_voltage_v:g} V, and {answer.lowest_drive_v:.2f} V while it is read"
    )
    if loop is None:
        text += "\nwith a model it moves the wire by itself: name it before the options"
    return Result(answer, text)
