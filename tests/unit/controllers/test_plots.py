"""The rule surfaces are drawn, labelled, and on one scale."""

from __future__ import annotations

import matplotlib as mpl
import pytest

mpl.use("Agg")

import matplotlib.pyplot as plt

from musclewire.controllers import load_rule_base, plot_rule_surfaces, rule_base_names
from musclewire.errors import CallerError


@pytest.mark.parametrize("name", rule_base_names())
def test_every_rule_base_is_drawn_as_three_labelled_panels_of_one_scale(name: str) -> None:
    figure, mine = plt.subplots(1, 3)
    assert plot_rule_surfaces(load_rule_base(name), mine) == tuple(mine)
    figure.canvas.draw()
    assert all(panel.get_title() and panel.get_xlabel() for panel in mine)
    assert figure.axes[-1].get_ylim() == (0.0, 1.0)
    plt.close(figure)


def test_two_axes_are_not_enough() -> None:
    figure, mine = plt.subplots(1, 2)
    with pytest.raises(CallerError, match="needs three axes, not 2"):
        plot_rule_surfaces(load_rule_base(), mine)
    plt.close(figure)
