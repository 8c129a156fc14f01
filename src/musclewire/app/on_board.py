"""``control --on-board``: the closed loop by the board's firmware, with the same call as the host's."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.controllers import FuzzyPidSettings
    from musclewire.experiment.metrics import ControlRun
    from musclewire.sensing.known_load import KnownSpring
    from musclewire.sensing.model import SensingModel

__all__ = ["OnBoard", "loop_of"]

OnBoard = Annotated[
    bool, typer.Option("--on-board", help="The board's firmware closes the loop; the host sends targets and records.")
]


def loop_of(
    model: SensingModel, settings: FuzzyPidSettings, load: KnownSpring | None, recalibrate: bool, on_board: bool
) -> Callable[..., ControlRun]:
    """Return what runs the closed loop: on the host, or on the board that was built for this model and controller.

    Raises CallerError for options that change the host's numbers where the firmware's are to run.
    """
    if not on_board:
        from musclewire.experiment.closed_loop import control

        return partial(control, settings=settings, load=load)
    if load is not None or recalibrate:
        raise CallerError("--on-board runs by the firmware's own numbers: leave --stiffness and --recalibrate out")
    from musclewire.experiment.closed_loop import settings_for
    from musclewire.experiment.on_board import control_on_board
    from musclewire.export.c import loop_checksum

    return partial(control_on_board, checksum=loop_checksum(model, settings_for(model, settings)))
