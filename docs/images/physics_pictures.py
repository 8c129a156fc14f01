"""The pictures of docs/explanation/physics.md, from the simulated wire as shipped."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from physics_runs import (
    Branch,
    FloatArray,
    LoopTruth,
    Parts,
    constants_of_wire,
    parts_of_the_difference,
    slow_loop,
)
from scipy.special import ndtri

from musclewire.identify import IsobaricLoop, IsobarSummary, simulated_isobar, summarize_isobar
from musclewire.pages import AVERAGE, COOLING, HEATING, PAPER, TARGET
from musclewire.parameters import load_alloy, load_bench, load_wire, read_published
from musclewire.wire import SHAPE, WireConstants, cooled_wire, thresholds_at, two_populations

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AUSTENITE, R_PHASE, MARTENSITE = "#d39a2d", "#3f8f4f", "#5b5ea6"
ZERO_DEGC_K = 273.15
MPA = 1e6
MAIN_WIRE, ISOBAR_WIRE = "paper-100um", "isobar-sample"
BRANCHES = ("heating", "cooling")
SHADES_PCT = (20, 50, 100)
SHADE_COLOURS = ("#d5ecd4", "#8cc88a")
SHADE_WORDS = ("20 to 50 % R-phase, cooled at that stress", "more than 50 % R-phase")
DIAGRAM_DEGC, DIAGRAM_MPA = (20.0, 150.0), (0.0, 300.0)


# ---- why pretension closes the gap -----------------------------------------------------------------------------------


def pretension_figure(loops: tuple[LoopTruth, ...]) -> Figure:
    """Draw phases, resistance and what separates the branches, over contraction, for three pretensions."""
    figure = Figure(figsize=(10.4, 9.6), layout="constrained")
    rows = figure.subplots(3, len(loops), sharex=True, sharey="row", height_ratios=(1.15, 1.0, 1.0))
    figure.suptitle("Simulated 125 µm wire on the paper's spring: one slow cycle at three pretensions")
    for column, loop in enumerate(loops):
        phases, resistance, difference = rows[:, column]
        leg_mpa = loop.pretension_n / (loop.constants.legs * loop.constants.area_m2) / MPA
        phases.set_title(
            f"pretension {loop.pretension_n:.2f} N ({leg_mpa:.0f} MPa)\nstrain gap {100.0 * loop.strain_gap:.1f} %"
        )
        draw_phases(phases, loop)
        draw_resistance(resistance, loop)
        draw_parts(difference, parts_of_the_difference(loop))
        difference.set_xlabel("contraction [%]")
    label_phases(rows[0, 0], rows[0, -1], loops[0])
    label_branches(rows[1, 0], loops[0])
    figure.legend(*rows[2, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    rows[0, 0].set_ylabel("phase fraction [%]\nheating solid, cooling dashed")
    rows[1, 0].set_ylabel("resistance [ohm]")
    rows[2, 0].set_ylabel("resistance on heating\nless that on cooling [mohm]")
    return figure


def draw_phases(axes: Axes, loop: LoopTruth) -> None:
    """Draw the fractions of the three phases on both branches; R-phase is filled."""
    for phase, colour in (("austenite", AUSTENITE), ("martensite", MARTENSITE), ("r_phase", R_PHASE)):
        for branch, line in ((loop.heating, "-"), (loop.cooling, "--")):
            axes.plot(100.0 * branch.contraction, 100.0 * getattr(branch, phase), line, color=colour, linewidth=1.4)
    for branch in (loop.heating, loop.cooling):
        axes.fill_between(100.0 * branch.contraction, 100.0 * branch.r_phase, color=R_PHASE, alpha=0.17, linewidth=0)
    axes.set_ylim(-2.0, 102.0)


def label_phases(first: Axes, last: Axes, loop: LoopTruth) -> None:
    """Write the phases' names: R-phase above its peak, the others where their lines are straight."""
    branch = max(loop.heating, loop.cooling, key=lambda each: float(each.r_phase.max()))
    peak = int(np.argmax(branch.r_phase))
    first.annotate(
        "R-phase", (100.0 * branch.contraction[peak], 100.0 * branch.r_phase[peak]), xytext=(0, 4),
        textcoords="offset points", color=R_PHASE, fontweight="bold", ha="center", va="bottom",
        path_effects=[withStroke(linewidth=3.0, foreground="white")],
    )  # fmt: skip
    last.text(0.22, 0.90, "martensite", color=MARTENSITE, fontweight="bold", transform=last.transAxes)
    last.text(0.99, 0.93, "austenite", color=AUSTENITE, fontweight="bold", transform=last.transAxes, ha="right")


