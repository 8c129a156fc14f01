"""The report of a calibration as one HTML file that needs nothing beside it."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl

from musclewire.errors import CallerError
from musclewire.identify.physical.advice import Advice, how_to_tell
from musclewire.identify.physical.interval_bars import interval_bar, key_of_bars
from musclewire.identify.physical.pictures import loop_figure, observation_figure
from musclewire.identify.physical.words import number, verdict
from musclewire.pages import STYLE, page_template, style_sheet, svg
from musclewire.parameters.schema import Alloy, Bench, Wire
from musclewire.signals.whole_files import write_whole

if TYPE_CHECKING:
    from musclewire.identify.physical.calibration import Calibration
    from musclewire.identify.physical.observations import Comparison
    from musclewire.identify.physical.uncertainty import Estimate

__all__ = ["write_report"]

FIELDS = {**Alloy.model_fields, **Wire.model_fields, **Bench.model_fields}


def write_report(calibration: Calibration, path: Path) -> None:
    """Write the page of a calibration, whole or not at all. Raises CallerError for another suffix than .html."""
    if path.suffix != ".html":
        raise CallerError(f"{path}: a report is an .html file")
    asked = calibration.asked
    names = ", ".join(Path(name).name for name in asked.sources)
    page = page_template("musclewire.identify.physical", "report.html").substitute(
        style=style_sheet(),
        title=escape(names),
        heading=escape(
            f"The wire in {names}" if len(asked.sources) <= 3 else f"The wire in {len(asked.sources)} files"
        ),
        cards=cards(calibration),
        given=given(calibration),
        channels="".join(channel_row(title, pair) for title, pair in calibration.comparisons()),
        figures=figures(calibration),
        key=key_of_bars(),
        parameters=parameter_rows(calibration),
        correlated=correlated(calibration),
        advice=advice(calibration),
        how=how(calibration),
        version=escape(version("musclewire")),
        seed=asked.settings.seed,
        simulations=calibration.found.simulations,
        wall_s=f"{calibration.wall_s:.0f}",
        priors=escape(asked.priors.name),
    )

    def write(part: Path) -> None:
        part.write_text(page, "utf-8")

    write_whole(path, write)


def cards(calibration: Calibration) -> str:
    """Return the key numbers."""
    told, whole = len(calibration.identifiable), len(calibration.estimates)
    costs = sorted(calibration.found.costs)
    agree = sum(cost < 1.05 * costs[0] + 1.0 for cost in costs)
    bound = sum(item.at_bound for item in calibration.estimates)
    items = (
        ("The fit", "holds" if calibration.holds else "does not hold", worst_words(calibration), calibration.holds),
        ("Left over", f"{calibration.rmse:.2f}", "of its uncertainty, rms", True),
        ("Told by the recordings", f"{told} of {whole}", "parameters", True),
        ("At a bound of the search", f"{bound}", "parameters", bound == 0),
        ("Descents that agree", f"{agree} of {len(costs)}", "end within 5 % of the best", True),
    )
    return "".join(
        f'<div class="card{"" if good else " fails"}"><div class="name">{name}</div><div class="value">{value}</div>'
        f'<div class="beside">{escape(beside)}</div></div>'
        for name, value, beside, good in items
    )


def worst_words(calibration: Calibration) -> str:
    """Say which channel is furthest off."""
    title, pair = max(calibration.comparisons(), key=lambda item: item[1].normalised_rms)
    return f"worst: {pair.channel.name}, {pair.normalised_rms:.2f}" + (f" ({title})" if len(title) < 20 else "")


def given(calibration: Calibration) -> str:
    """Return how the recordings were understood, what was assumed, and the wire started from."""
    wire = calibration.wire
    lines = [
        *calibration.asked.notes,
        f"started from {calibration.asked.wire} ({1e6 * wire.diameter_m.value:.4g} um), priors "
        f"{calibration.asked.priors.name}: {calibration.asked.priors.description}",
    ]
    return f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"


def channel_row(title: str, pair: Comparison) -> str:
    """Return how far a channel is off, as a table row."""
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
        for place, observation in enumerate(calibration.fit.observations):
            parts.append(f"<h3>{escape(Path(observation.title).name)}</h3>")
            loop = loop_figure(calibration, observation)
            if loop is not None:
                parts.append(svg(loop, f"loop{place}"))
            parts.append(svg(observation_figure(calibration, observation), f"channels{place}"))
    return "".join(parts)


def parameter_rows(calibration: Calibration) -> str:
    """Return the table's rows: parameters that are told, then those that stay prior, then those at a bound."""
    at_bound = [item for item in calibration.estimates if item.at_bound]
    told = [item for item in calibration.identifiable if not item.at_bound]
    prior = [item for item in calibration.not_identifiable if not item.at_bound]
    groups = (
        ("Told by the recordings", "interval at most half the prior's", told),
        ("Mostly prior", "the recordings narrow it by less than half; what would tell it on general grounds", prior),
        ("At a bound of the search", "the best value lies at the edge of what was thought possible", at_bound),
    )
    return "".join(
        f'<tr class="group"><td colspan="7">{title} <span>({len(items)}): {about}</span></td></tr>'
        f"{''.join(parameter_row(item) for item in items)}"
        for title, about, items in groups
        if items
    )


