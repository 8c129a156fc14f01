"""The rule surfaces are drawn, labelled, and on one scale."""

from __future__ import annotations

from collections.abc import Iterator

import matplotlib as mpl
import pytest

mpl.use("Agg")

import matplotlib.pyplot as plt

from musclewire.controllers._plots import plot_rule_surfaces
from musclewire.controllers._rules import load_rule_base, rule_base_names
from musclewire.errors import CallerError


@pytest.fixture(autouse=True)
def _close_figures() -> Iterator[None]:
    yield
    plt.close("all")


@pytest.mark.parametrize("name", rule_base_names())
def test_every_rule_base_is_drawn_as_three_labelled_panels(name: str) -> None:
    panels = plot_rule_surfaces(load_rule_base(name))
    panels[0].figure.canvas.draw()
    assert len(panels) == 3
    assert all(panel.get_title() and panel.get_xlabel() for panel in panels)
    assert panels[0].get_ylabel()


def test_the_colour_bar_runs_from_zero_to_one() -> None:
    panels = plot_rule_surfaces(load_rule_base())
    bar = panels[0].figure.axes[-1]
    assert bar.get_ylim() == (0.0, 1.0)


def test_axes_given_by_the_caller_are_drawn_on() -> None:
    _, mine = plt.subplots(1, 3)
    assert plot_rule_surfaces(load_rule_base(), mine) == tuple(mine)


def test_two_axes_are_not_enough() -> None:
    _, mine = plt.subplots(1, 2)
    with pytest.raises(CallerError, match="needs three axes, not 2"):
        plot_rule_surfaces(load_rule_base(), mine)