def draw_resistance(axes: Axes, loop: LoopTruth) -> None:
    """Draw resistance over contraction, with the temperatures that both branches have at half the stroke."""
    for branch, colour in ((loop.heating, HEATING), (loop.cooling, COOLING)):
        axes.plot(100.0 * branch.contraction, branch.resistance_ohm, color=colour)
    half = 0.5 * loop.shared_contraction[1]
    for branch, colour, offset in ((loop.heating, HEATING, (-34, -34)), (loop.cooling, COOLING, (28, 28))):
        row = int(np.argmin(np.abs(branch.contraction - half)))
        place = (100.0 * branch.contraction[row], branch.resistance_ohm[row])
        axes.plot(*place, "o", color=colour, markersize=4.5, zorder=5)
        axes.annotate(
            f"{branch.temperature_k[row] - ZERO_DEGC_K:.0f} °C",
            place,
            xytext=offset,
            textcoords="offset points",
            color=colour,
            ha="center",
            va="center",
            arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.8},
        )


def label_branches(axes: Axes, loop: LoopTruth) -> None:
    """Write the branches' names into a corner."""
    axes.text(0.97, 0.93, "cooling", color=COOLING, fontweight="bold", transform=axes.transAxes, ha="right")
    axes.text(0.97, 0.83, "heating", color=HEATING, fontweight="bold", transform=axes.transAxes, ha="right")
    axes.margins(x=0.02)
    axes.set_xlim(-2.0 * loop.shared_contraction[1], 104.0 * loop.shared_contraction[1])


def draw_parts(axes: Axes, parts: Parts) -> None:
    """Draw the resistance on heating less that on cooling at equal strain, and the two effects that cause it."""
    strain = 100.0 * parts.contraction
    axes.fill_between(strain, 1e3 * parts.hotter, color=HEATING, alpha=0.3, linewidth=0, label="as heating is hotter")
    axes.fill_between(
        strain, 1e3 * parts.r_phase, color=R_PHASE, alpha=0.3, linewidth=0, label="as one branch has more R-phase"
    )
    axes.plot(strain, 1e3 * parts.rest, ":", color="#777777", linewidth=1.1, label="geometry and martensite fraction")
    axes.plot(strain, 1e3 * parts.whole, color=AVERAGE, linewidth=1.9, label="all together")
    axes.axhline(0.0, color="#555555", linewidth=0.8)


# ---- isobars ---------------------------------------------------------------------------------------------------------


def isobar_figure() -> Figure:
    """Draw simulated isobars with the published points of measured Flexinol on them."""
    published = read_published("flexinol_isobars")
    wire = load_wire(ISOBAR_WIRE)
    alloy, bench = load_alloy(wire.alloy), load_bench("dead-weight")
    figure = Figure(figsize=(10.4, 4.3), layout="constrained")
    columns = figure.subplots(1, len(published["stress_mpa"]), sharey=True)
    for column, (axes, stress_mpa) in enumerate(zip(columns, published["stress_mpa"], strict=True)):
        loop = simulated_isobar(alloy, wire, bench, MPA * stress_mpa)
        draw_isobar(axes, loop)
        draw_published_isobar(axes, published, column)
        measured = (published["stroke_pct"][column], *(published[f"{b}_degc"][column][1] for b in BRANCHES))
        axes.set_title(title_of(stress_mpa, summarize_isobar(loop), measured), fontsize=9.5)
        axes.set_xlabel("temperature [°C]")
    columns[0].set_ylabel("strain above the hot wire's [%]")
    columns[0].set_ylim(bottom=-0.15)
    columns[0].legend(loc="upper right", fontsize=8.5)
    return figure


