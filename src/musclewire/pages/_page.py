"""What all pages share: templates with one style sheet, the look of figures, figures as text in the page."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from typing import TYPE_CHECKING, NamedTuple

from markupsafe import Markup

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure

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


def svg(figure: Figure, name: str) -> Markup:
    """Return a figure as an <svg> element, whose ids ``name`` keeps apart from those of other figures in one page."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG

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
    return Markup(whole[whole.index("<svg") :])


def svg_in_frame(figure: Figure, name: str) -> Markup:
    """Return a wide figure in a frame: on a phone the frame scrolls sideways and the letters keep their size."""
    drawn_px = 96.0 * figure.get_figwidth()
    frame = Markup('<div class="scroll broad" style="--drawn: {:.0f}px">{}</div>')
    return frame.format(drawn_px, svg(figure, name))


class NumberCard(NamedTuple):
    """A key number of a page; one that is not ok is shown in red."""

    name: str
    value: str
    note: str  # said beneath it
    ok: bool = True


@cache
def environment() -> Environment:
    """Return what fills templates: text is escaped, and a name that a template misses is an error."""
    from jinja2 import Environment, FunctionLoader, StrictUndefined  # only who writes a page needs it

    loader = FunctionLoader(template_text)
    found = Environment(loader=loader, autoescape=True, trim_blocks=True, undefined=StrictUndefined)
    found.globals.update(style=Markup(template_text("musclewire.pages/style.css")), version=version("musclewire"))
    return found


def template_text(name: str) -> str:
    """Return a template: the full name of its package, a slash, and its file name."""
    package, _, file = name.partition("/")
    return (files(package) / file).read_text("utf-8")


def page(template: str, **values: object) -> str:
    """Return a template ("PACKAGE/FILE") filled with escaped values. Raises jinja2.UndefinedError if one is missing."""
    return environment().get_template(template).render(values)


def notebook_table(title: str, head: Sequence[str], rows: Iterable[Sequence[str]], note: str = "") -> str:
    """Return a small table with a note beneath, as notebooks show objects; everything given is escaped."""
    found = environment().get_template("musclewire.pages/notebook_table.html")
    return found.render(title=title, head=head, rows=list(rows), note=note)
