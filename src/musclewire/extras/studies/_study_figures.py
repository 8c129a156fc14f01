"""Figures of a study's page: each quantity's distribution, each quantity over each parameter, series, and indices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.studies._sensitivity import Sensitivity
from musclewire.extras.studies._study import StudyResult
from musclewire.figures import panel_grid
from musclewire.pages import AVERAGE, COOLING, HEATING, STYLE, TARGET

WIDTH, ROW_HEIGHT, COLUMNS = 9.6, 2.5, 4
# The look of all pages, with powers of ten for numbers as small as a diameter in metres.
LOOK: Mapping[Any, Any] = {**STYLE, "axes.formatter.limits": (-3, 5)}
# A cloud of more points than this hides itself; they are taken evenly from all runs.
MAX_POINTS = 3000
# As many runs of a series are drawn one by one.
MAX_LINES = 40
BINS = 40
# Values of a parameter that a plot shows with their mean: an axis of the grid, and not a cloud.
MAX_LEVELS = 60


def panels(number: int, columns: int = COLUMNS) -> tuple[Figure, list[Any]]:
    """Return a figure and its axes, row by row."""
    columns = min(columns, number)
    rows = -(-number // columns)
    figure = Figure(figsize=(WIDTH if columns > 2 else 0.55 * WIDTH, rows * ROW_HEIGHT), layout="constrained")
    axes = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel().tolist()
    for unused in axes[number:]:
        unused.set_visible(False)
    return figure, axes[:number]


def label(name: str, unit: str) -> str:
    """Return the label of an axis."""
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def distribution_figure(result: StudyResult, names: Sequence[str]) -> Figure:
    """Draw how often each value of each quantity occurs."""
    with mpl.rc_context(dict(LOOK)):
        figure, axes = panels(len(names))
        draw_distributions(axes, result, names, 5)
    return figure


def draw_distributions(axes: Sequence[Any], result: StudyResult, names: Sequence[str], ticks: int) -> None:
    """Draw how often each value of each quantity occurs, a panel for each with so many ticks at most."""
    for axis, name in zip(axes, names, strict=True):
        values = result.columns[name][np.isfinite(result.columns[name])]
        axis.hist(values, bins=BINS, color=COOLING, alpha=0.85)
        axis.axvline(float(np.median(values)), color=AVERAGE, linewidth=1.2)
        axis.set_xlabel(label(name, result.plan.keep[name].unit))
        axis.set_ylabel("runs" if axis is axes[0] else "")
        axis.locator_params(axis="x", nbins=ticks)
        axis.set_axisbelow(True)


def distributions(result: StudyResult, *, style: str = "screen") -> Figure:
    """Draw how often each value of each kept quantity occurs in a study, with the median.

    Parameters
    ----------
    result
        What ``sweep`` returned.
    style
        Size and fonts of the figure, as in ``Recording.plot``.

    Returns
    -------
    A matplotlib figure, a panel for each quantity with a number for each run.

    Raises
    ------
    CallerError
        If no run gave a number, or for an unknown style.
    """
    names = numbers_of(result)
    if not names:
        raise CallerError(f"there is nothing to plot: none of {len(result)} runs gave a number, look at its errors")
    figure, axes = panel_grid(style, len(names), COLUMNS)
    with figure.styled(), mpl.rc_context({"axes.formatter.limits": LOOK["axes.formatter.limits"]}):
        draw_distributions(axes, result, names, 3)
    return figure


def numbers_of(result: StudyResult) -> list[str]:
    """Return the names of the kept quantities that are a number for each run, and finite for one at least."""
    return [name for name, column in result.columns.items() if column.ndim == 1 and np.isfinite(column).any()]


def over_parameters_figure(result: StudyResult, name: str) -> Figure:
    """Draw a quantity over each parameter: a point for each run, and the mean over the values of a grid's axis."""
    design, values = result.plan.design, result.columns[name]
    varied = [parameter for parameter in design.names if np.unique(design.column(parameter)).size > 1]
    with mpl.rc_context(dict(LOOK)):
        figure, axes = panels(max(len(varied), 1))
        for axis, parameter in zip(axes, varied, strict=False):
            cloud(axis, design.column(parameter), values)
            axis.set_xlabel(label(parameter, design.units[parameter]))
            axis.set_ylabel(label(name, result.plan.keep[name].unit) if axis is axes[0] else "")
    return figure


