"""The report of a calibration as one HTML file that needs no other file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

import matplotlib as mpl

from musclewire.errors import CallerError
from musclewire.identify._physical.advice import ExperimentAdvice, how_to_identify, next_experiments
from musclewire.identify._physical.calibration import Calibration
from musclewire.identify._physical.calibration_figures import loop_figure, observation_figure
from musclewire.identify._physical.calibration_text import number, verdict
from musclewire.identify._physical.interval_bars import interval_bar, key_of_bars
from musclewire.identify._physical.observations import ChannelComparison
from musclewire.identify._physical.uncertainty import ParameterEstimate
from musclewire.pages import STYLE, NumberCard, cards, page, svg_in_frame
from musclewire.parameters import Alloy, Bench, Wire
from musclewire.signals import write_text_whole

__all__ = ["write_report"]

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
    parts = {
        "title": escape(names),
        "heading": escape(
            f"The wire in {names}" if len(inputs.sources) <= 3 else f"The wire in {len(inputs.sources)} files"
        ),
        "cards": cards(key_numbers(calibration)),
        "given": given(calibration),
        "channels": "".join(channel_row(title, pair) for title, pair in calibration.comparisons()),
        "figures": figures(calibration),
        "key": key_of_bars(),
        "parameters": parameter_rows(calibration),
        "correlated": correlated(calibration),
        "advice": advice_part(next_experiments(calibration) if advice is None else advice),
        "how": how(calibration),
        "seed": inputs.settings.seed,
        "simulations": calibration.search_result.simulations,
        "wall_s": f"{calibration.wall_s:.0f}",
        "priors": escape(inputs.priors.name),
    }
    write_text_whole(path, page("musclewire.identify._physical", "report.html", parts))


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


def given(calibration: Calibration) -> str:
    """Return the interpretation of the recordings, the assumptions, and the starting wire."""
    wire = calibration.wire
    lines = [
        *calibration.inputs.notes,
        f"started from {calibration.inputs.wire} ({1e6 * wire.diameter_m.value:.4g} um), priors "
        f"{calibration.inputs.priors.name}: {calibration.inputs.priors.description}",
    ]
    return f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"


def channel_row(title: str, pair: ChannelComparison) -> str:
    """Return the residuals of a channel as a table row."""
    percent = pair.channel.unit == "1"
    off = f"{100.0 * pair.rms:.3g} % strain" if percent else f"{pair.rms:.3g} {pair.channel.unit}"
    judged = "followed" if pair.normalised_rms <= 3.0 else "<b>not followed</b>"
    return (
        f"<tr><td>{escape(Path(title).name)}</td><td>{escape(pair.channel.name)}</td><td>{off}</td>"
        f"<td>{pair.normalised_rms:.2f}</td><td>{judged}</td></tr>"
    )


def figures(calibration: Calibration) -> str:
    """Return the figures of every recording as SVG."""
    parts = []
    with mpl.rc_context(dict(STYLE)):  # type: ignore[arg-type]  # matplotlib lists every key as a literal
        for place, observation in enumerate(calibration.problem.observations):
            parts.append(f"<h3>{escape(Path(observation.title).name)}</h3>")
            loop = loop_figure(calibration, observation)
            if loop is not None:
                parts.append(svg_in_frame(loop, f"loop{place}"))
            parts.append(svg_in_frame(observation_figure(calibration, observation), f"channels{place}"))
    return "".join(parts)


def parameter_rows(calibration: Calibration) -> str:
    """Return the table's rows: identifiable parameters, then those that are mostly prior, then those at a bound."""
    at_bound = [item for item in calibration.estimates if item.at_bound]
    identifiable = [item for item in calibration.identifiable if not item.at_bound]
    prior = [item for item in calibration.not_identifiable if not item.at_bound]
    groups = (
        ("Identifiable from the recordings", "interval at most half the prior's", identifiable),
        (
            "Mostly prior",
            "the recordings narrow it by less than half; the last column names a measurement that would identify it",
            prior,
        ),
        ("At a bound of the search", "the best value is at the edge of the range of the search", at_bound),
    )
    return "".join(
        f'<tr class="group"><td colspan="7">{title} <span>({len(items)}): {about}</span></td></tr>'
        f"{''.join(parameter_row(item) for item in items)}"
        for title, about, items in groups
        if items
    )


