"""The report of a calibration as one HTML file that needs no other file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from markupsafe import Markup

from musclewire.errors import CallerError
from musclewire.identify._physical.advice import ExperimentAdvice, how_to_identify, next_experiments
from musclewire.identify._physical.calibration import Calibration
from musclewire.identify._physical.calibration_figures import loop_figure, observation_figure
from musclewire.identify._physical.calibration_text import number, verdict
from musclewire.identify._physical.interval_bars import interval_bar, key_of_bars
from musclewire.identify._physical.observations import ChannelComparison
from musclewire.identify._physical.uncertainty import ParameterEstimate
from musclewire.pages import STYLE, NumberCard, page, svg_in_frame
from musclewire.parameters import Alloy, Bench, Wire
from musclewire.signals import write_text_whole

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
        "musclewire.identify._physical/report.html",
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
