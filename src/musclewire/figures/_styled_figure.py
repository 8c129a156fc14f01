"""A matplotlib figure of the size and with the fonts of a style, however and whenever it is drawn."""

from __future__ import annotations

import io
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from musclewire.figures._style import FigureStyle, SubstituteFontWarning, figure_style

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from matplotlib.axes import Axes

INCH_MM = 25.4
NOTEBOOK_DPI = 110.0
# Whose code lies between a figure and whoever asked for it.
OURS = ("musclewire.", "matplotlib.", "contextlib")


class StyledFigure(Figure):
    """A figure of a style: matplotlib makes ticks only when it draws, so that drawing needs the style, too.

    It shows itself in a notebook, with or without pyplot.
    """

    def __init__(self, style: str | FigureStyle, height_mm: float, **_of_pyplot: Any) -> None:
        """Make an empty figure of the style's width, and of this height unless the style allows less.

        Pyplot's own arguments, a size and colours, are the style's here.
        """
        self.style = figure_style(style) if isinstance(style, str) else style
        if said := self.style.substitute:
            warnings.warn(said, SubstituteFontWarning, stacklevel=frames_of_ours())
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


def frames_of_ours() -> int:
    """Return how many calls up the first code is that is not ours: a warning belongs to its line."""
    count, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(OURS):
        count, frame = count + 1, frame.f_back
    return count


def new_figure(style: str, height_mm: float, by_pyplot: bool) -> StyledFigure:
    """Return an empty figure; one of pyplot's is shown at the end of a notebook's cell, and by ``pyplot.show()``."""
    if not by_pyplot:
        return StyledFigure(style, height_mm)
    from matplotlib import pyplot

    return pyplot.figure(FigureClass=StyledFigure, style=style, height_mm=height_mm)  # type: ignore[return-value]


@contextmanager
def axes_to_draw_on(axes: Axes | None, style: str) -> Iterator[Axes]:
    """Yield the axes as they are or, for None, those of a new pyplot figure, in whose style they are drawn."""
    if axes is not None:
        yield axes
        return
    figure, new = one_panel(style, by_pyplot=True)
    with figure.styled():
        yield new


def panel_rows(
    style: str, heights: Sequence[float], *, common_x: bool = True, by_pyplot: bool = False
) -> tuple[StyledFigure, list[Axes]]:
    """Return a figure of panels one below the other, over one axis or each over its own; heights in panels."""
    height_mm = figure_style(style).panel_height_mm * (sum(heights) + 0.3)
    figure = new_figure(style, height_mm, by_pyplot)
    with figure.styled():
        panels = np.atleast_1d(figure.subplots(len(heights), 1, sharex=common_x, height_ratios=list(heights)))
        figure.align_ylabels()
    return figure, list(panels)


def panels_side_by_side(style: str, count: int, *, by_pyplot: bool = False) -> tuple[StyledFigure, list[Axes]]:
    """Return a figure of panels side by side, or one below the other if it is narrow."""
    if count == 1:
        figure, panel = one_panel(style, by_pyplot=by_pyplot)
        return figure, [panel]
    found = figure_style(style)
    rows, columns = (1, count) if found.wide else (count, 1)
    wide_mm = found.width_mm / columns
    figure = new_figure(style, rows * max(1.2 * found.panel_height_mm, 0.75 * wide_mm), by_pyplot)
    with figure.styled():
        return figure, list(np.atleast_1d(figure.subplots(rows, columns)).flat)


def panel_grid(style: str, count: int, columns: int) -> tuple[StyledFigure, list[Axes]]:
    """Return a figure of panels of their own axes, so many side by side, half as many if it is narrow."""
    found = figure_style(style)
    columns = min(count, columns if found.wide else max(columns // 2, 1))
    rows = -(-count // columns)
    figure = StyledFigure(style, rows * found.panel_height_mm)
    with figure.styled():
        panels = list(figure.subplots(rows, columns, squeeze=False).flat)
        for unused in panels[count:]:
            unused.set_visible(False)
    return figure, panels[:count]


def one_panel(style: str, *, by_pyplot: bool = False) -> tuple[StyledFigure, Axes]:
    """Return a figure of one panel, two thirds as high as wide, at most 100 mm."""
    found = figure_style(style)
    figure = new_figure(style, min(0.67 * found.width_mm, max(100.0, 1.5 * found.panel_height_mm)), by_pyplot)
    with figure.styled():
        return figure, figure.subplots()
