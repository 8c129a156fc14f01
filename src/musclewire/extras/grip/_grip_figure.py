"""The figure of a grip: what shows contact, and the estimated force."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from musclewire.extras.grip._gripper_training import REST_S
from musclewire.figures import panels_side_by_side
from musclewire.pages import COOLING, HEATING, TARGET
from musclewire.sensing import evaluate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.extras.grip._grip import GripRun
    from musclewire.extras.grip._gripper_training import GripperKnowledge

MEASURED, FREE, FOUND = COOLING, TARGET, HEATING
SHOWN_BEFORE_S = 0.3


def plot_grip(run: GripRun, knowledge: GripperKnowledge, *, style: str = "screen") -> Axes:
    """Draw power against resistance with that of the free closing, and force over time; returns the second axes."""
    figure, (by_place, by_time) = panels_side_by_side(style, 2)
    with figure.styled():
        draw_power(by_place, run, knowledge)
        draw_force(by_time, run)
        by_place.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0))  # inside it would lie on the lines
        by_time.legend(loc="lower right")
    return by_time


def draw_power(axes: Axes, run: GripRun, knowledge: GripperKnowledge) -> None:
    """Draw the power that held the fingers on their way, and what holds them there with nothing in the way."""
    free = knowledge.free
    place = (run["wire_resistance_ohm"] - free.resistance_min_ohm) / (free.resistance_max_ohm - free.resistance_min_ohm)
    power = 1e3 * run["wire_voltage_v"] * run["shunt_voltage_v"] / run.facts.shunt_resistance_ohm
    closing = (run["time_s"] > REST_S + SHOWN_BEFORE_S) & (run["target_grip_force_n"] == 0.0)
    closing &= run["time_s"] <= REST_S + run.facts.closing_s
    rate = np.gradient(place, run["time_s"])
    inside = closing & (place < free.normalised_max) & (place > free.normalised_min) & (rate < 0.0)
    # From the first sample that contracts: before it resistance has the same values, and another meaning.
    inside &= np.arange(place.size) > int(np.argmax(np.where(closing, place, -np.inf)))
    # Motion takes power too, and fingers that meet something slow down: without it only what holds them is left.
    holding = power + 1e3 * rate * evaluate(free.closing_energy_j, place)
    across = np.linspace(place[inside].min(), place[inside].max(), 100) if inside.any() else np.empty(0)
    axes.plot(
        across, 1e3 * evaluate(free.holding_power_w, across), color=FREE, lw=2.5, label="holds free fingers there"
    )
    axes.plot(place[inside], holding[inside], color=MEASURED, marker=".", label="measured, less what motion takes")
    if run.contact_s is not None:
        first = int(np.argmax(run["contact"] > 0.0))
        axes.plot(place[first], holding[first], "o", ms=8, mfc="none", mec=FOUND, mew=2, label="contact found")
    axes.invert_xaxis()
    axes.set(xlabel="normalised resistance\n(fingers close to the right)", ylabel="holding power [mW]")


def draw_force(axes: Axes, run: GripRun) -> None:
    """Draw the estimated and the measured force, from the start of closing."""
    since = run["time_s"] - REST_S
    shown = since > 0.0
    if "endpoint_force_n" in run:
        axes.plot(since[shown], run["endpoint_force_n"][shown], color=FREE, lw=2.5, label="load cell")
    axes.plot(since[shown], run["estimated_grip_force_n"][shown], color=MEASURED, label="estimated")
    if run.contact_s is not None:
        axes.axvline(run.contact_s, color=FOUND, ls=":", label="contact found")
    axes.axhline(run.target_n, color="black", lw=0.8, ls="--", label=f"target, {run.target_n:g} N")
    axes.set(xlabel="time since closing began [s]", ylabel="grip force [N]")
