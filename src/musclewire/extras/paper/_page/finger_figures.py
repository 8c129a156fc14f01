"""The figures of section IV drawn from our runs and designs, with every number that the paper prints in purple."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from musclewire.arrays import FloatArray
from musclewire.experiment import elapsed
from musclewire.extras.paper._page.paper_drawing import (
    SHADES,
    SIZE,
    draw_loop,
    error_bars,
    one_panel,
    pretension_legend,
    printed_line,
    ramp,
)
from musclewire.extras.paper._reproduce.designed_parts import paper_pretensioner, schemes_of_fig13
from musclewire.extras.paper._reproduce.finger_runs import COMMON_WIRE, FINGER_WIRE, pretension_n
from musclewire.extras.paper._reproduce.finger_sweep import SWEEP_N, gaps_over_pretension
from musclewire.identify import required_quantity
from musclewire.pages import AVERAGE, COOLING, HEATING, PAPER
from musclewire.parameters import load_finger, read_published

if TYPE_CHECKING:
    from musclewire_design import PretensionerDesign

    from musclewire.extras.paper._reproduce.runs import RunCache

# Settings of the sweep whose loops are drawn; the others would lie on top of them.
SHOWN_N = (0.15, 0.37, 0.71, 1.15, 1.7)
ARC_POINTS = 12


def fig13a(_runs: RunCache) -> Figure:
    """Draw one finger pulled in several ways, each to the end of its range, from the design alone."""
    from musclewire_design import finger_geometry, finger_shape

    figure, axes = one_panel()
    geometry = finger_geometry(load_finger("lan-fan-2010"))
    for scheme, shade in zip(schemes_of_fig13().schemes, SHADES, strict=False):
        shape = finger_shape(geometry, scheme.angles_rad)
        label = f"{scheme.name}: range over length {scheme.range_over_length:.2f} (end: {scheme.limit})"
        outline, tendon = 1e3 * shape.outline(), 1e3 * shape.tendon(scheme.guided)
        axes.fill(*outline.T, color=shade, alpha=0.35, linewidth=0)
        axes.plot(*outline.T, color=shade, linewidth=1.0, label=label)
        axes.plot(*tendon.T, color=shade, linewidth=1.0, linestyle=":")
    axes.set(xlabel="along the finger [mm]", ylabel="across [mm]", aspect="equal")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, -0.14), fontsize=8.5)
    return figure


def fig14(_runs: RunCache) -> Figure:
    """Draw the designed pretensioner in its envelope, and both forces over the connector's travel."""
    figure = Figure(figsize=SIZE, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.2))
    made, paper = paper_pretensioner(), read_published("lan_fan_2010")
    outline = 1e3 * serpentine_outline(made)
    left.fill(*outline.T, color=COOLING, alpha=0.85, linewidth=0)
    width, height = paper["pretensioner"]["envelope_mm"][:2]
    left.add_patch(box(-0.5 * width, 0.0, width, height))
    left.annotate(f"paper: {width} x {height} mm", (0.0, height), xytext=(0, 3), textcoords="offset points",
                  ha="center", color=PAPER, fontsize=8.5)  # fmt: skip
    left.set(aspect="equal", xlabel="across the wire [mm]", ylabel="along it [mm]")
    left.grid(visible=False)
    curve = load_finger("lan-fan-2010").curve
    travel = 1e3 * np.asarray(curve.tendon_travel_m)
    both = (
        ("pretensioner", made.stiffness_n_per_m * travel / 1e3, COOLING, paper["pretensioner"]["stiffness_n_per_m"]),
        ("finger", np.asarray(curve.tendon_force_n), HEATING, paper["finger"]["stiffness_n_per_m"]),
    )
    for name, force, shade, printed in both:
        right.plot(travel, force, color=shade, linewidth=2.6, alpha=0.6, label=f"ours, {name}")
        right.plot(travel, printed * travel / 1e3, color=PAPER, linestyle=":", linewidth=1.8,
                   label=f"paper, {printed:g} N/m")  # fmt: skip
    right.set(xlabel="connector's travel [mm]", ylabel="force along the wire [N]", xlim=(0, 1.4), ylim=(0, None))
    right.legend(fontsize=8.5)
    return figure


def serpentine_outline(made: PretensionerDesign) -> FloatArray:
    """Return the outline of a designed pretensioner as points, (n, 2) [m], its arcs in short chords."""
    from musclewire_design import serpentine_drawing

    ring = serpentine_drawing(made.geometry, "").outline
    points = []
    for start, end in zip(ring, (*ring[1:], ring[0]), strict=True):
        chord = complex(end.x_m - start.x_m, end.y_m - start.y_m)
        turn = 4.0 * math.atan(start.bulge)
        for fraction in np.linspace(0.0, 1.0, ARC_POINTS, endpoint=False) if start.bulge else (0.0,):
            # A chord to a point of an arc is as long as the sine of half the angle to it, and turned by the rest.
            part = (
                chord * fraction
                if not turn
                else chord
                * math.sin(0.5 * turn * fraction)
                / math.sin(0.5 * turn)
                * (complex(math.cos(0.5 * turn * (1.0 - fraction)), -math.sin(0.5 * turn * (1.0 - fraction))))
            )
            points.append((start.x_m + part.real, start.y_m + part.imag))
    return np.array(points)


def box(left: float, bottom: float, width: float, height: float) -> Any:
    """Return a dotted frame in the paper's colour."""
    from matplotlib.patches import Rectangle

    return Rectangle((left, bottom), width, height, fill=False, edgecolor=PAPER, linestyle=":", linewidth=1.4)


