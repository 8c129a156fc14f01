"""The figure of a supply's sizing: contraction, temperature and current of the simulated drive over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from musclewire.arrays import FloatArray
from musclewire.figures import panel_rows
from musclewire.pages import AVERAGE, COOLING, HEATING, TARGET

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.extras.supply._sizing import SupplySizing


def drive_axes(sizing: SupplySizing, *, style: str = "screen") -> Axes:
    """Draw contraction [%], temperature [°C] and current [mA] over time [s] with pyplot; return the uppermost axes."""
    figure, panels = panel_rows(style, (1.5, 1.0, 1.0), by_pyplot=True)
    time_s = sizing.recording["time_s"] - sizing.recording.facts.sample_period_s
    with figure.styled():
        for draw, axes in zip((draw_contraction, draw_temperature, draw_current), panels, strict=True):
            axes.axvspan(0.0, sizing.plan.request.on_s, color=HEATING, alpha=0.08, lw=0)
            draw(axes, sizing, time_s)
        panels[0].set_xlim(time_s[0], time_s[-1])
        panels[0].set_title(title_of(sizing), loc="left", wrap=True)
    return panels[0]


def draw_contraction(axes: Axes, sizing: SupplySizing, time_s: FloatArray) -> None:
    """Draw the contraction, the full stroke and the end of the cooling time."""
    from musclewire.extras.supply._catalogue_check import UNCOUNTED_STRAIN

    stroke = 100 * sizing.one_second.stroke
    axes.plot(time_s, 100 * sizing.recording["displacement_m"] / sizing.recording.facts.leg_length_m, color=AVERAGE)
    mark_level(axes, time_s[-1], stroke, "full stroke ")
    axes.set_ylabel("contraction\n[%]")
    axes.set_ylim(-0.05 * stroke, 1.18 * stroke)
    mark_cooling(axes, sizing, 100 * UNCOUNTED_STRAIN)


def draw_temperature(axes: Axes, sizing: SupplySizing, time_s: FloatArray) -> None:
    """Draw the wire's temperature, and its working limit if it comes near."""
    from musclewire.rigs import OVERHEATED_K

    axes.plot(time_s, sizing.recording["wire_temperature_k"] - 273.15, color=HEATING)
    if sizing.numbers.temperature_peak_k > 0.85 * OVERHEATED_K:
        mark_level(axes, time_s[-1], OVERHEATED_K - 273.15, "working limit (assumed) ")
    axes.set_ylabel("temperature\n[°C]")


def draw_current(axes: Axes, sizing: SupplySizing, time_s: FloatArray) -> None:
    """Draw the current, and the supply's voltage on an axis of its own."""
    recording = sizing.recording
    axes.plot(time_s, 1e3 * recording["shunt_voltage_v"] / recording.facts.shunt_resistance_ohm, color=COOLING)
    axes.set_ylabel("current\n[mA]", color=COOLING)
    volts = axes.twinx()
    volts.plot(time_s, recording["drive_voltage_v"], color=AVERAGE, ls=":")
    volts.set_ylabel("supply [V],\ndotted")
    axes.set_ylim(bottom=0.0)
    volts.set_ylim(0.0, 1.15 * sizing.numbers.voltage_peak_v)
    axes.set_xlabel("time since switching on [s]")
    volts.spines["top"].set_visible(False)


def mark_level(axes: Axes, end_s: float, level: float, text: str) -> None:
    """Mark a level by a dashed line with its name at the end."""
    axes.axhline(level, color=TARGET, lw=0.9, ls="--")
    axes.text(end_s, level, text, color="#6b7075", fontsize="small", ha="right", va="bottom")


def mark_cooling(axes: Axes, sizing: SupplySizing, level_pct: float) -> None:
    """Mark the end of the cooling time, if there is one."""
    cooling = sizing.numbers.cooling_s
    if cooling is None:
        return
    at = sizing.plan.request.on_s + cooling
    axes.plot([at], [level_pct], "o", color=COOLING)
    axes.annotate(f"cooled after {cooling:.2f} s", (at, level_pct), xytext=(8, 8), textcoords="offset points",
                  color=COOLING, fontsize="small")  # fmt: skip


def title_of(sizing: SupplySizing) -> str:
    """Return one line with wire, load and drive."""
    plan = sizing.plan
    driven = f"{1e3 * plan.current_a:.0f} mA" if plan.current_a is not None else f"{plan.supply_v:g} V"
    spring = f" on {plan.request.spring_n_per_m:g} N/m" if plan.request.spring_n_per_m else ""
    return (
        f"simulated {plan.request.wire}, {1e3 * plan.request.length_m:g} mm, {plan.load_n:.2f} N{spring}, "
        f"{driven} for {plan.request.on_s:g} s"
    )
