"""The paper's figures drawn from our runs, with every number that the paper prints for them in purple."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from musclewire.errors import MusclewireError
from musclewire.experiment import elapsed
from musclewire.extras.paper._page.finger_figures import FINGER_FIGURES
from musclewire.extras.paper._page.paper_drawing import (
    SHADES,
    SIZE,
    WHITE_BOX,
    draw_loop,
    error_bars,
    one_panel,
    pretension_legend,
    printed_line,
    ramp,
)
from musclewire.extras.paper._reproduce.all_checks import tolerance_of
from musclewire.extras.paper._reproduce.measures import rank_correlation
from musclewire.extras.paper._reproduce.section2 import (
    FORCE_RATIOS,
    MIDDLE_RATIO,
    STIFFNESS_FACTORS,
    SWEEP_WIRE,
    loop_of_amplitude,
    loop_of_stiffness,
    loops_at_ratio,
    sweep_settings_n,
)
from musclewire.extras.paper._reproduce.section3 import strain_at_pct
from musclewire.extras.paper._reproduce.table1 import WIRES, diameter_label
from musclewire.identify import mark_points, required_quantity
from musclewire.pages import AVERAGE, COOLING, HEATING, PAPER, STYLE, svg
from musclewire.parameters import read_published

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.extras.paper._reproduce.runs import RunCache

ZERO_CELSIUS_K = 273.15
HELD_OUT = "#3f8f4f"


def drawn(subject: str, runs: RunCache) -> str:
    """Return a subject's figure as SVG; empty without one, the reason if its loops cannot be used."""
    if subject not in FIGURES:
        return ""
    with mpl.rc_context(STYLE):  # type: ignore[arg-type]  # matplotlib lists every key as a literal
        try:
            return svg(FIGURES[subject](runs), subject)
        except MusclewireError as error:
            return Markup('<p class="note">Cannot be drawn: {}</p>').format(error)


def fig3a(runs: RunCache) -> Figure:
    """Draw strain against voltage for the three amplitudes."""
    figure, axes = one_panel()
    for volts, shade in zip(read_published("lan_fan_2010")["setup"]["amplitude_v"], SHADES, strict=True):
        loop = loop_of_amplitude(runs, volts)
        last = loop.recording["cycle"] == loop.recording["cycle"].max()
        axes.plot(loop.recording["drive_voltage_v"][last], 100 * loop.quantity("strain")[last], color=shade,
                  label=f"ours, {volts:g} V")  # fmt: skip
        printed_line(axes, volts, f"paper {volts:g} V")
    axes.set(xlabel="drive voltage [V]", ylabel="strain [%]", ylim=(-0.1, None))
    axes.legend(loc="upper left")
    return figure


def fig3b(runs: RunCache) -> Figure:
    """Draw strain against resistance with A, B, C and the printed fraction of B to C."""
    figure, axes = one_panel()
    amplitudes = read_published("lan_fan_2010")["setup"]["amplitude_v"]
    for volts, shade in zip(amplitudes[1:], SHADES[1:], strict=True):
        minor = loop_of_amplitude(runs, volts)
        last = minor.recording["cycle"] == minor.recording["cycle"].max()
        axes.plot(minor.resistance_ohm[last], 100 * minor.quantity("strain")[last], color=shade, linewidth=1.0,
                  label=f"{volts:g} V")  # fmt: skip
    loop = runs.main_loop()
    draw_loop(axes, loop, "strain", 100.0, (HEATING, COOLING), (f"{amplitudes[0]:g} V, heating", "cooling"))
    found = loop.gaps.segments
    level = 100 * (found.strain_cold + (1.0 - read_published("lan_fan_2010")["setup"]["segment_bc_pct"] / 100.0)
                   * (found.strain_max - found.strain_cold))  # fmt: skip
    axes.axhline(level, color=PAPER, linewidth=1.0, linestyle=":")
    axes.annotate("paper: B at 15 % of the strain", (0.02, level), xycoords=("axes fraction", "data"), xytext=(0, 3),
                  textcoords="offset points", color=PAPER, fontsize=8.5)  # fmt: skip
    mark_points(axes, loop.resistance_ohm, 100 * loop.quantity("strain"), loop.gaps)
    axes.set(xlabel="resistance [ohm]", ylabel="strain [%]")
    axes.legend(loc="upper right")
    return figure


