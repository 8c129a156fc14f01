"""The figure of a training: how a new wire's loop moves, cycle by cycle, until it repeats."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from musclewire.experiment._training import SETTLED_FRACTION, Training

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def training_figure(training: Training, *, settled_fraction: float = SETTLED_FRACTION, style: str = "screen") -> Figure:
    """Draw how far resistance and strain have moved since the first cycle, and the change over five cycles, if any.

    ``settled_fraction`` is drawn as a line. Raises CallerError for an unknown style.
    """
    from matplotlib.ticker import MaxNLocator

    from musclewire.figures import panel_rows

    changed = any(cycle.change is not None for cycle in training.cycles)
    figure, panels = panel_rows(style, [1.0] * (2 + changed))
    with figure.styled():
        draw_resistance(panels[0], training)
        draw_strain(panels[1], training)
        if changed:
            draw_change(panels[2], training, settled_fraction)
        panels[-1].set_xlabel("cycle")
        panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
    return figure


def draw_resistance(axes: Axes, training: Training) -> None:
    """Draw by how much the resistance at points B and C has moved since the first cycle."""
    first = training.cycles[0]
    at_b = [1e3 * (cycle.resistance_max_ohm - first.resistance_max_ohm) for cycle in training.cycles]
    at_c = [1e3 * (cycle.resistance_min_ohm - first.resistance_min_ohm) for cycle in training.cycles]
    draw_moved(axes, training, at_b, at_c)
    axes.set_ylabel("resistance\nmoved [mohm]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)


def draw_strain(axes: Axes, training: Training) -> None:
    """Draw by how much the strain of the cold and of the hot wire has moved since the first cycle."""
    first = training.cycles[0]
    cold = [100.0 * (cycle.strain_cold - first.strain_cold) for cycle in training.cycles]
    stroke = [100.0 * (cycle.stroke - first.stroke) for cycle in training.cycles]
    draw_moved(axes, training, cold, [one + other for one, other in zip(cold, stroke, strict=True)])
    axes.set_ylabel("strain\nmoved [%]")


def draw_moved(axes: Axes, training: Training, cold: Sequence[float], hot: Sequence[float]) -> None:
    """Draw the values of the cold and of the hot wire against the cycle."""
    from musclewire.pages import COOLING, HEATING

    numbers = [cycle.number for cycle in training.cycles]
    axes.plot(numbers, cold, "o-", color=COOLING, label="cold, at B")
    axes.plot(numbers, hot, "s-", color=HEATING, label="hot, at C")


def draw_change(axes: Axes, training: Training, settled_fraction: float) -> None:
    """Draw the change over five cycles, and the level below which it counts as settled."""
    from musclewire.pages import AVERAGE, TARGET

    known = [(cycle.number, 100.0 * cycle.change) for cycle in training.cycles if cycle.change is not None]
    axes.plot(*zip(*known, strict=True), "o-", color=AVERAGE)
    axes.axhline(100.0 * settled_fraction, color=TARGET, linestyle="--")
    # The first cycles have no change: there the words are on no line.
    axes.annotate("settled below", (1, 100.0 * settled_fraction), va="bottom", fontsize="small")
    axes.set(ylabel="change over\n5 cycles [%]", ylim=(0.0, None))