def parameter_row(item: ParameterEstimate) -> str:
    """Return one parameter: value, deviation, its interval over the prior's, and how to identify it."""
    about = "" if item.identifiable and not item.at_bound else how_to_identify(item.measure)
    described = FIELDS[item.name].description or ""
    return (
        f'<tr><td title="{escape(described)}"><code>{item.name}</code></td><td class="number">{number(item.value)}</td>'
        f'<td class="number">{number(item.std)}</td><td>{escape(item.unit if item.unit != "1" else "")}</td>'
        f'<td>{interval_bar(item)}</td><td class="number">{100.0 * item.std / item.prior_std:.0f} %</td>'
        f'<td class="about">{escape(about)}</td></tr>'
    )


def correlated(calibration: Calibration) -> str:
    """Return the parameters that are identifiable only in combination, and those on which nothing recorded depends."""
    parts = []
    pairs = calibration.correlated
    if pairs:
        lines = "".join(
            f"<li><code>{one}</code> and <code>{other}</code>: r = {r:+.3f}</li>" for one, other, r in pairs[:12]
        )
        parts.append(
            "<h3>Identifiable together rather than apart</h3><p class='plain'>If |r| is above 0.9, the recordings "
            "identify a combination of the two better than either: change one, and the other follows.</p>"
            f"<ul>{lines}</ul>"
        )
    if calibration.not_searched:
        parts.append(
            "<h3>Not fitted</h3><p class='plain'>Nothing in these recordings depends on "
            f"{codes(calibration.not_searched)}: the wire keeps the values of {escape(calibration.inputs.wire)}.</p>"
        )
    return "".join(parts)


def codes(names: Iterable[str]) -> str:
    """Return names as code, with commas."""
    return ", ".join(f"<code>{escape(name)}</code>" for name in names)


def advice_part(advice: Sequence[ExperimentAdvice]) -> str:
    """Return the experiments worth making, with the parameters each would identify."""
    if not advice:
        return "<p>None of the usual experiments would identify a parameter that these recordings do not.</p>"
    found = "".join(advice_card(place, item) for place, item in enumerate(advice, 1))
    return (
        "<p>Each of the usual experiments was simulated with the fitted wire, and its information was computed from "
        "the derivative. These would identify most of what is still mostly prior.</p>"
        f"<div class='advice'>{found}</div>"
    )


def advice_card(place: int, item: ExperimentAdvice) -> str:
    """Return one experiment."""
    count = len(item.identifies)
    more = (
        f"<p class='identifies'>would identify {count} more parameter{'' if count == 1 else 's'}</p>" if count else ""
    )
    listed = f"<ul>{''.join(f'<li><code>{name}</code></li>' for name in item.identifies)}</ul>"
    narrows = f"<p>and would halve the interval of {codes(item.narrows)}</p>" if item.narrows else ""
    return f"<div><h3>{place}. {escape(item.title)}</h3><p>{escape(item.text)}</p>{more}{listed}{narrows}</div>"


def how(calibration: Calibration) -> str:
    """Return the course of the search."""
    settings, result = calibration.inputs.settings, calibration.search_result
    costs = ", ".join(f"{cost:.1f}" for cost in result.costs)
    holds = verdict(calibration.comparisons(), calibration.estimates)
    widened = (
        f"<p>The variance of the residuals is {calibration.excess_variance:.1f} times that of the stated uncertainty: "
        "all intervals were widened to match.</p>"
        if calibration.excess_variance > 1.0
        else ""
    )
    return (
        f"<p>{escape(holds).capitalize()}. {len(result.costs)} descents (at most {settings.starts} from "
        f"the prior and {settings.jumps} from jumps off the best until then) ended at sums of squares of {costs}; the "
        f"last, with the finest time step, at {result.cost:.1f}. If several agree, no other minimum was found.</p>"
        f"{widened}"
        "<p>Intervals are Laplace's approximation: the curvature of the sum of squares at its minimum, with the prior. "
        "They hold if the model is accurate to the stated uncertainty and no other minimum is near.</p>"
    )
