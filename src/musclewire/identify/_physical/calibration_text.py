"""A calibration as text: lines for the command line, a table for a notebook."""

from __future__ import annotations

from collections.abc import Sequence

from musclewire.identify._physical.observations import ChannelComparison
from musclewire.identify._physical.uncertainty import ParameterEstimate

# Channels with the title of the observation that each belongs to.
Comparisons = Sequence[tuple[str, ChannelComparison]]
# The model does not follow a channel whose residuals exceed this multiple of its stated uncertainty.
FOLLOWED_WITHIN = 3.0


def not_followed(comparisons: Comparisons) -> list[tuple[str, ChannelComparison]]:
    """Return the channels whose residuals exceed three times their stated uncertainty (rms)."""
    return [(title, pair) for title, pair in comparisons if pair.normalised_rms > FOLLOWED_WITHIN]


def summary(notes: Sequence[str], comparisons: Comparisons, estimates: Sequence[ParameterEstimate]) -> str:
    """Return result and residuals as lines of text."""
    lines = [*notes, ""]
    lines += [channel_line(title, pair) for title, pair in comparisons]
    lines += ["", f"{'parameter':<32}{'value':>12} {'+-':>10}  {'unit':<11}", *map(estimate_line, estimates)]
    lines += ["", verdict(comparisons, estimates)]
    return "\n".join(lines)


def verdict(comparisons: Comparisons, estimates: Sequence[ParameterEstimate]) -> str:
    """Return whether the fit holds, and how many parameters the recordings identify."""
    count = sum(item.identifiable for item in estimates)
    identifiable = f"{count} of {len(estimates)} parameters identifiable from the recordings"
    off = not_followed(comparisons)
    if not off:
        return f"the fit holds; {identifiable}"
    title, worst = max(off, key=lambda pair: pair[1].normalised_rms)
    return (
        f"the fit does not hold: {worst.channel.name} of {title} is {worst.normalised_rms:.1f} of its "
        f"uncertainties off (rms), {FOLLOWED_WITHIN:g} are allowed; {identifiable}"
    )


def channel_line(title: str, pair: ChannelComparison) -> str:
    """Return the residuals of a channel, in its unit and over its uncertainty."""
    unit = "" if pair.channel.unit == "1" else f" {pair.channel.unit}"
    off, what = (100.0 * pair.rms, " %") if unit == "" else (pair.rms, unit)
    return f"{title}: {pair.channel.name} {off:.3g}{what} rms, {pair.normalised_rms:.2f} of its uncertainty"


def estimate_line(item: ParameterEstimate) -> str:
    """Return one parameter with its deviation and standing."""
    return f"{item.name:<32}{number(item.value):>12} {number(item.std):>10}  {item.unit:<11} {standing(item)}".rstrip()


def standing(item: ParameterEstimate) -> str:
    """Return the standing of a parameter's value: "" if the recordings identify it."""
    if item.at_bound:
        return "at a bound"
    return "" if item.identifiable else "mostly prior"


def number(value: float) -> str:
    """Return a number with four digits."""
    return f"{value:.4g}"
