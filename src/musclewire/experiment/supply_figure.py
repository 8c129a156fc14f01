"""The figure of a supply's sizing: contraction, temperature and current of the simulated drive over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from musclewire.experiment.supply_sizing import SupplySizing

__all__ = ["drive_axes"]

WARM, COLD, INK, GREY = "#c8553d", "#1f6f8b", "#2b2b2b", "#9aa0a6"


def drive_axes(sizing: SupplySizing) -> Axes:
    """Draw contraction [%], temperature [C] and current [mA] over time [s], one above the other, with pyplot.

    Parameters
    ----------
    sizing
        A simulated drive with its numbers.

    Returns
    -------
    The uppermost axes, those of the contraction.
    """
    import matplotlib.pyplot as plt

    from musclewire.identify.catalogue_check import UNCOUNTED_STRAIN
    from musclewire.identify.sizing import OVERHEATED_K

    recording, request = sizing.recording, sizing.plan.request
    period = recording.facts.sample_period_s
    time_s = recording["time_s"] - period
    figure, (top, middle, bottom) = plt.subplots(3, 1, figsize=(7.2, 6.6), sharex=True, height_ratios=(3, 2, 2))
    contraction = 100 * recording["displacement_m"] / recording.facts.leg_length_m
    stroke = 100 * sizing.one_second.stroke
    top.plot(time_s, contraction, color=INK)
    top.axhline(stroke, color=GREY, lw=0.9, ls="--")
    top.text(time_s[-1], stroke, "full stroke ", color="#6b7075", fontsize=8.5, ha="right", va="bottom")
    top.set_ylabel("contraction [%]")
    top.set_ylim(-0.05 * stroke, 1.18 * stroke)
    mark_cooling(top, sizing, 100 * UNCOUNTED_STRAIN)
    middle.plot(time_s, recording["wire_temperature_k"] - 273.15, color=WARM)
    if sizing.numbers.temperature_peak_k > 0.85 * OVERHEATED_K:
        middle.axhline(OVERHEATED_K - 273.15, color=GREY, lw=0.9, ls="--")
        middle.text(time_s[-1], OVERHEATED_K - 273.15, "working limit (assumed) ", color="#6b7075", fontsize=8.5,
                    ha="right", va="bottom")  # fmt: skip
    middle.set_ylabel("temperature [C]\n(simulated truth)")
    bottom.plot(time_s, 1e3 * recording["shunt_voltage_v"] / recording.facts.shunt_resistance_ohm, color=COLD)
    bottom.set_ylabel("current [mA]", color=COLD)
    volts = bottom.twinx()
    volts.plot(time_s, recording["drive_voltage_v"], color=INK, lw=1.0, ls=":")
    volts.set_ylabel("supply [V], dotted")
    bottom.set_ylim(bottom=0.0)
    volts.set_ylim(0.0, 1.15 * sizing.numbers.voltage_peak_v)
    bottom.set_xlabel("time since switching on [s]")
    for axes in (top, middle, bottom):
        axes.axvspan(0.0, request.on_s, color=WARM, alpha=0.08, lw=0)
        axes.grid(color="#e6e8eb", lw=0.8)
        axes.spines["top"].set_visible(False)
        axes.spines["right"].set_visible(False)
    volts.spines["top"].set_visible(False)
    top.set_xlim(time_s[0], time_s[-1])
    top.set_title(title_of(sizing), loc="left", fontsize=10.5)
    figure.align_ylabels([top, middle, bottom])
    figure.tight_layout()
    return top  # type: ignore[no-any-return]


def mark_cooling(axes: Axes, sizing: SupplySizing, level_pct: float) -> None:
    """Mark the end of the cooling time, where there is one."""
    cooling = sizing.numbers.cooling_s
    if cooling is None:
        return
    at = sizing.plan.request.on_s + cooling
    axes.plot([at], [level_pct], "o", color=COLD, ms=5)
    axes.annotate(f"cooled after {cooling:.2f} s", (at, level_pct), xytext=(8, 8), textcoords="offset points",
                  color=COLD, fontsize=9)  # fmt: skip


def title_of(sizing: SupplySizing) -> str:
    """Return one line that says which wire, under what, driven how."""
    plan = sizing.plan
    driven = f"{1e3 * plan.current_a:.0f} mA" if plan.current_a is not None else f"{plan.supply_v:g} V"
    spring = f" on {plan.request.spring_n_per_m:g} N/m" if plan.request.spring_n_per_m else ""
    return (
        f"{plan.request.wire}, {1e3 * plan.request.length_m:g} mm, {plan.load_n:.2f} N{spring}, "
        f"{driven} for {plan.request.on_s:g} s"
    )
