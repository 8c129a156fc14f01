"""The report of a calibration as one HTML file that needs no other file, with its bars and figures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from musclewire.errors import CallerError
from musclewire.extras.calibration._physical.advice import ExperimentAdvice, how_to_identify, next_experiments
from musclewire.extras.calibration._physical.calibration import FOLLOWED_WITHIN, Calibration, number
from musclewire.extras.calibration._physical.isobaric import IsobaricObservation
from musclewire.extras.calibration._physical.observations import ChannelComparison, Observation
from musclewire.extras.calibration._physical.posterior import ParameterEstimate
from musclewire.figures import figure_style, new_figure
from musclewire.pages import AVERAGE, HEATING, STYLE, TARGET, NumberCard, page, svg_in_frame
from musclewire.parameters import Alloy, Bench, Wire
from musclewire.signals import write_text_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes


PRIOR, IDENTIFIED, UNIDENTIFIED, BOUND = "#dfe3e8", "#1f6f8b", "#b9a27a", "#c8553d"
MEASURED, FITTED = TARGET, HEATING
# Isobars from the lightest load to the heaviest.
SHADES = ("#7fb3c8", "#4a93ae", "#1f6f8b", "#15506a", "#0d374c", "#071f2d")
BAR_WIDTH = 190.0  # in units of the drawing, as the height
BAR_HEIGHT = 16.0
SHOWN_STD = 3.0  # prior standard deviations over which a bar extends to either side
SURE_STD = 1.96  # standard deviations over which an interval of 95 % extends to either side
ZERO_CELSIUS_K = 273.15
WIDTH = 9.6  # [in] of a figure
ROW_HEIGHT = 2.75  # [in] of each channel in it
# Resistance less certain than this fraction of its range is not drawn against strain.
MAX_UNCERTAIN_FRACTION = 0.12
FIELDS = {**Alloy.model_fields, **Wire.model_fields, **Bench.model_fields}


class DisplayUnit(NamedTuple):
    """How a channel is drawn: axis label, factor and offset from SI; unit and factor of its residuals."""

    label: str
    factor: float
    residual_unit: str
    residual_factor: float
    offset: float = 0.0


DISPLAY = {
    "resistance": DisplayUnit("resistance [ohm]", 1.0, "mohm", 1e3),
    "strain": DisplayUnit("strain [%]", 100.0, "% strain", 100.0),
    "force": DisplayUnit("contraction\nforce [N]", 1.0, "mN", 1e3),
    "temperature": DisplayUnit("temperature [°C]", 1.0, "K", 1.0, -ZERO_CELSIUS_K),
}


def interval_bar(item: ParameterEstimate) -> Markup:
    """Return prior and posterior 95 % intervals in one bar, three prior deviations to either side within bounds."""
    left = min(item.value, max(item.low, item.prior_mean - SHOWN_STD * item.prior_std))
    right = max(item.value, min(item.high, item.prior_mean + SHOWN_STD * item.prior_std))

    def bar(low: float, high: float, top: float, height: float, colour: str) -> str:
        start, end = (BAR_WIDTH * min(max((one - left) / (right - left), 0.0), 1.0) for one in (low, high))
        place = f'x="{start:.1f}" y="{top:g}" width="{max(end - start, 1.5):.1f}" height="{height:g}"'
        return f'<rect {place} rx="2" fill="{colour}"/>'

    colour = BOUND if item.at_bound else IDENTIFIED if item.identifiable else UNIDENTIFIED
    prior = (item.prior_mean - SURE_STD * item.prior_std, item.prior_mean + SURE_STD * item.prior_std)
    return Markup(
        f'<svg viewBox="0 0 {BAR_WIDTH:g} {BAR_HEIGHT:g}" role="img" '
        f'aria-label="95 % interval {item.interval[0]:.4g} to {item.interval[1]:.4g} {item.unit}, '
        f'prior {item.prior_mean:.4g} +- {item.prior_std:.4g}">'
        f"{bar(*prior, 3.0, 10.0, PRIOR)}{bar(*item.interval, 5.5, 5.0, colour)}"
        f"{bar(item.value, item.value, 1.0, 14.0, colour)}</svg>"
    )


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


def draw_channels(figure: Figure, pairs: Sequence[ChannelComparison], *, residuals: bool = True) -> Axes:
    """Draw channels over time, each above its residuals if these are wanted; return the first axes."""
    heights = ((3, 1) if residuals else (3,)) * len(pairs)
    rows = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
    for place, pair in enumerate(pairs):
        shown, channel, top = DISPLAY[pair.channel.name], pair.channel, rows[place * (1 + residuals)]
        fitted = shown.factor * pair.predicted
        top.plot(channel.axis, shown.factor * channel.measured + shown.offset, color=MEASURED, linewidth=3.2,
                 label="measured", solid_capstyle="round")  # fmt: skip
        top.plot(channel.axis, fitted + shown.offset, color=FITTED, linewidth=1.2, label="fitted wire")
        # Around the fitted curve, so that outliers of the measurement's noise do not set the scale.
        margin = 0.15 * float(np.ptp(fitted)) or 1.0
        top.set(ylabel=shown.label, ylim=(fitted.min() - margin + shown.offset, fitted.max() + margin + shown.offset))
        if residuals:
            below, band = rows[2 * place + 1], shown.residual_factor * channel.uncertainty
            below.fill_between(channel.axis, -band, band, color=TARGET, alpha=0.22, linewidth=0)
            below.axhline(0.0, color="#999999", linewidth=0.7)
            off = shown.residual_factor * (pair.predicted - channel.measured)
            below.plot(channel.axis, off, color=AVERAGE, linewidth=0.9)
            below.set_ylabel(f"residual\n[{shown.residual_unit}]", fontsize=8)
            below.tick_params(labelsize=8)
    rows[0].legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), borderaxespad=0.0, ncols=2)
    rows[-1].set(xlabel="time [s]")
    first: Axes = rows[0]
    return first


def draw_isobars(figure: Figure, pairs: Sequence[ChannelComparison]) -> Axes:
    """Draw strain against temperature for every stress, above the residuals; return the first axes."""
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


def loop_figure(pairs: Sequence[ChannelComparison]) -> Figure | None:
    """Draw strain (or force) against resistance, measured and fitted; None unless both were recorded."""
    by_name = {pair.channel.name: pair for pair in pairs}
    other = next((name for name in ("strain", "force") if name in by_name), None)
    if other is None or "resistance" not in by_name:
        return None
    resistance, quantity, shown = by_name["resistance"], by_name[other], DISPLAY[other]
    # Bins without a current have no resistance; the others are matched by their times.
    _, here, there = np.intersect1d(resistance.channel.axis, quantity.channel.axis, return_indices=True)
    # At very low current the resistance is mostly noise.
    uncertain = resistance.channel.uncertainty > MAX_UNCERTAIN_FRACTION * np.ptp(resistance.predicted)
    measured = np.where(uncertain, np.nan, resistance.channel.measured)
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    axes = figure.subplots()
    axes.plot(measured[here], shown.factor * quantity.channel.measured[there], color=MEASURED, linewidth=3.2,
              label="measured")  # fmt: skip
    axes.plot(resistance.predicted[here], shown.factor * quantity.predicted[there], color=FITTED, linewidth=1.2,
              label="fitted wire")  # fmt: skip
    axes.set(xlabel="resistance [ohm]", ylabel=shown.label)
    axes.legend(loc="upper right")
    return figure


def figures(calibration: Calibration) -> list[tuple[str, list[Markup]]]:
    """Return the name of every recording with its figures."""
    found = []
    with mpl.rc_context(dict(STYLE)):  # type: ignore[arg-type]  # matplotlib lists every key as a literal
        for place, observation in enumerate(calibration.problem.observations):
            pairs, isobars = compared(calibration, observation), isinstance(observation, IsobaricObservation)
            height = 6.0 if isobars else ROW_HEIGHT * len(pairs) + 0.3
            channels = Figure(figsize=(WIDTH, height), layout="constrained")
            (draw_isobars if isobars else draw_channels)(channels, pairs)
            drawn = [("loop", loop_figure(pairs)), ("channels", channels)]
            svgs = [svg_in_frame(figure, f"{name}{place}") for name, figure in drawn if figure is not None]
            found.append((Path(observation.title).name, svgs))
    return found


def write_report(calibration: Calibration, path: str | Path, advice: Sequence[ExperimentAdvice] | None = None) -> None:
    """Write the page of a calibration as one HTML file, whole or not at all.

    Parameters
    ----------
    calibration
        The calibration.
    path
        File to write; it ends in .html, and an existing one is replaced.
    advice
        Experiments to make next, as :func:`next_experiments` returns them; they are simulated now if it is None.

    Raises
    ------
    CallerError
        If the path has another suffix, or its folder cannot be written to.
    """
    path = Path(path)
    if path.suffix != ".html":
        raise CallerError(f"{path}: a report is an .html file, end its name so")
    inputs = calibration.inputs
    names = ", ".join(Path(name).name for name in inputs.sources)
    text = page(
        "musclewire.extras.calibration._physical/report.html",
        title=names,
        heading=f"The wire in {names if len(inputs.sources) <= 3 else f'{len(inputs.sources)} files'}",
        cards=key_numbers(calibration),
        given=[
            *inputs.notes,
            f"started from {inputs.wire} ({1e6 * calibration.wire.diameter_m.value:.4g} um), priors "
            f"{inputs.priors.name}: {inputs.priors.description}",
        ],
        channels=[channel_row(title, pair) for title, pair in calibration.comparisons()],
        figures=figures(calibration),
        key=((PRIOR, "prior"), (IDENTIFIED, "identifiable from the recordings"), (UNIDENTIFIED, "mostly prior"),
             (BOUND, "at a bound")),
        bar=interval_bar,
        number=number,
        described=FIELDS,
        how_to_identify=how_to_identify,
        found=calibration,
        advice=next_experiments(calibration) if advice is None else advice,
        holds=calibration.verdict.capitalize(),
    )  # fmt: skip
    write_text_whole(path, text)


def key_numbers(calibration: Calibration) -> list[NumberCard]:
    """Return the key numbers."""
    identifiable, whole = len(calibration.identifiable), len(calibration.estimates)
    costs = calibration.search_result.costs
    agree = sum(cost < 1.05 * min(costs) + 1.0 for cost in costs)
    bound = sum(item.at_bound for item in calibration.estimates)
    title, worst = max(calibration.comparisons(), key=lambda item: item[1].normalised_rms)
    about = f"worst: {worst.channel.name}, {worst.normalised_rms:.2f}" + (f" ({title})" if len(title) < 20 else "")
    return [
        NumberCard("The fit", "holds" if calibration.holds else "does not hold", about, calibration.holds),
        NumberCard("Residuals", f"{calibration.rmse:.2f}", "of their uncertainty, rms"),
        NumberCard("Identifiable from the recordings", f"{identifiable} of {whole}", "parameters"),
        NumberCard("At a bound of the search", f"{bound}", "parameters", bound == 0),
        NumberCard("Descents that agree", f"{agree} of {len(costs)}", "end within 5 % of the best"),
    ]


def channel_row(title: str, pair: ChannelComparison) -> tuple[object, ...]:
    """Return the residuals of a channel as cells."""
    off = f"{100.0 * pair.rms:.3g} % strain" if pair.channel.unit == "1" else f"{pair.rms:.3g} {pair.channel.unit}"
    verdict = "followed" if pair.normalised_rms <= FOLLOWED_WITHIN else Markup("<b>not followed</b>")
    return Path(title).name, pair.channel.name, off, f"{pair.normalised_rms:.2f}", verdict
