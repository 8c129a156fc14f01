"""A row's numbers as text, the same on the page and in the terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from musclewire.experiment.reproduce import ReproductionRow

__all__ = ["limit_text", "number_text", "ours_text", "paper_text", "verdict"]


def paper_text(row: ReproductionRow) -> str:
    """Return the paper's number as printed; a dash where it prints none and speaks in words or symbols."""
    return f"{row.paper:.6g}" if has_printed_number(row) else "–"


def has_printed_number(row: ReproductionRow) -> bool:
    """Return whether the number we compare with is in print."""
    return row.kind not in {"words", "equation"}


def ours_text(row: ReproductionRow) -> str:
    """Return our number with the digits that its tolerance requires, or the paper's; a dash for None."""
    if row.ours is None:
        return "–"
    if row.tolerance <= 0.0:
        return f"{row.ours:.6g}" if row.compare == "within" else f"{row.ours:.3g}"
    return number_text(row.ours, row.tolerance, len(f"{row.paper:.6g}".partition(".")[2]))


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


def verdict(row: ReproductionRow) -> str:
    """Return whether a row holds, and whether a failure is known or a repair unnoticed; or that it is not judged."""
    if not row.is_judged:
        return "reported, not judged"
    if row.ok:
        return "holds, listed as failing" if row.known_failure else "holds"
    return "fails, known" if row.known_failure else "fails, new"
