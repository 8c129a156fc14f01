"""The options of a command that can draw what it recorded: --plot and --plot-style."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from musclewire.app.files import require_figure_file, save_figure
from musclewire.app.options import PLOT, PLOT_STYLE
from musclewire.app.output import warn

if TYPE_CHECKING:
    from musclewire.signals.recording import Recording

__all__ = ["FigureOptions"]


@dataclass(frozen=True)
class FigureOptions:
    """The figure of a recording, and its size and fonts."""

    plot: Annotated[Path | None, PLOT] = None
    plot_style: Annotated[str, PLOT_STYLE] = "screen"

    def check(self) -> None:
        """Raise CallerError, before anything is heated, for a figure that cannot be; say if fonts are missing."""
        require_figure_file(self.plot)
        if self.plot is not None:
            from musclewire.figures import figure_style

            said = figure_style(self.plot_style).substitute
            warn([said] if said else [])

    def draw(self, recording: Recording) -> None:
        """Write the figure of a recording, if one was asked for."""
        if self.plot is not None:
            save_figure(recording.plot(style=self.plot_style), self.plot)
