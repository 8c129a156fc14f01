"""The figure of a home move: the model's curve as it was and as it is today, and by how much it moved."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from musclewire.identify._home.homing import Homing
from musclewire.sensing import SHOWN_AS, SensingModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS = 200


def homing_figure(before: SensingModel, found: Homing, *, style: str = "screen") -> Figure:
    """Draw a model's curve before and after a home move, and how far its resistance moved at B and at C.

    Parameters
    ----------
    before
        The model that the home move was made with.
    found
        What the home move found.
    style
        Size and fonts of the figure, as in ``Recording.plot``.

    Returns
    -------
    A matplotlib figure; bars are two standard deviations.

    Raises
    ------
    CallerError
        For an unknown style; the message suggests the nearest.
    """
    from musclewire.figures import panels_side_by_side

    figure, (curves, moved) = panels_side_by_side(style, 2)
    with figure.styled():
        draw_curves(curves, before, found.model)
        draw_moved(moved, found)
    return figure


def draw_curves(axes: Axes, before: SensingModel, today: SensingModel) -> None:
    """Draw the mean of both branches of both models over their own range."""
    from musclewire.pages import AVERAGE, TARGET

    factor, unit = SHOWN_AS[before.quantity]
    thin = axes.figure.style.line_pt  # type: ignore[union-attr]  # our figures have a style
    for model, colour, width, name in ((before, TARGET, 2.5 * thin, "before"), (today, AVERAGE, thin, "today")):
        quantity = np.linspace(model.quantity_min, model.quantity_max, POINTS)
        axes.plot(model.resistance_ohm(quantity), factor * quantity, color=colour, linewidth=width, label=name)
    axes.set(xlabel="wire resistance [ohm]", ylabel=f"{before.quantity} [{unit}]")
    axes.legend()


def draw_moved(axes: Axes, found: Homing) -> None:
    """Draw the change of the resistance at B and C with two standard deviations, and say whether it was corrected."""
    from musclewire.pages import COOLING, HEATING, TARGET

    axes.axhline(0.0, color=TARGET, linewidth=0.8)
    points = (
        (found.resistance_max_moved_ohm, found.resistance_max_moved_std_ohm, COOLING, "o"),
        (found.resistance_min_moved_ohm, found.resistance_min_moved_std_ohm, HEATING, "s"),
    )
    for place, (value, std, colour, marker) in enumerate(points):
        axes.errorbar(place, value, 2.0 * std, color=colour, marker=marker, capsize=4)
    axes.set_xticks((0, 1), ("at B, cold", "at C, hot"))
    axes.set(xlim=(-0.5, 1.5), ylabel="change of\nthe resistance [ohm]")
    axes.set_title("the model is corrected" if found.home.corrected else "the model keeps its curve")