def fig15(runs: RunCache) -> Figure:
    """Draw how the tendon's zero is found: force of the cold wire over the position of Linear Stage 2."""
    figure, axes = one_panel()
    found = runs.finger.tendon_zero
    place, zero = -1e6 * found.positions_m, -1e6 * found.slack_m
    level = found.force_n[found.positions_m > found.slack_m].mean()
    axes.plot(place, found.force_n, "o", color=COOLING, markersize=4, label="load cell, mean of ten samples")
    line = np.linspace(place[0], place[-1], 400)
    rise = found.tendon_stiffness_n_per_m * np.maximum(line - zero, 0.0) / 1e6
    axes.plot(line, level + rise, color=AVERAGE, linewidth=1.0,
              label=f"level line and {found.tendon_stiffness_n_per_m:.0f} N/m")  # fmt: skip
    axes.axvline(zero, color=HEATING, linewidth=1.0)
    axes.annotate(f"tendon straight, no force: {zero:+.2f} um", (zero, 0.97), xycoords=("data", "axes fraction"),
                  xytext=(-6, 0), textcoords="offset points", ha="right", va="top", color=HEATING,
                  fontsize=9)  # fmt: skip
    axes.set(xlabel="Linear Stage 2, drawn back [um]", ylabel="force of the cold wire [N]")
    axes.legend(loc="center left")
    return figure


def fig16(runs: RunCache) -> Figure:
    """Draw endpoint displacement over resistance for several pretensions."""
    figure, axes = one_panel()
    for force, shade in zip(SHOWN_N, ramp(len(SHOWN_N)), strict=True):
        loop = runs.finger.loop(force)
        chosen = force == pretension_n()
        label = f"{force:.2f} N: gap {loop.displacement_gap_pct:.2f} %"
        if chosen:
            label += f", paper {read_published('lan_fan_2010')['displacement_gap']['displacement_gap_pct']:.3f} %"
        draw_loop(axes, loop, "displacement", 1e3, (shade, shade), (label, None), linewidth=2.0 if chosen else 1.0)
    axes.set(xlabel="resistance [ohm]", ylabel="endpoint displacement [mm]")
    pretension_legend(axes)
    return figure


def fig17(runs: RunCache) -> Figure:
    """Draw displacement and force gap over pretension, for the finger's own spool and the common one."""
    figure, axes = one_panel()
    printed = read_published("lan_fan_2010")["displacement_gap"]
    axes.plot(SWEEP_N, gaps_over_pretension(runs, FINGER_WIRE), "o-", color=COOLING,
              label="displacement gap, the finger's spool")  # fmt: skip
    axes.plot(SWEEP_N, gaps_over_pretension(runs, FINGER_WIRE, "force"), "s--", color=HEATING,
              label="force gap, the finger's spool")  # fmt: skip
    axes.plot(SWEEP_N, gaps_over_pretension(runs, COMMON_WIRE), "^:", color=SHADES[2], linewidth=1.0, markersize=4,
              label="displacement gap, the spool of section III")  # fmt: skip
    axes.plot(printed["pretension_n"], printed["displacement_gap_pct"], "D", color=PAPER, markersize=9,
              markerfacecolor="none", markeredgewidth=1.6)  # fmt: skip
    printed_line(axes, printed["pretension_n"], f"paper: smallest at {printed['pretension_n']} N", 0.0)
    axes.annotate(f"paper {printed['displacement_gap_pct']} %",
                  (printed["pretension_n"], printed["displacement_gap_pct"]), xytext=(0, 9),
                  textcoords="offset points", ha="left", color=PAPER, fontsize=8.5)  # fmt: skip
    axes.set(xlabel="pretension $F_p$ [N]", ylabel="gap [% of maximum]", ylim=(0.0, None))
    axes.legend(loc="center right", bbox_to_anchor=(1.0, 0.52), fontsize=8.5)
    return figure


def fig18(runs: RunCache) -> Figure:
    """Draw the finger's staircase: desired, from resistance, laser."""
    figure, axes = one_panel()
    run = runs.finger.control_run
    time_s = elapsed(run)
    axes.plot(time_s, 1e3 * run["target_displacement_m"], color=PAPER, linewidth=2.6, alpha=0.55,
              label="desired, as printed", drawstyle="steps-post")  # fmt: skip
    axes.plot(time_s, 1e3 * required_quantity(run, "displacement"), color=COOLING, label="ours, laser")
    axes.plot(
        time_s, 1e3 * run["estimated_displacement_m"], color=HEATING, linewidth=0.9, label="ours, from resistance"
    )
    axes.set(xlabel="time [s]", ylabel="endpoint displacement [mm]", xlim=(-2.0, time_s[-1]), ylim=(1.6, 6.5))
    axes.legend(loc="lower center")
    return figure


def table3(runs: RunCache) -> Figure:
    """Draw the MAE of each step of the finger's staircase next to the paper's."""
    figure, axes = one_panel()
    metrics = runs.finger.control_run.metrics
    error_bars(axes, metrics, 3)
    axes.set_xlabel("step: endpoint displacement [mm], up and back")
    axes.set_xticks(range(len(metrics.steps)), [f"{1e3 * step.target:.1f}" for step in metrics.steps])
    axes.set_ylim(0.0, 1.15 * axes.get_ylim()[1])
    axes.legend(fontsize=8.5)
    return figure


FINGER_FIGURES: dict[str, Callable[[RunCache], Figure]] = {
    "fig13a": fig13a,
    "fig14": fig14,
    "fig15": fig15,
    "fig16": fig16,
    "fig17": fig17,
    "fig18": fig18,
    "table3": table3,
}
