"""The benchmark's page: bars, a heat map of errors, and the error of every wire."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from musclewire.figures import StyledFigure, figure_style
from musclewire.pages import STYLE, NumberCard, page, svg_in_frame
from musclewire.signals import write_text_whole
from musclewire_robustness.benchmark import Robustness
from musclewire_robustness.table_text import COLUMNS, number, rows_answer
from musclewire_robustness.verdicts import BarVerdict

# Colours from the best that was seen in the study of prototypes to what is of no use.
MIN_PCT, MAX_PCT = 0.3, 10.0
# Low enough for few rows, high enough for the label of the colours [in].
MIN_HEIGHT = 3.6
# Numbers are light on cells of the darker colours, which begin at this part of the scale.
DARK_FROM, ON_DARK, ON_LIGHT = 0.6, "#ffffff", "#222222"
LOOK: Mapping[Any, Any] = {**STYLE, "axes.grid": False}


def write_report(result: Robustness, path: Path) -> None:
    """Write the page of a benchmark, whole or not at all; it needs no other file.

    Parameters
    ----------
    result
        What ``robustness`` returned.
    path
        File to write.

    Raises
    ------
    CallerError
        If the folder cannot be written to.
    """
    text = page(
        "musclewire_robustness/report.html",
        cards=key_numbers(result),
        seeds=f"{len(result.seeds)} wires: {result.seeds_text}",
        references=", ".join(result.references),
        errors=svg_in_frame(heat_map(*error_matrix(result), "error [% of the full stroke]"), "errors"),
        grips=grip_cells(result),
        wires=svg_in_frame(heat_map(*wire_matrix(result), "error [% of the full stroke]"), "wires"),
        bars=bar_cells(result),
        columns=COLUMNS,
        rows=row_cells(result),
    )
    write_text_whole(path, text)


def key_numbers(result: Robustness) -> list[NumberCard]:
    """Return the key numbers of a benchmark."""
    held = len(result.verdicts) - len(result.missed)
    found = [
        NumberCard(
            "bars that hold",
            f"{held} of {len(result.verdicts)}",
            f"of the default estimator; missed unexpectedly: {len(result.new_misses)}",
            not result.new_misses,
        )
    ]
    undisturbed = [row for row in result.estimators if row.condition.undisturbed]
    found += [
        NumberCard(row.estimator, f"{number(row.score.rms_pct)} %", "undisturbed, of the full stroke")
        for row in undisturbed
    ]
    return [*found, NumberCard("wires", str(len(result.seeds)), result.seeds_text)]


def error_matrix(result: Robustness) -> tuple[list[str], list[str], Any]:
    """Return conditions, estimators and the errors of each [%]; NaN for none."""
    names = list(dict.fromkeys(row.estimator for row in result.estimators))
    conditions = [item.name for item in result.conditions]
    errors = np.full((len(conditions), len(names)), np.nan)
    for row in result.estimators:
        if row.score.rms_pct is not None:
            errors[conditions.index(row.condition.name), names.index(row.estimator)] = row.score.rms_pct
    return conditions, names, errors


def wire_matrix(result: Robustness) -> tuple[list[str], list[str], Any]:
    """Return conditions, wires and the errors of the first estimator [%]; NaN for none."""
    conditions = [item.name for item in result.conditions]
    first = result.estimators[0].estimator
    seeds = list(result.seeds)
    errors = np.full((len(conditions), len(seeds)), np.nan)
    for row in result.estimators:
        for wire in row.wires if row.estimator == first else ():
            if wire.rms_pct is not None:
                errors[conditions.index(row.condition.name), seeds.index(wire.seed)] = wire.rms_pct
    return conditions, [str(seed) for seed in seeds], errors


def heat_map(rows: Sequence[str], names: Sequence[str], values: Any, label: str) -> Figure:
    """Draw numbers as colours with the number in each cell."""
    with mpl.rc_context(dict(LOOK)):
        width, height = max(4.5, 2.4 + 0.62 * len(names)), max(MIN_HEIGHT, 1.2 + 0.27 * len(rows))
        figure = Figure(figsize=(width, height), layout="constrained")
        draw_heat_map(figure.add_subplot(), rows, names, values, label)
    return figure


def draw_heat_map(axes: Any, rows: Sequence[str], names: Sequence[str], values: Any, label: str) -> None:
    """Draw numbers as colours, with the number in each cell and a bar of the colours."""
    scale = LogNorm(MIN_PCT, MAX_PCT)
    image = axes.imshow(values, aspect="auto", cmap="YlOrRd", norm=scale)
    axes.set_xticks(range(len(names)), names, rotation=30 if max(map(len, names)) > 4 else 0, ha="right")
    axes.set_yticks(range(len(rows)), rows)
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            colour = ON_DARK if scale(value) > DARK_FROM else ON_LIGHT
            axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize="small", color=colour)
    axes.figure.colorbar(image, ax=axes, label=label)


def error_figure(result: Robustness, *, style: str = "screen") -> Figure:
    """Draw the error of every estimator under every condition as a heat map.

    Parameters
    ----------
    result
        What ``robustness`` returned.
    style
        Size and fonts of the figure, as in ``Recording.plot``.

    Returns
    -------
    A matplotlib figure.

    Raises
    ------
    CallerError
        For an unknown style; the message suggests the nearest.
    """
    conditions, names, errors = error_matrix(result)
    found = figure_style(style)
    # Low for few conditions, and never too low for the label of the colours.
    figure = StyledFigure(style, found.panel_height_mm * max(1.5, 0.8 + 0.13 * len(conditions)))
    with figure.styled(), mpl.rc_context({"axes.grid": False}):
        draw_heat_map(figure.add_subplot(), conditions, names, errors, "error\n[% of the full stroke]")
    return figure


def grip_cells(result: Robustness) -> list[list[str]]:
    """Return every grip as cells."""
    return [
        [
            row.condition,
            number(row.held_mean_pct, 1),
            number(row.held_max_pct, 1),
            number(row.estimate_mean_pct, 1),
            f"{row.held} of {row.grips}",
        ]
        for row in result.grips
    ]


def bar_cells(result: Robustness) -> list[list[str]]:
    """Return every verdict as cells, missed ones first, and of these what nobody expected."""
    ordered = sorted(result.verdicts, key=lambda one: (one.holds, one.known_reason is not None))
    return [
        [
            outcome_text(one),
            one.condition,
            one.name,
            f"{number(one.value, 3)} {one.unit}",
            one.bar_text,
            one.known_reason or "",
        ]
        for one in ordered
    ]


def outcome_text(verdict: BarVerdict) -> str:
    """Return whether a bar holds, and whether that was expected."""
    expected = verdict.known_reason is not None
    if verdict.holds:
        return "holds, listed as missed" if expected else "holds"
    return "missed, as expected" if expected else "missed, unexpectedly"


def row_cells(result: Robustness) -> list[list[str]]:
    """Return every row as cells."""
    return [
        [number(value, 3) if isinstance(value, float) or value is None else str(value) for _, value in row]
        for row in rows_answer(result)
    ]
