"""A matplotlib figure of the size and with the fonts of a style, however and whenever it is drawn."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from musclewire.figures.style import FigureStyle, figure_style

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from matplotlib.axes import Axes

__all__ = ["StyledFigure", "one_panel", "panel_rows", "panels_side_by_side"]

INCH_MM = 25.4
NOTEBOOK_DPI = 110.0


class StyledFigure(Figure):
    """A figure of a style: matplotlib makes ticks only when it draws, so that drawing needs the style, too.

    It shows itself in a notebook, with or without pyplot, and is saved as any figure: ``figure.savefig("a.pdf")``.
    """

    def __init__(self, style: str | FigureStyle, height_mm: float) -> None:
        """Make an empty figure of the style's width, and of this height unless the style allows less."""
        self.style = figure_style(style) if isinstance(style, str) else style
        height_mm = min(height_mm, self.style.max_height_mm or height_mm)
        with self.styled():
            super().__init__(figsize=(self.style.width_mm / INCH_MM, height_mm / INCH_MM), layout="constrained")

    def styled(self) -> AbstractContextManager[None]:
        """Return the context in which everything of this figure is made and drawn."""
        return mpl.rc_context(self.style.settings)  # type: ignore[arg-type]  # matplotlib lists keys as literals

    def draw(self, renderer: Any) -> None:
        """Draw the figure in its style."""
        with self.styled():
            super().draw(renderer)

    def savefig(self, *args: Any, **how: Any) -> None:
        """Save the figure in its style; arguments are those of matplotlib."""
        with self.styled():
            super().savefig(*args, **how)

    def _repr_png_(self) -> bytes:
        """Return the figure as a picture, for a notebook in which pyplot was not imported."""
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=NOTEBOOK_DPI)
        return picture.getvalue()


def panel_rows(style: str, heights: Sequence[float]) -> tuple[StyledFigure, list[Axes]]:
    """Return a figure of panels one below the other over the same axis; heights in panels of the style."""
    height_mm = figure_style(style).panel_height_mm * (sum(heights) + 0.3)
    figure = StyledFigure(style, height_mm)
    with figure.styled():
        panels = np.atleast_1d(figure.subplots(len(heights), 1, sharex=True, height_ratios=list(heights)))
        figure.align_ylabels()
    return figure, list(panels)


def panels_side_by_side(style: str, count: int) -> tuple[StyledFigure, list[Axes]]:
    """Return a figure of panels side by side, or one below the other if it is narrow."""
    if count == 1:
        figure, panel = one_panel(style)
        return figure, [panel]
    found = figure_style(style)
    rows, columns = (1, count) if found.wide else (count, 1)
    wide_mm = found.width_mm / columns
    figure = StyledFigure(style, rows * max(1.2 * found.panel_height_mm, 0.75 * wide_mm))
    with figure.styled():
        return figure, list(np.atleast_1d(figure.subplots(rows, columns)).flat)


def one_panel(style: str) -> tuple[StyledFigure, Axes]:
    """Return a figure of one panel, two thirds as high as wide, at most 100 mm."""
    found = figure_style(style)
    figure = StyledFigure(style, min(0.67 * found.width_mm, max(100.0, 1.5 * found.panel_height_mm)))
    with figure.styled():
        return figure, figure.subplots()
