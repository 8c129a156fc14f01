"""A calibration in words: a summary for the command line, a table for a notebook."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from musclewire.identify.physical.calibration import Calibration
    from musclewire.identify.physical.observations import Comparison
    from musclewire.identify.physical.uncertainty import Estimate

__all__ = ["channel_line", "notebook_table", "number", "standing", "summary", "verdict"]


def summary(calibration: Calibration) -> str:
    """Return what was found, and how well, in lines for a person."""
    lines = [*calibration.asked.notes, ""]
    lines += [channel_line(title, pair) for title, pair in calibration.comparisons()]
    lines += [
        "",
        f"{'parameter':<32}{'value':>12} {'+-':>10}  {'unit':<11}",
        *map(estimate_line, calibration.estimates),
    ]
    lines += ["", verdict(calibration)]
    return "\n".join(lines)


def verdict(calibration: Calibration) -> str:
    """Say whether the fit holds, and how many parameters the recordings told."""
    told = f"{len(calibration.identifiable)} of {len(calibration.estimates)} parameters told by the recordings"
    if calibration.holds:
        return f"the fit holds; {told}"
    worst = max(calibration.not_followed, key=lambda pair: pair[1].normalised_rms)
    return (
        f"the fit does not hold: {worst[1].channel.name} of {worst[0]} is {worst[1].normalised_rms:.1f} of its "
        f"uncertainties off (rms), 3 are allowed; {told}"
    )


def channel_line(title: str, pair: Comparison) -> str:
    """Return how far a channel is off, in its unit and in its uncertainty."""
    unit = "" if pair.channel.unit == "1" else f" {pair.channel.unit}"
    off, what = (100.0 * pair.rms, " %") if unit == "" else (pair.rms, unit)
    return f"{title}: {pair.channel.name} {off:.3g}{what} rms, {pair.normalised_rms:.2f} of its uncertainty"


def estimate_line(item: Estimate) -> str:
    """Return one parameter with its deviation and standing."""
    return f"{item.name:<32}{number(item.value):>12} {number(item.std):>10}  {item.unit:<11} {standing(item)}".rstrip()


def standing(item: Estimate) -> str:
    """Say what a parameter's value is worth: nothing to say where the recordings tell it."""
    if item.at_bound:
        return "at a bound"
    return "" if item.identifiable else "mostly prior"


def number(value: float) -> str:
    """Return a number with four digits."""
    return f"{value:.4g}"


def notebook_table(calibration: Calibration) -> str:
    """Return the table of parameters as HTML."""
    head = "<tr><th>parameter</th><th>value</th><th>&plusmn;</th><th>unit</th><th></th></tr>"
    rows = "".join(
        f"<tr><td>{escape(item.name)}</td><td>{number(item.value)}</td><td>{number(item.std)}</td>"
        f"<td>{escape(item.unit)}</td><td>{standing(item)}</td></tr>"
        for item in calibration.estimates
    )
    return f"<div><b>Calibration</b> ({escape(verdict(calibration))})<table>{head}{rows}</table></div>"
