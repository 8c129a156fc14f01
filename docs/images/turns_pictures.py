"""The picture of docs/explanation/turns_and_minor_loops.md: measured isobars next to those of the simulated sample."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

sys.path.insert(0, str(Path(__file__).parents[2]))

from studies.isobar_branches import simulated_sample
from studies.measured_isobars import (
    LEFT,
    STRESSES_MPA,
    ZERO_CELSIUS_K,
    branches,
    distances_k,
    levelled,
    measured_isobar,
)

from musclewire.pages import AVERAGE, COOLING, HEATING, PAPER
from musclewire.parameters import read_published

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HELD_OUT_MPA = tuple(read_published("flexinol_isobars")["held_out"]["stress_mpa"])


def branches_figure() -> Figure:
    """Draw the isobars, measured and simulated, and the distance of their branches over the stroke that is left."""
    figure = Figure(figsize=(12.4, 6.4), layout="constrained")
    columns = figure.subplots(2, len(STRESSES_MPA), sharey="row", sharex="row")
    for column, stress_mpa in enumerate(STRESSES_MPA):
        loops, distances = columns[:, column]
        words = ", held out" if stress_mpa in HELD_OUT_MPA else ""
        loops.set_title(f"{stress_mpa:.0f} MPa{words}")
        draw_loops(loops, stress_mpa)
        draw_distances(distances, stress_mpa)
        loops.set_xlabel("temperature [°C]")
        distances.set_xlabel("stroke left [%]")
    columns[0, 0].set_ylabel("strain above the hot wire's [%]")
    columns[1, 0].set_ylabel("heating hotter than cooling by [K]")
    columns[1, 0].set_ylim(bottom=0.0)
    figure.legend(*columns[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4)
    figure.legend(*columns[1, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def draw_loops(axes: Axes, stress_mpa: float) -> None:
    """Draw both branches, measured as points and simulated as lines."""
    for loop, style, source in (
        (measured_isobar(stress_mpa), {"marker": "o", "markersize": 2.6, "linestyle": "none"}, "measured"),
        (simulated_sample(stress_mpa), {"linestyle": "-", "linewidth": 1.5}, "simulated"),
    ):
        for branch, colour, name in zip(branches(loop), (HEATING, COOLING), ("heating", "cooling"), strict=True):
            strain = 100.0 * (branch[1] - loop.strain.min())
            axes.plot(branch[0] - ZERO_CELSIUS_K, strain, color=colour, label=f"{name}, {source}", **style)


def draw_distances(axes: Axes, stress_mpa: float) -> None:
    """Draw the distance of the branches over the part of the stroke left."""
    left = 100.0 * np.array(LEFT)
    measured = measured_isobar(stress_mpa)
    rest = levelled(measured)
    axes.plot(
        left, distances_k(measured), "o:", color=PAPER, markersize=4, linewidth=1.0, label="measured, as recorded"
    )
    axes.plot(
        left, rest.distances_k, "s-", color=AVERAGE, markersize=4, linewidth=1.3,
        label="measured, less a strain linear in temperature (per kelvin in each panel)",
    )  # fmt: skip
    axes.plot(left, distances_k(simulated_sample(stress_mpa)), "-", color="#5b5ea6", linewidth=2.0, label="simulated")
    axes.text(0.5, 0.06, f"{1e6 * rest.per_k:.0f}·10⁻⁶ /K", transform=axes.transAxes, ha="center", color=AVERAGE)
