"""Section 2.2: gaps of three diameters at equal fractions of their maximal force (Fig. 6)."""

from __future__ import annotations

from functools import partial

import numpy as np

from musclewire.extras.paper._reproduce.loops import SlowSineLoop
from musclewire.extras.paper._reproduce.measures import lowest_place, rank_correlation
from musclewire.extras.paper._reproduce.paper_checks import PREDICTED_OR_LISTED, PaperCheck
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.extras.paper._reproduce.table1 import WIRES, diameter_label
from musclewire.parameters import load_wire

__all__ = ["FALLING", "FORCE_RATIOS", "MIDDLE_RATIO", "diameter_checks", "loops_at_ratio"]

FORCE_RATIOS = (0.25, 0.35, 0.45, 0.55, 0.65)
# Spearman's correlation of gap and force ratio, at most; and the force ratio that the smallest gap must lie beyond.
FALLING, MIDDLE_RATIO = -0.7, 0.45


def loops_at_ratio(runs: RunCache, wire: str) -> list[SlowSineLoop]:
    """Return the loops of a wire at every force ratio of Fig. 6."""
    largest = load_wire(wire).maximum_force_n.value
    return [runs.loop(wire, round(ratio * largest, 3)) for ratio in FORCE_RATIOS]


def diameter_checks() -> list[PaperCheck]:
    """Return checks of Fig. 6: order of the wires, each wire's gap over force ratio, strain gaps under force gaps."""
    labels = " < ".join(diameter_label(wire) for wire in WIRES)
    order = PaperCheck(
        "fig6a.ratios_in_order", len(FORCE_RATIOS), "1", 0.0,
        f"force ratios of {FORCE_RATIOS} at which the strain gaps are in the order {labels}: all of them",
        "words", ratios_in_order, origin=PREDICTED_OR_LISTED)  # fmt: skip
    why = (
        '"the S-R curves can be tuned to exhibit the smallest gap": the smallest force gap over the force ratios less '
        "the smallest strain gap, above 0"
    )
    under = [
        PaperCheck(f"fig6b.force_gap_less_strain_gap_pct[{diameter_label(wire)}]", 0.0, "%", 0.0, why, "words",
            partial(force_less_strain_pct, wire=wire), "at least",
            origin=PREDICTED_OR_LISTED)
        for wire in WIRES
    ]  # fmt: skip
    return [order, *(check for wire in WIRES for check in falling_gap_checks(wire)), *under]


def falling_gap_checks(wire: str) -> list[PaperCheck]:
    """Return whether a wire's strain gap falls over the force ratios, and where it is smallest (sections 2.2, 2.3)."""
    label = diameter_label(wire)
    falls = (
        '"larger pretension forces, the gaps between heating and cooling paths are smaller": Spearman\'s rank '
        f"correlation of strain gap and force ratio over {FORCE_RATIOS}; 0.3 short of -1: one of the five gaps may be "
        "out of order by two places"
    )
    smallest = (
        "the same sentence: force ratio of the smallest strain gap, the vertex of the parabola through the lowest "
        f"three of {FORCE_RATIOS}, or an end; in the upper half of the ratios"
    )
    return [
        PaperCheck(f"fig6a.gap_rank_correlation[{label}]", -1.0, "1", round(FALLING + 1.0, 9), falls, "words",
            partial(gap_rank_correlation, wire=wire), "at most",
            origin=PREDICTED_OR_LISTED),
        PaperCheck(f"fig6a.smallest_gap_at_ratio[{label}]", MIDDLE_RATIO, "1", 0.0, smallest, "words",
            partial(smallest_gap_at_ratio, wire=wire), "at least",
            origin=PREDICTED_OR_LISTED),
    ]  # fmt: skip


def strain_gaps_pct(runs: RunCache, wire: str) -> list[float]:
    """Return a wire's strain gap at every force ratio [%]."""
    return [loop.strain_gap_pct for loop in loops_at_ratio(runs, wire)]


def ratios_in_order(runs: RunCache) -> float:
    """Return the number of force ratios at which the smaller of all three wires has the smaller strain gap."""
    gaps = np.array([strain_gaps_pct(runs, wire) for wire in WIRES])
    return float((np.diff(gaps, axis=0) > 0.0).all(axis=0).sum())


def gap_rank_correlation(runs: RunCache, *, wire: str) -> float:
    """Return the rank correlation of a wire's strain gap with the force ratio."""
    return rank_correlation(FORCE_RATIOS, strain_gaps_pct(runs, wire))


def smallest_gap_at_ratio(runs: RunCache, *, wire: str) -> float:
    """Return the force ratio of a wire's smallest strain gap."""
    return lowest_place(FORCE_RATIOS, strain_gaps_pct(runs, wire))


def force_less_strain_pct(runs: RunCache, *, wire: str) -> float:
    """Return the smallest force gap less the smallest strain gap of a wire [%]."""
    smallest_force_gap_pct = min(loop.force_gap_pct for loop in loops_at_ratio(runs, wire))
    return smallest_force_gap_pct - min(strain_gaps_pct(runs, wire))
