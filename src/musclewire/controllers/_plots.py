"""The fuzzy rule surfaces as a picture: three gain ratios over the error and its change."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from musclewire.controllers._fuzzy import infer_surface
from musclewire.controllers._rules import RuleBase
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

GRID_POINTS = 181
TITLES = ("$K_p'$ (proportional)", "$K_I'$ (integral)", "$K_D'$ (derivative)")


def plot_rule_surfaces(
    rule_base: RuleBase, axes: Sequence[Axes] | None = None, *, style: str = "screen"
) -> tuple[Axes, Axes, Axes]:
    """Draw the three ratios of Eq. 6 over both inputs, side by side on one colour scale from 0 to 1."""
    if axes is not None:
        if len(axes) != 3:
            raise CallerError(f"plot_rule_surfaces needs three axes, not {len(axes)}")
        return _draw_surfaces(rule_base, axes)
    from musclewire.figures import panels_side_by_side  # only drawing needs matplotlib

    figure, panels = panels_side_by_side(style, 3, by_pyplot=True)
    figure.set_layout_engine("compressed")  # made for panels that are square
    with figure.styled():
        figure.suptitle(f"Rule base {rule_base.name}")
        return _draw_surfaces(rule_base, panels)


def _draw_surfaces(rule_base: RuleBase, panels: Sequence[Axes]) -> tuple[Axes, Axes, Axes]:
    ratio = np.linspace(-1.0, 1.0, GRID_POINTS)
    surface = infer_surface(rule_base, ratio[:, np.newaxis], ratio[np.newaxis, :])
    levels = np.linspace(0.0, 1.0, 21)
    for panel, values, title in zip(panels, surface, TITLES, strict=True):
        filled = panel.contourf(ratio, ratio, values.T, levels=levels, cmap="viridis", vmin=0.0, vmax=1.0)
        panel.set(title=title, xlabel="error / error range", aspect="equal")
        panel.set_xticks(np.linspace(-1.0, 1.0, 5))
        panel.set_yticks(np.linspace(-1.0, 1.0, 5))
        panel.grid(visible=False)
        if panel is panels[0] or panel.get_position().x0 == panels[0].get_position().x0:
            panel.set_ylabel("rate of the error\n/ change range")
    bar = panels[0].figure.colorbar(filled, ax=list(panels), ticks=np.linspace(0.0, 1.0, 6), shrink=0.9)
    bar.set_label("ratio: 0 minimum gain,\n1 maximum")
    return panels[0], panels[1], panels[2]
