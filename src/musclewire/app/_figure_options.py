"""The options of a command that can draw what it made: --plot and --plot-style."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from musclewire.app._files import require_figure_file, save_figure
from musclewire.app._options import PLOT, PLOT_STYLE
from musclewire.app._output import warn
from musclewire.errors import CallerError


@dataclass(frozen=True)
class FigureOptions:
    """The figure of what a command made, and its size and fonts."""

    plot: Annotated[Path | None, PLOT] = None
    plot_style: Annotated[str, PLOT_STYLE] = "screen"

    def check(self) -> None:
        """Raise CallerError, before anything is heated, for a figure that cannot be; say if fonts are missing."""
        if self.plot is None and self.plot_style != "screen":
            raise CallerError("--plot-style belongs to --plot: name the figure's file, or leave it out")
        require_figure_file(self.plot)
        if self.plot is not None:
            from musclewire.figures import figure_style

            said = figure_style(self.plot_style).substitute
            warn([said] if said else [])

    def draw(self, drawing: Callable[..., Any]) -> None:
        """Write what a function draws in a style, ``model.plot`` for example, if a figure was asked for."""
        if self.plot is None:
            return
        from musclewire.figures import SubstituteFontWarning

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SubstituteFontWarning)  # already said by check()
            drawn = drawing(style=self.plot_style)
            save_figure(drawn, self.plot)
        if pyplot := sys.modules.get("matplotlib.pyplot"):
            pyplot.close(drawn.figure)  # it would keep every figure of a process that calls many commands
