"""The fuzzy rule surfaces as a picture: three gain ratios over the error and its change."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from musclewire.controllers.fuzzy import infer_surface
from musclewire.controllers.rules import RuleBase
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_rule_surfaces"]

GRID_POINTS = 181
TITLES = ("$K_p'$ (proportional)", "$K_I'$ (integral)", "$K_D'$ (derivative)")


def plot_rule_surfaces(rule_base: RuleBase, axes: Sequence[Axes] | None = None) -> tuple[Axes, Axes, Axes]:
    """Draw the three ratios of Eq. 6 over both inputs, side by side on one colour scale from 0 to 1.

    Parameters
    ----------
    rule_base
        The rule base to draw.
    axes
        Three matplotlib axes to draw on; those of a new figure by default.

    Returns
    -------
    The three axes, in the order proportional, integral, derivative.

    Raises
    ------
    CallerError
        If ``axes`` are not three.
    """
    panels = _three_axes(rule_base, axes)
    ratio = np.linspace(-1.0, 1.0, GRID_POINTS)
    surface = infer_surface(rule_base, ratio[:, np.newaxis], ratio[np.newaxis, :])
    levels = np.linspace(0.0, 1.0, 21)
    for panel, values, title in zip(panels, surface, TITLES, strict=True):
        filled = panel.contourf(ratio, ratio, values.T, levels=levels, cmap="viridis", vmin=0.0, vmax=1.0)
        panel.set_title(title)
        panel.set_xlabel("error / error range")
        panel.set_aspect("equal")
        panel.set_xticks(np.linspace(-1.0, 1.0, 5))
        panel.set_yticks(np.linspace(-1.0, 1.0, 5))
    panels[0].set_ylabel("rate of the error / change range")
    bar = panels[0].figure.colorbar(filled, ax=list(panels), ticks=np.linspace(0.0, 1.0, 6), shrink=0.9)
    bar.set_label("ratio: 0 minimum gain, 1 maximum")
    return panels


def _three_axes(rule_base: RuleBase, axes: Sequence[Axes] | None) -> tuple[Axes, Axes, Axes]:
    if axes is None:
        import matplotlib.pyplot as plt

        figure, made = plt.subplots(1, 3, figsize=(11.0, 3.8), sharey=True, layout="constrained")
        figure.suptitle(f"Rule base {rule_base.name}")
        axes = list(made)
    if len(axes) != 3:
        raise CallerError(f"plot_rule_surfaces needs three axes, not {len(axes)}")
    return axes[0], axes[1], axes[2]