def draw_isobar(axes: Axes, loop: IsobaricLoop) -> None:
    """Draw heating and cooling of one simulated isobar."""
    hottest = int(np.argmax(loop.temperature_k))
    strain = 100.0 * (loop.strain - loop.strain.min())
    kelvin = loop.temperature_k - ZERO_DEGC_K
    axes.plot(kelvin[: hottest + 1], strain[: hottest + 1], color=HEATING, label="heating, simulated")
    axes.plot(kelvin[hottest:], strain[hottest:], color=COOLING, label="cooling, simulated")


def draw_published_isobar(axes: Axes, published: dict[str, list[list[float]]], column: int) -> None:
    """Draw the temperatures at which 10, 50 and 90 % of the measured stroke are done, on both branches."""
    stroke = np.asarray(published["stroke_pct"])[column]
    done = np.array([0.1, 0.5, 0.9])
    places = (
        (published["heating_degc"][column], (1.0 - done) * stroke, "o", HEATING, "10, 50, 90 % done, measured"),
        (published["cooling_degc"][column], done * stroke, "o", COOLING, None),
    )
    for degc, strain, marker, colour, label in places:
        axes.plot(
            degc, strain, marker, markersize=6.5, markerfacecolor="white", markeredgecolor=colour,
            markeredgewidth=1.8, zorder=5, label=label,
        )  # fmt: skip


def title_of(stress_mpa: float, ours: IsobarSummary, measured: tuple[float, float, float]) -> str:
    """Return stress, stroke and half-transformation temperatures, simulated and measured, in three lines."""
    heating, cooling = (each[1] - ZERO_DEGC_K for each in (ours.heating_k, ours.cooling_k))
    return (
        f"{stress_mpa:g} MPa\nstroke {100.0 * ours.stroke:.2f} % (measured {measured[0]:.2f})\n"
        f"half at {heating:.1f}, {cooling:.1f} °C ({measured[1]:.1f}, {measured[2]:.1f})"
    )


# ---- grains ----------------------------------------------------------------------------------------------------------


def grains_figure() -> Figure:
    """Draw how the temperatures of balance spread over the grains, and what that makes of a heating wire."""
    constants = constants_of_wire(ISOBAR_WIRE)
    alloy = load_alloy(load_wire(ISOBAR_WIRE).alloy).values()
    figure = Figure(figsize=(10.4, 4.1), layout="constrained")
    left, right = figure.subplots(1, 2)
    quantile = np.linspace(-3.2, 3.2, 4001)
    offset = two_populations(quantile, *(alloy[name] for name in SHAPE))
    density = np.exp(-0.5 * quantile**2) / np.sqrt(2.0 * np.pi) / np.gradient(offset, quantile)
    for stress_mpa, colour in ((0.0, "#b9a6d9"), (100.0, "#8a5fbf"), (200.0, "#4b2a7b")):
        spread = constants.martensite_spread_k + constants.martensite_spread_per_pa * MPA * stress_mpa
        middle = balance_k(constants, MPA * stress_mpa) - ZERO_DEGC_K
        left.plot(middle + spread * offset, 100.0 * density / spread, color=colour)
        left.lines[-1].set_label(f"the shipped alloy, {stress_mpa:g} MPa")
    spread = constants.martensite_spread_k
    normal = spread * half_width(offset, quantile) / ndtri(0.75)
    middle = balance_k(constants, 0.0) - ZERO_DEGC_K
    kelvin = np.linspace(middle - 60.0, middle + 60.0, 600)
    left.plot(kelvin, 100.0 * np.exp(-0.5 * ((kelvin - middle) / normal) ** 2) / normal / np.sqrt(2.0 * np.pi), "--",
              color=TARGET, linewidth=1.2, label="normal, same middle half, 0 MPa")  # fmt: skip
    left.set_ylim(0.0, 1.42 * left.get_ylim()[1])
    left.set_xlim(middle - 42.0, balance_k(constants, 200.0 * MPA) - ZERO_DEGC_K + 42.0)
    left.set(
        xlabel="temperature of balance between austenite and martensite [°C]",
        ylabel="density of grains [% per K]",
        title="How grains differ, without and with load",
    )
    left.legend(loc="upper right", fontsize=8.5)
    draw_transformed_fraction(right, normal)
    return figure


