"""The command that finishes the recording of a run that was cut off: recover."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from musclewire.app._answer import AnswerModel
from musclewire.app._figure_options import FigureOptions
from musclewire.app._options import OVERWRITE, own_help
from musclewire.app._output import Result


class RecoverAnswer(AnswerModel):
    """Of ``recover``."""

    recording: str
    rows: int
    duration_s: float | None
    ended: str


def recover(
    recording: Annotated[
        Path, typer.Argument(metavar="RECORDING", help="The recording as it was to be, or its journal (.h5.journal).")
    ],
    figure: FigureOptions,
    output: Annotated[
        Path | None, own_help("--output", "Another recording to write (.h5, .csv, .parquet); the journal stays.")
    ] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Make plain HDF5 of the journal that a run left when it was cut off; with -o the journal stays."""
    from musclewire.signals import recording_of, recover_recording

    figure.check()
    found = recover_recording(recording, output, overwrite=overwrite)
    figure.draw(found.plot)
    written, ended = output or recording_of(recording), found.metadata["ended"]
    whole = found.with_minor_loop
    duration_s = whole.duration_s if "time_s" in whole else None
    answer = RecoverAnswer(recording=str(written), rows=len(whole), duration_s=duration_s, ended=str(ended))
    return Result(answer, f"{written}: {len(whole)} rows, {duration_s or 0.0:g} s, ended: {ended}")