def pretension_figure(runs: RunCache, quantity: str, factor: float, printed: dict[float, float], ylabel: str) -> Figure:
    """Draw loops of the 125 um wire over pretension; ``printed`` are the paper's gaps by pretension."""
    figure, axes = one_panel()
    settings = sorted({*sweep_settings_n()[::3], *printed})
    for force, colour in zip(settings, ramp(len(settings)), strict=True):
        loop = runs.loop(SWEEP_WIRE, force)
        gap = loop.strain_gap_pct if quantity == "strain" else loop.force_gap_pct
        label = f"{force:.2f} N: gap {gap:.2f} %"
        if force in printed:
            label += f", paper {printed[force]:.3f} %"
        draw_loop(axes, loop, quantity, factor, (colour, colour), (label, None),
                  linewidth=2.0 if force in printed else 1.0)  # fmt: skip
    axes.set(xlabel="resistance [ohm]", ylabel=ylabel)
    pretension_legend(axes)
    return figure


def fig4(runs: RunCache) -> Figure:
    """Draw strain against resistance over pretension."""
    paper = read_published("lan_fan_2010")["strain_gap_125um"]
    printed = dict(zip(paper["pretension_n"], paper["strain_gap_pct"], strict=True))
    return pretension_figure(runs, "strain", 100.0, printed, "strain [%]")


def fig5(runs: RunCache) -> Figure:
    """Draw contraction force against resistance over pretension."""
    paper = read_published("lan_fan_2010")["force_gap_125um"]
    return pretension_figure(
        runs, "force", 1.0, {paper["pretension_n"]: paper["force_gap_pct"]}, "contraction force [N]"
    )


def gap_figure(runs: RunCache, quantity: str, printed: Sequence[tuple[str, float, float]]) -> Figure:
    """Draw gaps over force ratio for three wires; ``printed`` are (wire, pretension [N], gap [%])."""
    from musclewire.parameters import load_wire

    figure, axes = one_panel()
    marks = ("o", "s", "^")
    for wire, shade, mark in zip(WIRES, SHADES, marks, strict=True):
        loops = loops_at_ratio(runs, wire)
        gaps = [loop.strain_gap_pct if quantity == "strain" else loop.force_gap_pct for loop in loops]
        label = f"ours, {diameter_label(wire)}"
        if quantity == "strain":
            label += f": rank correlation {rank_correlation(FORCE_RATIOS, gaps):+.1f}"
        axes.plot(FORCE_RATIOS, gaps, marker=mark, color=shade, label=label)
        for name, force, gap in printed:
            if name == wire:
                ratio = force / load_wire(wire).maximum_force_n.value
                axes.plot(ratio, gap, marker=mark, markersize=9, markerfacecolor="none", markeredgewidth=1.6,
                          color=PAPER, linestyle="none")  # fmt: skip
                axes.annotate(f"paper {gap:g} %", (ratio, gap), xytext=(0, -15), textcoords="offset points",
                              ha="center", color=PAPER, fontsize=8.5, bbox=dict(WHITE_BOX))  # fmt: skip
    axes.set(xlabel="force ratio: pretension over maximal force", ylabel=f"{quantity} gap [%]", ylim=(0.0, None))
    axes.margins(x=0.14)
    axes.legend(loc="best")
    return figure


def fig6a(runs: RunCache) -> Figure:
    """Draw strain gap against force ratio."""
    paper = read_published("lan_fan_2010")
    main, swept = paper["loop_100um"], paper["strain_gap_125um"]
    printed = [("paper-100um", main["pretension_n"], main["strain_gap_pct"])]
    pairs = zip(swept["pretension_n"], swept["strain_gap_pct"], strict=True)
    figure = gap_figure(runs, "strain", [*printed, *(("paper-125um", force, gap) for force, gap in pairs)])
    axes = figure.axes[0]
    axes.axvspan(MIDDLE_RATIO, max(FORCE_RATIOS), color=PAPER, alpha=0.08, linewidth=0)
    axes.annotate("paper: gaps fall to the right, the least lies here", (max(FORCE_RATIOS), 0.02),
                  xycoords=("data", "axes fraction"), ha="right", color=PAPER, fontsize=8.5)  # fmt: skip
    return figure


def fig6b(runs: RunCache) -> Figure:
    """Draw force gap against force ratio."""
    paper = read_published("lan_fan_2010")["force_gap_125um"]
    return gap_figure(runs, "force", [("paper-125um", paper["pretension_n"], paper["force_gap_pct"])])


