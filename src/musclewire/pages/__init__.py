"""What all pages share: one style sheet, one look of figures, figures as text that stands in the page itself."""

from __future__ import annotations

import io
from collections.abc import Mapping
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["AVERAGE", "COOLING", "HEATING", "PAPER", "STYLE", "TARGET", "page_template", "style_sheet", "svg"]

HEATING, COOLING, AVERAGE, PAPER, TARGET = "#c8553d", "#1f6f8b", "#2b2b2b", "#8a5fbf", "#9aa0a6"
STYLE: Mapping[str, object] = {
    "font.family": "sans-serif",
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.labelcolor": "#222222",
    "axes.grid": True,
    "grid.color": "#e6e8eb",
    "grid.linewidth": 0.8,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "svg.fonttype": "path",
}


def svg(figure: Figure, name: str) -> str:
    """Return a figure as an <svg> element.

    Parameters
    ----------
    figure
        The figure; it gets a canvas for SVG.
    name
        Keeps the ids of the element apart from those of other figures in one page.

    Returns
    -------
    The element as text, the same for the same figure.
    """
    text = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": name, "svg.fonttype": "path"}):
        FigureCanvasSVG(figure)
        figure.savefig(text, format="svg", metadata={"Date": None})
    whole = text.getvalue()
    return whole[whole.index("<svg") :]


def style_sheet() -> str:
    """Return the style sheet that all pages share."""
    return (files("musclewire.pages") / "style.css").read_text("utf-8")


def page_template(package: str, name: str) -> Template:
    """Return the page template beside the modules of a package.

    Parameters
    ----------
    package
        Full name of the package, as "musclewire.app.report".
    name
        The template's file name.

    Returns
    -------
    The template, with ``$names`` to be substituted.
    """
    return Template((files(package) / name).read_text("utf-8"))