def draw_transformed_fraction(axes: Axes, normal_k: float) -> None:
    """Draw the fraction of its strain that a heated wire has lost at 100 MPa, with its grains and with normal ones."""
    wire = load_wire(ISOBAR_WIRE)
    alloy, bench = load_alloy(wire.alloy), load_bench("dead-weight")
    plain = {"grain_skew": 0.0, "grain_tail": 0.0, "early_fraction": 0.0, "martensite_spread_k": normal_k}
    normal = alloy.model_copy(
        update={name: getattr(alloy, name).model_copy(update={"value": value}) for name, value in plain.items()}
    )
    for each, line, colour, words in (
        (normal, "--", TARGET, "with a normal distribution"),
        (alloy, "-", HEATING, "the shipped alloy"),
    ):
        loop = simulated_isobar(each, wire, bench, 100.0 * MPA)
        up = slice(0, int(np.argmax(loop.temperature_k)) + 1)
        lost = (loop.strain.max() - loop.strain[up]) / np.ptp(loop.strain)
        axes.plot(loop.temperature_k[up] - ZERO_DEGC_K, 100.0 * lost, line, color=colour, label=words)
    published = read_published("flexinol_isobars")
    place = published["stress_mpa"].index(100.0)
    axes.plot(published["heating_degc"][place], [10, 50, 90], "o", markersize=6.5, markerfacecolor="white",
              markeredgecolor=PAPER, markeredgewidth=1.8, zorder=5, label="measured")  # fmt: skip
    axes.set(xlabel="temperature [°C]", ylabel="strain recovered [%]", title="What that makes of heating, 100 MPa")
    axes.legend(loc="upper left", fontsize=8.5)


def half_width(offset: FloatArray, quantile: FloatArray) -> float:
    """Return half of the distance between the quartiles."""
    low, high = np.interp([ndtri(0.25), ndtri(0.75)], quantile, offset)
    return float(0.5 * (high - low))


def balance_k(constants: WireConstants, stress_pa: float) -> float:
    """Return where austenite and martensite of the middle grain are in balance."""
    return constants.martensite_temperature_k + stress_pa / constants.martensite_stress_rate_pa_per_k


# ---- phase diagram ---------------------------------------------------------------------------------------------------


