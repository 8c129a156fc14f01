"""The command that finds a controller's gains in the recording that characterised the wire: tune."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from musclewire.app._figure_options import FigureOptions
from musclewire.app._files import require_free
from musclewire.app._model_commands import RecordingPath
from musclewire.app._options import CLOSED_LOOP_TIME, CONTROLLER, OUTPUT, OVERWRITE, RULES, in_si
from musclewire.app._output import Result
from musclewire.app._recording_options import ReadingOptions


def tune(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file from 'musclewire fit'.")],
    recording: RecordingPath,
    reading: ReadingOptions,
    figure: FigureOptions,
    output: Annotated[Path | None, OUTPUT] = None,
    controller: Annotated[str, CONTROLLER] = "feedforward",
    rules: Annotated[str | None, RULES] = None,
    closed_loop_time: Annotated[str | None, CLOSED_LOOP_TIME] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Find a controller's gains from the slow loop, by a published rule; prints plant, gains and margins."""
    from musclewire.app._answers import TuneAnswer
    from musclewire.identify import tune as run_tune
    from musclewire.sensing import load_model

    figure.check()
    if output is not None:
        require_free(output, overwrite)
    found = run_tune(
        load_model(model),
        reading.read(recording),
        controller=controller,
        closed_loop_time_s=in_si("--closed-loop-time", closed_loop_time),
        rule_base=rules,
    )
    if output is not None:
        found.save(output)
    figure.draw(found.plot)
    answer = TuneAnswer(**found.report(), gains=None if output is None else str(output))
    return Result(answer, str(found) if output is None else f"{found}\ngains written to {output}")
