"""A row's numbers as text, the same on the page and in the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from musclewire.extras.paper._reproduce.verdicts import ReproductionRow


def paper_text(row: ReproductionRow) -> str:
    """Return the paper's number as printed; a dash where it prints none and speaks in words or symbols."""
    return f"{row.paper:.6g}" if has_printed_number(row) else "–"


def has_printed_number(row: ReproductionRow) -> bool:
    """Return whether the number we compare with is in print."""
    return row.kind not in {"words", "equation"}


def ours_text(row: ReproductionRow) -> str:
    """Return our number with the digits that its tolerance requires, or the paper's; a dash for None."""
    return "–" if row.ours is None else digits_of(row, row.ours)


def spread_text(row: ReproductionRow) -> str:
    """Return the 5 and 95 % points of ours over the seeds, "" where they are the same to the digits that are shown."""
    if row.low is None or row.high is None:
        return ""
    low, high = digits_of(row, row.low), digits_of(row, row.high)
    return "" if low == high else f"{low} to {high}"


def digits_of(row: ReproductionRow, value: float) -> str:
    """Return one of our numbers with the digits that its tolerance requires, or the paper's."""
    if row.tolerance <= 0.0:
        return f"{value:.6g}" if row.compare == "within" else f"{value:.3g}"
    return number_text(value, row.tolerance, len(f"{row.paper:.6g}".partition(".")[2]))


def number_text(value: float, tolerance: float, min_decimals: int = 0) -> str:
    """Return a number to a tenth of its tolerance, never as a plain zero that it is not."""
    fewest = 2 if tolerance <= 1.0 else 0
    decimals = min(6, max(fewest, min_decimals, 1 - math.floor(math.log10(tolerance))))
    text = f"{value:.{decimals}f}"
    return text if value == 0.0 or float(text) != 0.0 else f"{value:.0e}"


def limit_text(row: ReproductionRow) -> str:
    """Return what is allowed: a range about the number we compare with, or one end."""
    if row.compare == "reported":
        return "–"
    if row.compare == "within":
        middle = "" if has_printed_number(row) else f"{row.paper:.6g} "
        if row.tolerance:
            return f"{middle}± {row.tolerance:.3g}"
        return "the same" if has_printed_number(row) else f"= {row.paper:.6g}"
    end = row.paper + row.tolerance if row.compare == "at most" else row.paper - row.tolerance
    return f"{'≤' if row.compare == 'at most' else '≥'} {end:.4g}"


def verdict_text(row: ReproductionRow) -> str:
    """Return whether a row holds, and whether a failure is known or a repair unnoticed; or that it is not judged."""
    if not row.is_judged:
        return "reported, not judged"
    if row.ok:
        worse = ", worse than the paper's" if row.is_worse else ""
        return f"holds{worse}, listed as failing" if row.known_failure else f"holds{worse}"
    return f"{row.verdict}, {'known' if row.known_failure else 'new'}"


def reason_text(row: ReproductionRow) -> str:
    """Return why a row fails or is listed: its interval at the bar, seeds without a number, the reason on the list."""
    said = [row.problem, row.known_reason]
    if row.verdict == "at the bar" and row.median_low is not None and row.median_high is not None:
        low, high = digits_of(row, row.median_low), digits_of(row, row.median_high)
        said.insert(0, f"the median is {low} to {high} with 95 % probability: a limit is inside")
    return "; ".join(text for text in said if text)


def seeds_text(seeds: Sequence[int]) -> str:
    """Return which seeds the numbers are of."""
    if len(seeds) == 1:
        return f"seed {seeds[0]} alone: its own numbers, no medians"
    together = list(seeds) == list(range(seeds[0], seeds[0] + len(seeds)))
    which = f"{seeds[0]} to {seeds[-1]}" if together else ", ".join(map(str, seeds))
    return f"medians over {len(seeds)} seeds, {which}"
