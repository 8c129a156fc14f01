"""What all pages share: style sheet, key numbers as cards, tables, the look of figures, figures as text in the page."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.metadata import version
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING, NamedTuple

import matplotlib as mpl
from matplotlib.backends.backend_svg import FigureCanvasSVG

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "AVERAGE",
    "COOLING",
    "HEATING",
    "PAPER",
    "STYLE",
    "TARGET",
    "NumberCard",
    "cards",
    "page",
    "svg",
    "svg_in_frame",
    "table",
    "table_rows",
]

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
        # Saving with a layout engine draws a figure twice, the first time only to lay it out.
        engine = figure.get_layout_engine()
        if engine is not None:
            engine.execute(figure)
            figure.set_layout_engine("none")
        figure.savefig(text, format="svg", metadata={"Date": None})
    whole = text.getvalue()
    return whole[whole.index("<svg") :]


def svg_in_frame(figure: Figure, name: str) -> str:
    """Return a wide figure in a frame: on a phone the frame scrolls sideways and the letters keep their size.

    Parameters
    ----------
    figure
        The figure; it gets a canvas for SVG.
    name
        Keeps the ids of the element apart from those of other figures in one page.

    Returns
    -------
    HTML of the frame with the figure as :func:`svg` writes it.
    """
    drawn_px = 96.0 * figure.get_figwidth()
    return f'<div class="scroll broad" style="--drawn: {drawn_px:.0f}px">{svg(figure, name)}</div>'


class NumberCard(NamedTuple):
    """A key number of a page.

    Parameters
    ----------
    name
        What it is, as HTML.
    value
        The number with its unit, as HTML.
    note
        What is said beneath it, as plain text.
    ok
        False for a number that is not as it should be; it is shown in red.
    """

    name: str
    value: str
    note: str
    ok: bool = True


def cards(items: Iterable[NumberCard]) -> str:
    """Return key numbers as a row of cards.

    Parameters
    ----------
    items
        The key numbers, in their order; names are HTML, notes are escaped.

    Returns
    -------
    HTML for an element of class "cards".
    """
    return "".join(
        f'<div class="card{"" if item.ok else " fails"}"><div class="name">{item.name}</div>'
        f'<div class="value">{item.value}</div><div class="compared">{escape(item.note)}</div></div>'
        for item in items
    )


def table_rows(rows: Iterable[Sequence[str]]) -> str:
    """Return rows of a table, every cell escaped.

    Parameters
    ----------
    rows
        Cells of each row, as plain text.

    Returns
    -------
    HTML for a table's body.
    """
    return "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)


def table(head: str, body: str, style: str) -> str:
    """Return a table that scrolls on narrow screens.

    Parameters
    ----------
    head
        HTML of the whole head, with its element.
    body
        HTML of the rows.
    style
        Class of the table in the style sheet.

    Returns
    -------
    HTML of the table.
    """
    return f'<div class="scroll"><table class="{style}">{head}<tbody>{body}</tbody></table></div>'


def page(package: str, name: str, parts: Mapping[str, object]) -> str:
    """Return a page made of a template, its parts, the shared style sheet and our version.

    Parameters
    ----------
    package
        Full name of the package in whose folder the template is, as "musclewire.app._report".
    name
        The template's file name.
    parts
        What stands for each ``$name`` of the template, besides ``$style`` and ``$version``.

    Returns
    -------
    HTML of the whole page.

    Raises
    ------
    KeyError
        If the template has a name that is not in ``parts``.
    """
    template = Template((files(package) / name).read_text("utf-8"))
    style = (files("musclewire.pages") / "style.css").read_text("utf-8")
    return template.substitute(parts, style=style, version=escape(version("musclewire")))