def stiffness_figure(runs: RunCache, quantity: str, factor: float, ylabel: str) -> Figure:
    """Draw loops with three springs."""
    figure, axes = one_panel()
    nominal = read_published("lan_fan_2010")["setup"]["spring_stiffness_n_per_m"]
    for times, shade in zip(STIFFNESS_FACTORS, SHADES, strict=True):
        label = f"{times * nominal:g} N/m" + (" (paper's spring)" if times == 1.0 else "")
        draw_loop(axes, loop_of_stiffness(runs, times), quantity, factor, (shade, shade), (label, None))
    axes.set(xlabel="resistance [ohm]", ylabel=ylabel)
    axes.legend(title="solid heating, dashed cooling", title_fontsize=8.5)
    return figure


def fig7(runs: RunCache) -> Figure:
    """Draw strain against resistance with three springs."""
    return stiffness_figure(runs, "strain", 100.0, "strain [%]")


def fig8(runs: RunCache) -> Figure:
    """Draw contraction force against resistance with three springs."""
    return stiffness_figure(runs, "force", 1.0, "contraction force [N]")


def fig9(runs: RunCache) -> Figure:
    """Draw the loop from B to C with its polynomials, R_min, R_max and Table 2's twelve strains."""
    figure, axes = one_panel()
    model, paper = runs.model, read_published("lan_fan_2010")
    segments = runs.main_loop().gaps.segments
    grid = np.linspace(*model.valid_resistance_ohm, 400)
    pairs = ((segments.heating, HEATING, "g_h", model.strain_heating),
             (segments.cooling, COOLING, "g_c", model.strain_cooling))  # fmt: skip
    for branch, colour, name, polynomial in pairs:
        axes.plot(branch.resistance_ohm[::3], 100 * branch.quantity[::3], ".", color=colour, markersize=2.5, alpha=0.4)
        axes.plot(grid, 100 * np.asarray(polynomial(grid)), color=colour, linewidth=1.2, label=f"ours, ${name}$")
    axes.plot(grid, 100 * np.asarray(model.strain(grid)), "--", color=AVERAGE, linewidth=1.0, label="ours, $g_a$")
    table = paper["table2"]
    for branch_name, mark, letter in (("heating", "^", "h"), ("cooling", "v", "c")):
        axes.plot(table["required_resistance_ohm"], table[f"strain_{branch_name}_pct"], mark, color=PAPER,
                  markerfacecolor="none", markersize=7, label=f"paper, $S_{letter}$ of Table 2")  # fmt: skip
    for letters, key in (("min", "resistance_min_ohm"), ("max", "resistance_max_ohm")):
        printed_line(axes, paper["loop_100um"][key], f"paper $R_{{{letters}}}$ {paper['loop_100um'][key]}", 0.0)
    axes.set(xlabel="resistance [ohm]", ylabel="strain [%]")
    axes.legend(loc="lower left", bbox_to_anchor=(0.04, 0.0))
    return figure


def table2(runs: RunCache) -> Figure:
    """Draw how far our branches are from the twelve printed strains, and the MAE of each step next to the paper's."""
    figure = Figure(figsize=(SIZE[0], 5.8), layout="constrained")
    top, bottom = figure.subplots(2, 1)
    table = read_published("lan_fan_2010")["table2"]
    desired = table["desired_strain_pct"]
    off_pct = tolerance_of("table2.strain_heating_pct")
    top.axhspan(-off_pct, off_pct, color=PAPER, alpha=0.10, linewidth=0)
    top.axhline(0.0, color=PAPER, linewidth=1.0)
    for branch, colour, mark in (("heating", HEATING, "^"), ("cooling", COOLING, "v")):
        rows = zip(table["required_resistance_ohm"], table[f"strain_{branch}_pct"], strict=True)
        off = [strain_at_pct(runs, branch=branch, ohm=ohm) - strain for ohm, strain in rows]
        top.plot(desired, off, marker=mark, color=colour, linewidth=1.0, label=f"ours less paper, {branch}")
    top.set(xlabel="desired strain [%]", ylabel="difference [% strain]", xticks=desired,
            title="Strains of Table 2; shaded: tolerance")  # fmt: skip
    top.legend(fontsize=8.5, loc="lower left", ncols=2)
    metrics = runs.control_run.metrics
    error_bars(bottom, metrics, 2)
    bottom.set(xlabel="step: strain [%], up and back", title="Error of each step (Eq. 7)")
    bottom.set_xticks(range(len(metrics.steps)), [f"{100 * step.target:.1f}" for step in metrics.steps])
    bottom.set_ylim(0.0, 1.4 * bottom.get_ylim()[1])
    bottom.legend(fontsize=8.5)
    return figure


