"""The figures of the report, each drawn as SVG text inside the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from musclewire.identify import LoopGaps, halves, mark_points, required_quantity
from musclewire.judge import resistance_reading
from musclewire.pages import AVERAGE, COOLING, HEATING, PAPER, STYLE, TARGET, svg
from musclewire.parameters import read_published
from musclewire.signals import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.experiment import ControlRun, DemoResult, PretensionSweep
    from musclewire.sensing import SensingModel

MINOR_SHADES = ("#5c6670", "#aab2ba")
WIDE_IN = 9.6  # [in] of a figure across the page
NARROW_IN = 4.7  # [in] of one across a phone: there its letters are as large as the text
# Errors are shown as they are up to here, and as powers of ten beyond: a step's first moment is ten times its end.
LINEAR_ERROR_PCT = 0.1


def report_figures(result: DemoResult) -> Mapping[str, str]:
    """Return every figure of the report as SVG, by name; those as wide as the page twice, for a phone too."""
    major = next(iter(result.loops.values()))
    with mpl.rc_context(STYLE):  # type: ignore[arg-type]  # matplotlib lists every key as a literal
        both = {
            "loops": [loops_figure(result.loops, result.gaps, width) for width in (WIDE_IN, NARROW_IN)],
            "fit": [fit_figure(result.model, result.gaps, width) for width in (WIDE_IN, NARROW_IN)],
            "staircase": [staircase_figure(result.run, width) for width in (WIDE_IN, NARROW_IN)],
        }
        one = {
            "trace": trace_figure(result.run, major, result.gaps, result.model),
            "sweep": sweep_figure(result.sweep),
        }
        return {name: for_both_widths(name, *pair) for name, pair in both.items()} | {
            name: svg(figure, name) for name, figure in one.items()
        }


def for_both_widths(name: str, wide: Figure, narrow: Figure) -> Markup:
    """Return two drawings of one figure, of which a page shows the one that fits."""
    both = Markup('<div class="wide">{}</div><div class="narrow">{}</div>')
    return both.format(svg(wide, name), svg(narrow, f"{name}-narrow"))


def loops_figure(loops: Mapping[float, Recording], gaps: LoopGaps, width_in: float = WIDE_IN) -> Figure:
    """Draw strain against drive voltage and against resistance for the three amplitudes (Fig. 3)."""
    beside = width_in > NARROW_IN
    figure = Figure(figsize=(width_in, 4.1 if beside else 7.2), layout="constrained")
    left, right = figure.subplots(*((1, 2) if beside else (2, 1)), sharey=True)
    (amplitude, major), *minor = loops.items()
    for shade, (volts, recording) in zip(MINOR_SHADES, minor, strict=False):
        last = recording["cycle"] == recording["cycle"].max()
        strain = 100.0 * required_quantity(recording)[last]
        left.plot(recording["drive_voltage_v"][last], strain, color=shade, linewidth=1.1, label=f"{volts:g} V")
        resistance = resistance_reading(recording).resistance_ohm[last]
        right.plot(resistance, strain, color=shade, linewidth=1.1)
    strain = 100.0 * required_quantity(major)
    resistance = resistance_reading(major).resistance_ohm
    for part, colour, name in zip(halves(gaps), (HEATING, COOLING), ("heating", "cooling"), strict=True):
        left.plot(major["drive_voltage_v"][part], strain[part], color=colour, label=f"{amplitude:g} V, {name}")
        right.plot(resistance[part], strain[part], color=colour)
    mark_points(right, resistance, strain, gaps)
    left.set(xlabel="drive voltage [V]", ylabel="strain [%]", title="Strain against voltage: a wide loop")
    right.set(xlabel="resistance [ohm]", ylabel="" if beside else "strain [%]",
              title="Strain against resistance: nearly closed")  # fmt: skip
    left.legend(loc="upper left")
    return figure


def fit_figure(model: SensingModel, gaps: LoopGaps, width_in: float = WIDE_IN) -> Figure:
    """Draw both branches with their polynomials, the paper's printed points, and the residuals (Fig. 9)."""
    figure = Figure(figsize=(width_in, 5.4), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    low, high = model.valid_resistance_ohm
    grid = np.linspace(low, high, 400)
    pairs = ((gaps.segments.heating, HEATING, "heating", model.strain_heating),
             (gaps.segments.cooling, COOLING, "cooling", model.strain_cooling))  # fmt: skip
    for branch, colour, name, polynomial in pairs:
        inside = (branch.resistance_ohm >= low) & (branch.resistance_ohm <= high)
        resistance, strain = branch.resistance_ohm[inside], branch.quantity[inside]
        top.plot(resistance, 100 * strain, ".", color=colour, markersize=2.5, alpha=0.45)
        top.plot(grid, 100 * np.asarray(polynomial(grid)), color=colour, linewidth=1.2, label=f"$g$ {name}")
        residual = 100.0 * (strain - np.asarray(polynomial(resistance)))
        bottom.plot(resistance, residual, ".", color=colour, markersize=2.5, alpha=0.6)
    top.plot(
        grid,
        100 * np.asarray(model.strain(grid)),
        color=AVERAGE,
        linewidth=1.2,
        linestyle="--",
        label="$g_a$, their mean",
    )
    table = read_published("lan_fan_2010")["table2"]
    printed = table["required_resistance_ohm"]
    top.plot(printed, table["desired_strain_pct"], "D", color=PAPER, markerfacecolor="none", markersize=6,
             label="paper, Table 2 (measured wire)")  # fmt: skip
    top.set(ylabel="strain [%]", title=f"Polynomials of order {model.order} from B to C")
    top.legend()
    bottom.axhline(0.0, color="#999999", linewidth=0.8)
    bottom.set(xlabel="resistance [ohm]", ylabel="residual [% strain]")
    return figure


def staircase_figure(run: ControlRun, width_in: float = WIDE_IN) -> Figure:
    """Draw target, estimate and reference over time, their errors, and the drive (Fig. 11)."""
    figure = Figure(figsize=(width_in, 6.6), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True, height_ratios=(3, 1.7, 1.2))
    approach_s = run.facts.approach_s
    time_s = run["time_s"] - run["time_s"][0] - approach_s
    target, estimated = 100 * run["target_strain"], 100 * run["estimated_strain"]
    reference = 100 * required_quantity(run)
    top.plot(time_s, target, color=TARGET, linewidth=2.6, label="target", drawstyle="steps-post")
    top.plot(time_s, reference, color=COOLING, label="reference (LVDT, not used by the loop)")
    top.plot(time_s, estimated, color=HEATING, linewidth=1.0, label="estimated from resistance")
    top.set(ylabel="strain [%]", title="Moved in steps with no displacement sensor")
    top.legend(loc="lower center", ncols=3 if width_in > NARROW_IN else 1)
    middle.plot(time_s, reference - target, color=COOLING, linewidth=1.1, label="reference - target")
    middle.plot(time_s, estimated - reference, color=HEATING, linewidth=1.0, label="estimate - reference")
    whole_errors(middle)
    middle.legend(loc="lower left", ncols=2, bbox_to_anchor=(0.0, 0.98), borderaxespad=0.0)
    bottom.plot(time_s, run["drive_voltage_v"], color=AVERAGE, linewidth=1.1)
    bottom.set(xlabel="time [s]", ylabel="drive [V]", xlim=(-approach_s, time_s[-1]))
    return figure


def whole_errors(axes: Axes) -> None:
    """Give errors an axis that shows the small ones and cuts none: linear about zero, logarithmic beyond."""
    axes.axhline(0.0, color="#999999", linewidth=0.8)
    axes.axhspan(-LINEAR_ERROR_PCT, LINEAR_ERROR_PCT, color=TARGET, alpha=0.15, linewidth=0)
    axes.set_yscale("symlog", linthresh=LINEAR_ERROR_PCT, linscale=1.0)
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.set(ylabel="error [% strain]")
    axes.annotate(f"shaded: linear, to {LINEAR_ERROR_PCT:g} %; logarithmic beyond", (1.0, 0.0), (-3, 3),
                  xycoords="axes fraction", textcoords="offset points", ha="right", color="#555555",
                  fontsize=8)  # fmt: skip


def trace_figure(run: ControlRun, major: Recording, gaps: LoopGaps, model: SensingModel) -> Figure:
    """Draw the path through the strain-resistance plane during the steps (Fig. 12)."""
    figure = Figure(figsize=(4.7, 4.1), layout="constrained")
    axes = figure.subplots()
    strain = 100.0 * required_quantity(major)
    resistance = resistance_reading(major).resistance_ohm
    for part, colour in zip(halves(gaps), (HEATING, COOLING), strict=True):
        axes.plot(resistance[part], strain[part], color=colour, linewidth=1.0, alpha=0.8)
    stepping = run["time_s"] - run["time_s"][0] > run.facts.approach_s
    axes.plot(
        run["wire_resistance_ohm"][stepping],
        100.0 * required_quantity(run)[stepping],
        ".",
        color=AVERAGE,
        markersize=2.2,
        alpha=0.6,
        label="every 0.05 s of the staircase",
    )
    axes.set(xlabel="resistance [ohm]", ylabel="strain [%]", title="Trace during the steps",
             xlim=(model.resistance_min_ohm - 0.1, model.resistance_max_ohm + 0.1))  # fmt: skip
    axes.legend(loc="upper right")
    return figure


def sweep_figure(sweep: PretensionSweep) -> Figure:
    """Draw both gaps against pretension (Fig. 6 for one wire)."""
    figure = Figure(figsize=(4.7, 4.1), layout="constrained")
    sweep.plot(figure.subplots()).set_title("Which pretension closes the loop")
    return figure
