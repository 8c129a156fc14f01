"""How all figures of the reproduction page are drawn: sizes, shades, printed numbers in the paper's colour."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from musclewire.experiment import APPROACHED, FROM_FIRST_TARGET, determined
from musclewire.extras.paper._reproduce.all_checks import tolerance_of
from musclewire.pages import COOLING, PAPER
from musclewire.parameters import read_published

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.experiment import ControlMetrics
    from musclewire.extras.paper._reproduce.loops import SlowSineLoop

SIZE = (5.6, 4.4)
SHADES = ("#1f6f8b", "#b87a14", "#5c6670")
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


def draw_loop(
    axes: Axes,
    loop: SlowSineLoop,
    quantity: str,
    factor: float,
    colours: tuple[str, str],
    labels: tuple[str | None, str | None] = (None, None),
    **style: Any,
) -> None:
    """Draw both halves of a loop's last cycle over resistance, the cooling one dashed where the colours are one."""
    values = factor * loop.quantity(quantity)
    dashes = ("-", "--") if colours[0] == colours[1] else ("-", "-")
    for part, colour, label, dash in zip(loop.halves(), colours, labels, dashes, strict=True):
        axes.plot(loop.resistance_ohm[part], values[part], color=colour, label=label, linestyle=dash, **style)


def pretension_legend(axes: Axes) -> None:
    """Add the legend of loops over pretension, those that the paper prints in its colour."""
    legend = axes.legend(title="pretension (solid heating, dashed cooling)", title_fontsize=8.5, fontsize=8.5)
    for text in legend.get_texts():
        if "paper" in text.get_text():
            text.set_color(PAPER)


def ramp(count: int) -> Iterable[str]:
    """Return colours from light to dark."""
    from matplotlib.colors import to_hex

    return [to_hex(colour) for colour in mpl.colormaps["YlGnBu"](np.linspace(0.35, 1.0, count))]


def error_bars(axes: Axes, metrics: ControlMetrics, table_number: int) -> None:
    """Draw the MAE of each step next to that of a table of the paper, whose way back begins below the top."""
    table = read_published("lan_fan_2010")[f"table{table_number}"]
    printed = [*table["mae_rise_pct"], *reversed(table["mae_return_pct"])]
    errors_pct = [determined(step.mae_approached_pct, "a step's error") for step in metrics.steps]
    places = np.arange(len(printed))
    axes.bar(places, errors_pct, width=0.55, color=COOLING, alpha=0.45, label=readings_text(metrics))
    axes.plot(places, printed, "D", color=PAPER, markerfacecolor="none", markersize=7, markeredgewidth=1.5,
              label=f"paper, Table {table_number}")  # fmt: skip
    axes.plot(places, np.add(printed, tolerance_of(f"table{table_number}.mae_rise_pct")), "_", color=PAPER,
              markersize=14, label="allowed to each step")  # fmt: skip
    axes.set_ylabel("MAE [% of target]")
    axes.grid(visible=False, axis="x")


def readings_text(metrics: ControlMetrics) -> str:
    """Return which reading of Eq. 7 is drawn, and what the first step has in the other."""
    first = determined(metrics.steps[0].mae_pct, "the first step's error")
    return f"ours, {APPROACHED} of {metrics.approach_s:g} s (first step {FROM_FIRST_TARGET}: {first:.1f} %)"