def cloud(axis: Any, at: np.ndarray[Any, Any], values: FloatArray) -> None:
    """Draw values over a parameter."""
    finite = np.flatnonzero(np.isfinite(values))
    shown = finite[:: max(1, -(-finite.size // MAX_POINTS))]
    levels, place = np.unique(at, return_inverse=True)
    is_text = at.dtype.kind not in "fiu"
    across = place.astype(np.float64) if is_text else at.astype(np.float64)
    # As points of a picture inside the drawing: thousands of vector circles would make a page of megabytes.
    axis.plot(across[shown], values[shown], ".", markersize=3, color=COOLING, alpha=0.4, rasterized=True)
    if levels.size <= min(MAX_LEVELS, at.size // 2):
        means = [float(values[finite[place[finite] == level]].mean()) if (place[finite] == level).any() else np.nan
                 for level in range(levels.size)]  # fmt: skip
        axis.plot(np.unique(across), means, color=HEATING)
    if is_text:
        axis.set_xticks(range(levels.size), [str(level)[-18:] for level in levels], rotation=30)
    else:
        axis.locator_params(axis="x", nbins=4)


def series_figure(result: StudyResult, name: str) -> Figure:
    """Draw a series of some runs over their samples, with the median of all runs."""
    rows = result.columns[name][np.isfinite(result.columns[name]).any(axis=1)]
    with mpl.rc_context(dict(LOOK)):
        figure, axes = panels(1)
        for row in rows[:: max(1, -(-len(rows) // MAX_LINES))]:
            axes[0].plot(row, color=TARGET, linewidth=0.6, alpha=0.7)
        axes[0].plot(np.nanmedian(rows, axis=0), color=AVERAGE)
        axes[0].set_xlabel("sample")
        axes[0].set_ylabel(label(name, result.plan.keep[name].unit))
    return figure


def index_figure(rows: Sequence[Sensitivity]) -> Figure:
    """Draw first and total indices, and PAWN's, of each quantity as bars."""
    quantities = list(dict.fromkeys(row.quantity for row in rows))
    with mpl.rc_context(dict(LOOK)):
        figure, axes = panels(len(quantities), 2)
        parameters = len({row.parameter for row in rows})
        figure.set_size_inches(WIDTH, max(1.4, 0.5 + 0.32 * parameters) * -(-len(quantities) // 2))
        for axis, quantity in zip(axes, quantities, strict=True):
            bars(axis, [row for row in rows if row.quantity == quantity])
            axis.set_title(quantity, fontsize=9.5, loc="left")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def bars(axis: Any, rows: Sequence[Sensitivity]) -> None:
    """Draw the indices of one quantity."""
    kinds = {"first": COOLING, "total": HEATING, "pawn": TARGET}
    known = {kind: colour for kind, colour in kinds.items() if any(getattr(row, kind) is not None for row in rows)}
    height = 0.8 / len(known)
    for place, (kind, colour) in enumerate(known.items()):
        lengths = [max(getattr(row, kind) or 0.0, 0.0) for row in rows]
        errors = None if kind == "pawn" else [getattr(row, f"{kind}_error") or 0.0 for row in rows]
        at = np.arange(len(rows)) + (place - 0.5 * (len(known) - 1)) * height
        axis.barh(at, lengths, height, xerr=errors, color=colour, label=kind, error_kw={"linewidth": 0.8})
    axis.set_yticks(range(len(rows)), [row.parameter for row in rows])
    axis.invert_yaxis()
    axis.set_xlim(0.0, None)