def fig11(runs: RunCache) -> Figure:
    """Draw the staircase: the desired strains that the paper prints, estimate, and displacement sensor."""
    figure, axes = one_panel()
    run = runs.control_run
    time_s = elapsed(run)
    axes.plot(time_s, 100 * run["target_strain"], color=PAPER, linewidth=2.6, alpha=0.55,
              label="desired, as printed", drawstyle="steps-post")  # fmt: skip
    axes.plot(time_s, 100 * required_quantity(run), color=COOLING, label="ours, displacement sensor")
    axes.plot(time_s, 100 * run["estimated_strain"], color=HEATING, linewidth=0.9, label="ours, from resistance")
    axes.set(xlabel="time [s]", ylabel="strain [%]", xlim=(-2.0, time_s[-1]), ylim=(1.15, 3.2))
    axes.legend(loc="lower center")
    return figure


def fig12(runs: RunCache) -> Figure:
    """Draw the trace of the staircase over the loop it was fitted to."""
    figure, axes = one_panel()
    loop, run = runs.main_loop(), runs.control_run
    draw_loop(axes, loop, "strain", 100.0, (HEATING, COOLING), ("loop, heating", "loop, cooling"), linewidth=1.1)
    counted = elapsed(run) > 0.0
    axes.plot(run["wire_resistance_ohm"][counted], 100 * required_quantity(run)[counted], ".", color=AVERAGE,
              markersize=2.4, alpha=0.55, label="staircase, every 0.05 s")  # fmt: skip
    table = read_published("lan_fan_2010")["table2"]
    axes.plot(table["required_resistance_ohm"], table["desired_strain_pct"], "D", color=PAPER, markersize=8,
              markerfacecolor="none", markeredgewidth=1.3, label="paper, required R of Table 2")  # fmt: skip
    axes.set(xlabel="resistance [ohm]", ylabel="strain [%]", xlim=(15.2, 17.0), ylim=(1.2, 3.3))
    axes.legend(loc="upper right")
    return figure


def isobars(runs: RunCache) -> Figure:
    """Draw the simulated isobars with the published 10, 50 and 90 % points, those that no search has used dashed."""
    figure, axes = one_panel()
    published = read_published("flexinol_isobars")
    for stress, shade, points in zip(published["stress_mpa"], SHADES, isobar_points(published), strict=True):
        draw_isobar(axes, runs, stress, points, {"color": shade})
    held_out = published["held_out"]
    for stress, points in zip(held_out["stress_mpa"], isobar_points(held_out), strict=True):
        draw_isobar(axes, runs, stress, points, {"color": HELD_OUT, "linestyle": "--", "linewidth": 1.1})
    axes.plot([], [], "D", color="none", markeredgecolor=PAPER, markeredgewidth=1.5,
              label="measured: 10, 50, 90 % of the stroke")  # fmt: skip
    axes.set(xlabel="temperature [°C]", ylabel="contraction [% strain]")
    axes.legend(loc="upper left", fontsize=8.5)
    return figure


def isobar_points(published: dict[str, Any]) -> list[tuple[list[float], list[float]]]:
    """Return temperatures [C] and strains [%] of the published points of each isobar, heating and then cooling."""
    rows = zip(published["stroke_pct"], published["heating_degc"], published["cooling_degc"], strict=True)
    done = [0.1, 0.5, 0.9, 0.9, 0.5, 0.1]
    return [([*heating, *cooling], [part * stroke for part in done]) for stroke, heating, cooling in rows]


def draw_isobar(
    axes: Axes, runs: RunCache, stress_mpa: float, points: tuple[list[float], list[float]], style: dict[str, Any]
) -> None:
    """Draw one simulated isobar and the published points on it."""
    loop = runs.isobar(stress_mpa)
    lost = 100 * (loop.strain.max() - loop.strain)
    words = ", held out" if "linestyle" in style else ""
    axes.plot(loop.temperature_k - ZERO_CELSIUS_K, lost, label=f"ours, {stress_mpa:.0f} MPa{words}", **style)
    axes.plot(*points, "D", color=style["color"], markeredgecolor=PAPER, markersize=6, markeredgewidth=1.5)


FIGURES: dict[str, Callable[[RunCache], Figure]] = {
    "fig3a": fig3a,
    "fig3b": fig3b,
    "fig4": fig4,
    "fig5": fig5,
    "fig6a": fig6a,
    "fig6b": fig6b,
    "fig7": fig7,
    "fig8": fig8,
    "fig9": fig9,
    "table2": table2,
    "fig11": fig11,
    "fig12": fig12,
    **FINGER_FIGURES,
    "isobars": isobars,
}
