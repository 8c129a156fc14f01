"""The report of a calibration as one HTML file that needs no other file, with its bars and figures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.extras.calibration._physical.advice import ExperimentAdvice, how_to_identify, next_experiments
from musclewire.extras.calibration._physical.calibration import Calibration, number, verdict
from musclewire.extras.calibration._physical.driven import DrivenObservation
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
BAR_WIDTH, BAR_HEIGHT = 190.0, 16.0
# A bar extends over this many prior standard deviations to either side; an interval of 95 % over this many.
SHOWN_STD, SURE_STD = 3.0, 1.96


def interval_bar(item: ParameterEstimate) -> Markup:
    """Return prior and posterior 95 % intervals in one bar, three prior deviations to either side within bounds."""
    left = max(item.low, item.prior_mean - SHOWN_STD * item.prior_std)
    right = min(item.high, item.prior_mean + SHOWN_STD * item.prior_std)
    left, right = min(left, item.value), max(right, item.value)

    def place(value: float) -> float:
        return BAR_WIDTH * min(max((value - left) / (right - left), 0.0), 1.0)

    prior = (place(item.prior_mean - SURE_STD * item.prior_std), place(item.prior_mean + SURE_STD * item.prior_std))
    after = (place(item.interval[0]), place(item.interval[1]))
    colour = BOUND if item.at_bound else IDENTIFIED if item.identifiable else UNIDENTIFIED
    middle = min(max(place(item.value), 1.2), BAR_WIDTH - 1.2)
    return Markup(
        f'<svg viewBox="0 0 {BAR_WIDTH:g} {BAR_HEIGHT:g}" role="img" '
        f'aria-label="95 % interval {item.interval[0]:.4g} to {item.interval[1]:.4g} {item.unit}, '
        f'prior {item.prior_mean:.4g} +- {item.prior_std:.4g}">'
        f"{box(prior, 3.0, 10.0, PRIOR)}{box(after, 5.5, 5.0, colour)}"
        f'<rect x="{middle - 1.2:.1f}" y="1" width="2.4" height="14" fill="{colour}"/></svg>'
    )


def box(ends: tuple[float, float], top: float, height: float, colour: str) -> str:
    """Return a bar from one place to another, wide enough to be seen."""
    width = max(ends[1] - ends[0], 1.5)
    return f'<rect x="{ends[0]:.1f}" y="{top:g}" width="{width:.1f}" height="{height:g}" rx="2" fill="{colour}"/>'


def key_of_bars() -> Markup:
    """Return the key of the colours."""
    names = (
        (PRIOR, "prior"),
        (IDENTIFIED, "identifiable from the recordings"),
        (UNIDENTIFIED, "mostly prior"),
        (BOUND, "at a bound"),
    )
    patch = '<svg viewBox="0 0 46 12"><rect x="2" y="2" width="42" height="8" rx="2" fill="{}"/></svg>'
    return Markup("").join(
        Markup("<span>{}{}</span>").format(Markup(patch.format(colour)), name) for colour, name in names
    )


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


FIELDS = {**Alloy.model_fields, **Wire.model_fields, **Bench.model_fields}


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
    many = f"The wire in {len(inputs.sources)} files"
    text = page(
        "musclewire.extras.calibration._physical/report.html",
        title=names,
        heading=f"The wire in {names}" if len(inputs.sources) <= 3 else many,
        cards=key_numbers(calibration),
        given=given(calibration),
        channels=[channel_row(title, pair) for title, pair in calibration.comparisons()],
        figures=figures(calibration),
        key=key_of_bars(),
        parameters=parameter_groups(calibration),
        correlated=calibration.correlated[:12],
        not_searched=calibration.not_searched,
        wire=inputs.wire,
        advice=next_experiments(calibration) if advice is None else advice,
        holds=verdict(calibration.comparisons(), calibration.estimates).capitalize(),
        settings=inputs.settings,
        costs=[f"{cost:.1f}" for cost in calibration.search_result.costs],
        cost=f"{calibration.search_result.cost:.1f}",
        excess_variance=calibration.excess_variance,
        seed=inputs.settings.seed,
        simulations=calibration.search_result.simulations,
        wall_s=f"{calibration.wall_s:.0f}",
        priors=inputs.priors.name,
    )
    write_text_whole(path, text)


def key_numbers(calibration: Calibration) -> list[NumberCard]:
    """Return the key numbers."""
    identifiable, whole = len(calibration.identifiable), len(calibration.estimates)
    costs = sorted(calibration.search_result.costs)
    agree = sum(cost < 1.05 * costs[0] + 1.0 for cost in costs)
    bound = sum(item.at_bound for item in calibration.estimates)
    verdict = "holds" if calibration.holds else "does not hold"
    return [
        NumberCard("The fit", verdict, worst_channel(calibration), calibration.holds),
        NumberCard("Residuals", f"{calibration.rmse:.2f}", "of their uncertainty, rms"),
        NumberCard("Identifiable from the recordings", f"{identifiable} of {whole}", "parameters"),
        NumberCard("At a bound of the search", f"{bound}", "parameters", bound == 0),
        NumberCard("Descents that agree", f"{agree} of {len(costs)}", "end within 5 % of the best"),
    ]


def worst_channel(calibration: Calibration) -> str:
    """Return the channel with the largest normalised residual."""
    title, pair = max(calibration.comparisons(), key=lambda item: item[1].normalised_rms)
    return f"worst: {pair.channel.name}, {pair.normalised_rms:.2f}" + (f" ({title})" if len(title) < 20 else "")


def given(calibration: Calibration) -> list[str]:
    """Return the interpretation of the recordings, the assumptions, and the starting wire."""
    wire = calibration.wire
    return [
        *calibration.inputs.notes,
        f"started from {calibration.inputs.wire} ({1e6 * wire.diameter_m.value:.4g} um), priors "
        f"{calibration.inputs.priors.name}: {calibration.inputs.priors.description}",
    ]


def channel_row(title: str, pair: ChannelComparison) -> tuple[object, ...]:
    """Return the residuals of a channel as cells."""
    percent = pair.channel.unit == "1"
    off = f"{100.0 * pair.rms:.3g} % strain" if percent else f"{pair.rms:.3g} {pair.channel.unit}"
    judged = "followed" if pair.normalised_rms <= 3.0 else Markup("<b>not followed</b>")
    return Path(title).name, pair.channel.name, off, f"{pair.normalised_rms:.2f}", judged


def figures(calibration: Calibration) -> list[tuple[str, list[Markup]]]:
    """Return the name of every recording with its figures."""
    found = []
    with mpl.rc_context(dict(STYLE)):  # type: ignore[arg-type]  # matplotlib lists every key as a literal
        for place, observation in enumerate(calibration.problem.observations):
            loop = loop_figure(calibration, observation)
            drawn = [svg_in_frame(loop, f"loop{place}")] if loop is not None else []
            drawn.append(svg_in_frame(observation_figure(calibration, observation), f"channels{place}"))
            found.append((Path(observation.title).name, drawn))
    return found


def parameter_groups(calibration: Calibration) -> list[tuple[str, str, list[dict[str, str]]]]:
    """Return the table's groups: identifiable parameters, then those that are mostly prior, then those at a bound."""
    at_bound = [item for item in calibration.estimates if item.at_bound]
    identifiable = [item for item in calibration.identifiable if not item.at_bound]
    prior = [item for item in calibration.not_identifiable if not item.at_bound]
    mostly = "the recordings narrow it by less than half; the last column names a measurement that would identify it"
    edge = "the best value is at the edge of the range of the search"
    return [
        ("Identifiable from the recordings", "interval at most half the prior's", list(map(cells, identifiable))),
        ("Mostly prior", mostly, list(map(cells, prior))),
        ("At a bound of the search", edge, list(map(cells, at_bound))),
    ]


def cells(item: ParameterEstimate) -> dict[str, str]:
    """Return one parameter: value, deviation, its interval over the prior's, and how to identify it."""
    return {
        "name": item.name,
        "described": FIELDS[item.name].description or "",
        "value": number(item.value),
        "std": number(item.std),
        "unit": item.unit if item.unit != "1" else "",
        "bar": interval_bar(item),
        "of_prior": f"{100.0 * item.std / item.prior_std:.0f}",
        "about": "" if item.identifiable and not item.at_bound else how_to_identify(item.measure),
    }
