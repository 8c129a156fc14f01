"""Small bars that show a parameter's interval before and after the recordings, as SVG text."""

from __future__ import annotations

from markupsafe import Markup

from musclewire.identify._physical.uncertainty import ParameterEstimate

PRIOR, IDENTIFIED, UNIDENTIFIED, BOUND = "#dfe3e8", "#1f6f8b", "#b9a27a", "#c8553d"
WIDTH, HEIGHT = 190.0, 16.0
# A bar extends over this many prior standard deviations to either side; an interval of 95 % over this many.
SHOWN_STD, SURE_STD = 3.0, 1.96


def interval_bar(item: ParameterEstimate) -> Markup:
    """Return prior and posterior 95 % intervals in one bar, three prior deviations to either side within bounds."""
    left = max(item.low, item.prior_mean - SHOWN_STD * item.prior_std)
    right = min(item.high, item.prior_mean + SHOWN_STD * item.prior_std)
    left, right = min(left, item.value), max(right, item.value)

    def place(value: float) -> float:
        return WIDTH * min(max((value - left) / (right - left), 0.0), 1.0)

    prior = (place(item.prior_mean - SURE_STD * item.prior_std), place(item.prior_mean + SURE_STD * item.prior_std))
    after = (place(item.interval[0]), place(item.interval[1]))
    colour = BOUND if item.at_bound else IDENTIFIED if item.identifiable else UNIDENTIFIED
    middle = min(max(place(item.value), 1.2), WIDTH - 1.2)
    return Markup(
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img" aria-label="95 % interval {item.interval[0]:.4g} to '
        f'{item.interval[1]:.4g} {item.unit}, prior {item.prior_mean:.4g} +- {item.prior_std:.4g}">'
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
