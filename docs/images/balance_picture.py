"""The picture of "What closes it in a wire with 20 K of hysteresis" in docs/explanation/physics.md."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from balance_numbers import title
from balance_runs import BALANCE_WIRES, FINE_RATIOS, Balance, balances, changed_wires, loop_at_ratio
from matplotlib.figure import Figure
from physics_pictures import R_PHASE

from musclewire.pages import AVERAGE, HEATING, PAPER, TARGET
from musclewire.parameters import load_wire, read_published

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from physics_runs import FloatArray

SMALL = "#777777"
COMPARED = (("without an R-phase", "--", HEATING), ("both of these", ":", TARGET))
WORDS = {
    "without an R-phase": "without an R-phase",
    "both of these": "published temperature coefficients, barrier as at no stress",
}


def balance_figure() -> Figure:
    """Draw the parts of the branches' difference in resistance over force ratio, and the gap that they leave."""
    figure = Figure(figsize=(10.4, 8.4), layout="constrained")
    rows = figure.subplots(2, len(BALANCE_WIRES), sharex=True, sharey="row", height_ratios=(1.25, 1.0))
    figure.suptitle("What parts heating from cooling, and what closes it: simulated wires on the paper's spring")
    for column, wire in enumerate(BALANCE_WIRES):
        found = balances(wire, FINE_RATIOS)
        draw_parts(rows[0, column], found)
        draw_gap(rows[1, column], wire, found)
        rows[0, column].set_title(title(wire))
        rows[1, column].set_xlabel("pretension, as a fraction of the largest force")
    draw_measured(rows[1, 1])
    rows[0, 0].set_ylabel("resistance on heating less that on cooling\n[% of the range of resistance]")
    rows[1, 0].set_ylabel("strain gap (Eq. 2) [%]")
    rows[1, 0].set_ylim(bottom=0.0)
    label_parts(rows[0, 0], rows[0, 1])
    rows[1, 0].legend(*rows[1, 1].get_legend_handles_labels(), loc="upper left", fontsize=9)
    return figure


def percents(rows: Sequence[Balance], part: str) -> FloatArray:
    """Return a part of every balance in percent of the range of resistance."""
    return np.array([100.0 * getattr(row, part) / row.range_ohm for row in rows])


def draw_parts(axes: Axes, rows: Sequence[Balance]) -> None:
    """Stack what makes heating resist more above zero, what makes cooling resist more below, and draw the sum."""
    ratio = np.array([row.force_ratio for row in rows])
    above, below = np.zeros(ratio.size), np.zeros(ratio.size)
    for part, colour in (("hotter", HEATING), ("r_phase", R_PHASE), ("small", SMALL)):
        percent = percents(rows, part)
        up, down = np.maximum(percent, 0.0), np.minimum(percent, 0.0)
        axes.fill_between(ratio, above, above + up, color=colour, alpha=0.42, linewidth=0)
        axes.fill_between(ratio, below, below + down, color=colour, alpha=0.42, linewidth=0)
        above, below = above + up, below + down
    axes.plot(ratio, percents(rows, "published_hotter"), "--", color=HEATING, linewidth=1.3)
    axes.plot(ratio, percents(rows, "whole"), color=AVERAGE, linewidth=2.4)
    axes.axhline(0.0, color="#555555", linewidth=0.8)
    axes.set_xlim(ratio[0], ratio[-1])


def label_parts(left: Axes, right: Axes) -> None:
    """Write what the areas and lines of both upper panels are."""
    left.text(0.635, 0.8, "heating is hotter", color=HEATING, fontweight="bold", ha="right", va="center")
    left.text(0.635, 4.1, "hotter, with published coefficients and 20 K", color=HEATING, ha="right", va="center")
    left.text(0.635, 2.05, "all together", color=AVERAGE, fontweight="bold", ha="right", va="center")
    left.text(0.635, -0.95, "martensite, geometry", color=SMALL, ha="right", va="center")
    right.text(0.42, -3.6, "all together", color=AVERAGE, fontweight="bold", va="center")
    right.text(0.26, -2.2, "R-phase on cooling", color=R_PHASE, fontweight="bold", va="center")


def draw_gap(axes: Axes, wire: str, rows: Sequence[Balance]) -> None:
    """Draw the gap as it is read, and those of two wires that differ in what the section names."""
    axes.plot(FINE_RATIOS, [100.0 * row.loop.strain_gap for row in rows], color=AVERAGE, linewidth=2.4)
    axes.lines[-1].set_label("as shipped")
    changes = changed_wires()
    for name, line, colour in COMPARED:
        gaps = [100.0 * loop_at_ratio(wire, ratio, **changes[name]).strain_gap for ratio in FINE_RATIOS]
        axes.plot(FINE_RATIOS, gaps, line, color=colour, linewidth=1.6, label=WORDS[name])


def draw_measured(axes: Axes) -> None:
    """Draw the two gaps which the paper prints for the 125 um wire."""
    printed = read_published("lan_fan_2010")["strain_gap_125um"]
    ratio = np.array(printed["pretension_n"]) / load_wire("paper-125um").maximum_force_n.value
    axes.plot(ratio, printed["strain_gap_pct"], "o", markersize=7, markerfacecolor="white", markeredgecolor=PAPER,
              markeredgewidth=1.8, zorder=5, clip_on=False, label="the paper's Fig. 4, as printed")  # fmt: skip