def parameter_row(item: Estimate) -> str:
    """Return one parameter: value, deviation, its interval over the prior's, and how to tell it."""
    about = "" if item.identifiable and not item.at_bound else how_to_tell(item.measure)
    described = FIELDS[item.name].description or ""
    return (
        f'<tr><td title="{escape(described)}"><code>{item.name}</code></td><td class="number">{number(item.value)}</td>'
        f'<td class="number">{number(item.std)}</td><td>{escape(item.unit if item.unit != "1" else "")}</td>'
        f'<td>{interval_bar(item)}</td><td class="number">{100.0 * item.std / item.prior_std:.0f} %</td>'
        f'<td class="about">{escape(about)}</td></tr>'
    )


def correlated(calibration: Calibration) -> str:
    """Return what the recordings tell together rather than apart, and what they cannot touch."""
    parts = []
    pairs = calibration.correlated
    if pairs:
        lines = "".join(
            f"<li><code>{one}</code> and <code>{other}</code>: r = {r:+.3f}</li>" for one, other, r in pairs[:12]
        )
        parts.append(
            "<h3>Told together rather than apart</h3><p class='plain'>Where |r| is above 0.9, the recordings tell a "
            f"combination of the two better than either: change one, and the other follows.</p><ul>{lines}</ul>"
        )
    if calibration.not_searched:
        parts.append(
            "<h3>Not looked for</h3><p class='plain'>Nothing in these recordings depends on "
            f"{codes(calibration.not_searched)}: the wire keeps the values of {escape(calibration.asked.wire)}.</p>"
        )
    return "".join(parts)


def codes(names: Iterable[str]) -> str:
    """Return names as code, with commas."""
    return ", ".join(f"<code>{escape(name)}</code>" for name in names)


def advice(calibration: Calibration) -> str:
    """Return the experiments worth making, with the parameters each would tell."""
    if not calibration.advice:
        return "<p>None of the usual experiments would tell a parameter that these recordings do not.</p>"
    found = "".join(advice_card(place, item) for place, item in enumerate(calibration.advice, 1))
    return (
        "<p>Each of the usual experiments was simulated with the wire found, and what it would add was computed from "
        "its derivative. These would tell most of what is still mostly prior.</p>"
        f"<div class='advice'>{found}</div>"
    )


def advice_card(place: int, item: Advice) -> str:
    """Return one experiment."""
    count = len(item.tells)
    tells = f"<p class='tells'>would tell {count} more parameter{'' if count == 1 else 's'}</p>" if count else ""
    listed = f"<ul>{''.join(f'<li><code>{name}</code></li>' for name in item.tells)}</ul>"
    narrows = f"<p>and would halve the interval of {codes(item.narrows)}</p>" if item.narrows else ""
    return f"<div><h3>{place}. {escape(item.title)}</h3><p>{escape(item.text)}</p>{tells}{listed}{narrows}</div>"


def how(calibration: Calibration) -> str:
    """Return how the search went."""
    settings, found = calibration.asked.settings, calibration.found
    costs = ", ".join(f"{cost:.1f}" for cost in found.costs)
    widened = (
        f"<p>What is left over varies {calibration.excess_variance:.1f} times as much as the stated uncertainty says: "
        "all intervals were widened to match.</p>"
        if calibration.excess_variance > 1.0
        else ""
    )
    return (
        f"<p>{escape(verdict(calibration)).capitalize()}. {len(found.costs)} descents (at most {settings.starts} from "
        f"the prior and {settings.jumps} from jumps off the best so far) ended at sums of squares of {costs}; the "
        f"last, with all digits, at {found.cost:.1f}. Where several agree, the minimum is the only one in sight.</p>"
        f"{widened}"
        "<p>Intervals are Laplace's approximation: the curvature of the sum of squares at its minimum, with the prior. "
        "They hold where the model is right up to the stated uncertainty and no other minimum is near.</p>"
    )