def diagram_figure(loops: tuple[LoopTruth, ...]) -> Figure:
    """Draw where phases change over temperature and stress, the R-phase on cooling, and the paths of the loops."""
    main = slow_loop(constants_of_wire(MAIN_WIRE), MAIN_WIRE)
    figure = Figure(figsize=(10.4, 5.3), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, paths, words in (
        (panels[0], (main,), "100 µm, as in Fig. 9 of the paper"),
        (panels[1], loops, "125 µm, as in Fig. 4 of the paper"),
    ):
        shade_r_phase(axes, paths[0].constants)
        draw_lines(axes, paths[0].constants)
        for loop in paths:
            draw_path(axes, loop)
        axes.set(xlim=DIAGRAM_DEGC, ylim=DIAGRAM_MPA, xlabel="temperature [°C]", title=words)
        axes.grid(visible=False)
    name_branches(panels[0], main)
    panels[0].set_ylabel("stress in one leg [MPa]")
    shades = [Patch(color=colour, label=words) for colour, words in zip(SHADE_COLOURS, SHADE_WORDS, strict=True)]
    figure.legend(handles=[*panels[0].get_legend_handles_labels()[0], *shades], loc="outside lower center", ncols=3)
    return figure


def shade_r_phase(axes: Axes, constants: WireConstants) -> None:
    """Shade where a fifth and where half of the wire is R-phase, cooled there from hot at that stress."""
    degc, mpa = np.linspace(*DIAGRAM_DEGC, 141), np.linspace(*DIAGRAM_MPA, 76)
    cooled = [[cooled_wire(constants, MPA * s, t + ZERO_DEGC_K).r_phase_fraction for t in degc] for s in mpa]
    axes.contourf(degc, mpa, 100.0 * np.array(cooled), levels=SHADES_PCT, colors=SHADE_COLOURS)


def name_branches(axes: Axes, loop: LoopTruth) -> None:
    """Write which way is heating and which cooling, next to them."""
    for name, colour, offset, side in (("heating", HEATING, (8, -4), "left"), ("cooling", COOLING, (-8, 6), "right")):
        branch: Branch = getattr(loop, name)
        row = int(np.argmin(np.abs(branch.contraction - 0.6 * loop.shared_contraction[1])))
        place = (branch.temperature_k[row] - ZERO_DEGC_K, branch.stress_pa[row] / MPA)
        axes.annotate(name, place, xytext=offset, textcoords="offset points", color=colour, ha=side, weight="bold")


def draw_lines(axes: Axes, constants: WireConstants) -> None:
    """Draw where the middle grain's phase changes are due, each in the colour of the phase that forms."""
    mpa = np.linspace(*DIAGRAM_MPA, 80)
    for name, colour, dashes, words in (
        ("austenite_r_phase", R_PHASE, ":", "on cooling, austenite to R-phase"),
        ("austenite_martensite", MARTENSITE, "--", "on cooling, austenite to martensite"),
        ("martensite_austenite", AUSTENITE, "-.", "on heating, martensite to austenite"),
    ):
        line = np.array([due_degc(constants, MPA * s, name) for s in mpa])
        axes.plot(line, mpa, dashes, color=colour, linewidth=1.8, label=words)


def due_degc(constants: WireConstants, stress_pa: float, change: str) -> float:
    """Return the temperature at which a change is due for the middle grain: its threshold is at an offset of 0."""
    low, high = 100.0, 700.0
    cooling = change in ("austenite_martensite", "austenite_r_phase", "r_phase_martensite")
    derived = constants.derived.record
    for _ in range(50):
        middle = 0.5 * (low + high)
        threshold = getattr(thresholds_at(derived, middle, stress_pa, 1.0, 0.0), change)
        # Cooling moves fronts down to a threshold, heating up to it.
        due = threshold < 0.0 if cooling else threshold > 0.0
        low, high = (middle, high) if due == cooling else (low, middle)
    return 0.5 * (low + high) - ZERO_DEGC_K


def draw_path(axes: Axes, loop: LoopTruth) -> None:
    """Draw the way of one loop through the diagram, with arrows, and its pretension at the hot end."""
    for name, colour in (("heating", HEATING), ("cooling", COOLING)):
        branch: Branch = getattr(loop, name)
        degc, mpa = branch.temperature_k - ZERO_DEGC_K, branch.stress_pa / MPA
        axes.plot(degc, mpa, color=colour, linewidth=2.0)
        row = int(np.argmin(np.abs(branch.contraction - 0.5 * loop.shared_contraction[1])))
        axes.annotate(
            "", (degc[row + 20], mpa[row + 20]), (degc[row], mpa[row]), zorder=6,
            arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 16, "linewidth": 0.0},
        )  # fmt: skip
    kelvin = np.concatenate([loop.heating.temperature_k, loop.cooling.temperature_k])
    stress = np.concatenate([loop.heating.stress_pa, loop.cooling.stress_pa])
    hottest = int(np.argmax(kelvin))
    axes.annotate(
        f"{loop.pretension_n:.2f} N", (kelvin[hottest] - ZERO_DEGC_K, stress[hottest] / MPA), xytext=(5, 0),
        textcoords="offset points", fontsize=9, color=AVERAGE, va="center",
    )  # fmt: skip
