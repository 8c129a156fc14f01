"""Figures of a calibration: measurement, fit and residuals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from musclewire.arrays import FloatArray
from musclewire.figures import figure_style, new_figure
from musclewire.identify._physical.calibration import Calibration
from musclewire.identify._physical.driven import DrivenObservation
from musclewire.identify._physical.isobaric import IsobaricObservation
from musclewire.identify._physical.observations import ChannelComparison, Observation
from musclewire.pages import AVERAGE, HEATING, TARGET

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ZERO_CELSIUS_K = 273.15
MEASURED, FITTED = TARGET, HEATING
# Isobars from the lightest load to the heaviest.
SHADES = ("#7fb3c8", "#4a93ae", "#1f6f8b", "#15506a", "#0d374c", "#071f2d")
WIDTH, ROW_HEIGHT = 9.6, 2.75
# Resistance less certain than this fraction of its range is not drawn against strain.
MAX_UNCERTAIN_FRACTION = 0.12


class DisplayUnit(NamedTuple):
    """Axis label of a channel, with factor and offset from SI to the unit displayed."""

    label: str
    factor: float
    offset: float = 0.0


DISPLAY = {
    "resistance": DisplayUnit("resistance [ohm]", 1.0),
    "strain": DisplayUnit("strain [%]", 100.0),
    "force": DisplayUnit("contraction\nforce [N]", 1.0),
    "temperature": DisplayUnit("temperature [°C]", 1.0, -ZERO_CELSIUS_K),
}
RESIDUAL_UNIT = {"resistance": "mohm", "strain": "% strain", "force": "mN", "temperature": "K"}
RESIDUAL_FACTOR = {"resistance": 1e3, "strain": 100.0, "force": 1e3, "temperature": 1.0}


def channel_axes(calibration: Calibration, *, style: str = "screen") -> Axes:
    """Draw the channels of the first recording, or its isobars, measured and fitted, over their residuals, with pyplot.

    Parameters
    ----------
    calibration
        The calibration with its observations.
    style
        Size and fonts of the figure, as in ``Recording.plot``.

    Returns
    -------
    The axes of the first channel. A style whose height has no room for residuals, as a slide's, shows none.

    Raises
    ------
    CallerError
        For an unknown style; the message suggests the nearest.
    """
    first, found = calibration.problem.observations[0], figure_style(style)
    pairs = compared(calibration, first)
    isobars = isinstance(first, IsobaricObservation)
    height_mm = found.panel_height_mm * (2.0 if isobars else 1.4 * len(pairs) + 0.3)
    # A slide has no room for residuals below each of three channels.
    fits = not found.max_height_mm or height_mm <= found.max_height_mm
    figure = new_figure(style, height_mm, by_pyplot=True)
    with figure.styled():
        return draw_isobars(figure, pairs) if isobars else draw_channels(figure, pairs, residuals=fits)


def compared(calibration: Calibration, observation: Observation) -> list[ChannelComparison]:
    """Return the channels of one observation with their fit."""
    ours = {id(channel) for channel in observation.channels}
    return [pair for _, pair in calibration.comparisons() if id(pair.channel) in ours]


def observation_figure(calibration: Calibration, observation: Observation) -> Figure:
    """Draw every channel of an observation, measured and fitted, with the residuals below."""
    pairs = compared(calibration, observation)
    if isinstance(observation, IsobaricObservation):
        return isobar_figure(pairs)
    figure = Figure(figsize=(WIDTH, ROW_HEIGHT * len(pairs) + 0.3), layout="constrained")
    draw_channels(figure, pairs)
    return figure


def draw_channels(figure: Figure, pairs: Sequence[ChannelComparison], *, residuals: bool = True) -> Axes:
    """Draw channels over time, each above its residuals if these are wanted; return the first axes."""
    heights = ((3, 1) if residuals else (3,)) * len(pairs)
    rows = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    for top, pair in zip(rows[:: 1 + residuals], pairs, strict=True):
        shown = DISPLAY[pair.channel.name]
        axis = pair.channel.axis
        top.plot(axis, shown.factor * pair.channel.measured + shown.offset, color=MEASURED, linewidth=3.2,
                 label="measured", solid_capstyle="round")  # fmt: skip
        top.plot(axis, shown.factor * pair.predicted + shown.offset, color=FITTED, linewidth=1.2, label="fitted wire")
        top.set(ylabel=shown.label, ylim=limits(shown.factor * pair.predicted + shown.offset))
    for below, pair in zip(rows[1::2] if residuals else (), pairs, strict=False):
        draw_residuals(below, pair.channel.axis, pair)
    rows[0].legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0.0, ncols=2)
    rows[-1].set(xlabel="time [s]")
    first: Axes = rows[0]
    return first


def limits(predicted: FloatArray) -> tuple[float, float]:
    """Return axis limits around a fitted curve that include the measurement, but not outliers of its noise."""
    low, high = float(predicted.min()), float(predicted.max())
    margin = 0.15 * (high - low) or 1.0
    return low - margin, high + margin


def draw_residuals(axes: Axes, axis: FloatArray, pair: ChannelComparison, colour: str = AVERAGE) -> None:
    """Draw residuals, with the uncertainty of the channel as a band."""
    name = pair.channel.name.split(" ")[0]
    factor = RESIDUAL_FACTOR[name]
    band = factor * pair.channel.uncertainty
    axes.fill_between(axis, -band, band, color=TARGET, alpha=0.22, linewidth=0)
    axes.axhline(0.0, color="#999999", linewidth=0.7)
    axes.plot(axis, factor * (pair.predicted - pair.channel.measured), color=colour, linewidth=0.9)
    axes.set_ylabel(f"residual\n[{RESIDUAL_UNIT[name]}]", fontsize=8)
    axes.tick_params(labelsize=8)


def loop_figure(calibration: Calibration, observation: Observation) -> Figure | None:
    """Draw strain (or force) against resistance, measured and fitted; None unless both were recorded."""
    pairs = {pair.channel.name: pair for pair in compared(calibration, observation)}
    other = next((name for name in ("strain", "force") if name in pairs), None)
    if not isinstance(observation, DrivenObservation) or other is None or "resistance" not in pairs:
        return None
    resistance, quantity = pairs["resistance"], pairs[other]
    shown = DISPLAY[other]
    # Bins without a current have no resistance; the others are matched by their times.
    times, here, there = np.intersect1d(resistance.channel.axis, quantity.channel.axis, return_indices=True)
    # At very low current the resistance is mostly noise.
    uncertain = resistance.channel.uncertainty > MAX_UNCERTAIN_FRACTION * np.ptp(resistance.predicted)
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    axes, over_drive = figure.subplots(1, 2)
    lines = (
        (
            np.where(uncertain, np.nan, resistance.channel.measured),
            quantity.channel.measured,
            MEASURED,
            3.2,
            "measured",
        ),
        (resistance.predicted, quantity.predicted, FITTED, 1.2, "fitted wire"),
    )
    for abscissa, ordinate, colour, width, label in lines:
        axes.plot(abscissa[here], shown.factor * ordinate[there], color=colour, linewidth=width, label=label)
    axes.set(xlabel="resistance [ohm]", ylabel=shown.label, title="Against resistance")
    axes.legend(loc="upper right")
    drive = observation.drive_at(times)
    for ordinate, colour, width in ((quantity.channel.measured, MEASURED, 3.2), (quantity.predicted, FITTED, 1.2)):
        over_drive.plot(drive, shown.factor * ordinate[there], color=colour, linewidth=width)
    over_drive.set(xlabel="drive [V]", title="Against the drive")
    return figure


def isobar_figure(pairs: Sequence[ChannelComparison]) -> Figure:
    """Draw strain against temperature for every stress, measured and fitted, with the residuals below."""
    figure = Figure(figsize=(WIDTH, 6.0), layout="constrained")
    draw_isobars(figure, pairs)
    return figure


def draw_isobars(figure: Figure, pairs: Sequence[ChannelComparison]) -> Axes:
    """Draw isobars above their residuals; return the first axes."""
    top: Axes
    top, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    for place, pair in enumerate(pairs):
        shade = SHADES[min(place * len(SHADES) // max(len(pairs), 1), len(SHADES) - 1)]
        degc = pair.channel.axis - ZERO_CELSIUS_K
        top.plot(degc, 100.0 * pair.channel.measured, color=shade, linewidth=3.4, alpha=0.35)
        top.plot(degc, 100.0 * pair.predicted, color=shade, linewidth=1.2,
                 label=pair.channel.name.removeprefix("strain at "))  # fmt: skip
        below.plot(degc, 100.0 * (pair.predicted - pair.channel.measured), color=shade, linewidth=0.9)
    top.set(ylabel="strain, elongation [%]", title="Thick and pale: measured; thin: fitted wire")
    top.legend(loc="upper right")
    below.axhline(0.0, color="#999999", linewidth=0.7)
    below.set(xlabel="temperature [°C]", ylabel="residual [%]")
    return top
