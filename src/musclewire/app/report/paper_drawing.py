"""How all figures of the reproduction page are drawn: sizes, shades, printed numbers in the paper's colour."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from musclewire.app.report.figures import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["SHADES", "SIZE", "WHITE_BOX", "one_panel", "printed_line", "ramp"]

SIZE = (6.4, 4.7)
SHADES = ("#1f6f8b", "#e0a030", "#5c6670")
WHITE_BOX = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}


def one_panel() -> tuple[Figure, Axes]:
    """Return an empty figure of the page's size."""
    figure = Figure(figsize=SIZE, layout="constrained")
    return figure, figure.subplots()


def printed_line(axes: Axes, place: float, text: str, rotation: float = 90.0) -> None:
    """Draw a printed number as a vertical line with its text above the axes."""
    axes.axvline(place, color=PAPER, linewidth=1.0, linestyle=":", zorder=1)
    axes.annotate(text, (place, 1.01), xycoords=("data", "axes fraction"), color=PAPER, fontsize=8.5, rotation=rotation,
                  ha="center", va="bottom")  # fmt: skip


def ramp(count: int) -> Iterable[str]:
    """Return colours from light to dark."""
    from matplotlib.colors import to_hex

    return [to_hex(colour) for colour in mpl.colormaps["YlGnBu"](np.linspace(0.35, 1.0, count))]
