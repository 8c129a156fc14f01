"""Section 2.2: gaps of three diameters at equal fractions of their maximal force (Fig. 6)."""

from __future__ import annotations

import numpy as np

from musclewire.extras.paper._reproduce.loops import SlowSineLoop
from musclewire.extras.paper._reproduce.measures import lowest_place, rank_correlation
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.extras.paper._reproduce.table1 import WIRES, wire_name
from musclewire.parameters import load_wire

FORCE_RATIOS = (0.25, 0.35, 0.45, 0.55, 0.65)
# The force ratio that the smallest gap must lie beyond.
MIDDLE_RATIO = 0.45


def loops_at_ratio(runs: RunCache, wire: str) -> list[SlowSineLoop]:
    """Return the loops of a wire at every force ratio of Fig. 6."""
    largest = load_wire(wire).maximum_force_n.value
    return [runs.loop(wire, round(ratio * largest, 3)) for ratio in FORCE_RATIOS]


def strain_gaps_pct(runs: RunCache, wire: str) -> list[float]:
    """Return a wire's strain gap at every force ratio [%]."""
    return [loop.strain_gap_pct for loop in loops_at_ratio(runs, wire)]


def ratios_in_order(runs: RunCache) -> float:
    """Return the number of force ratios at which the smaller of all three wires has the smaller strain gap."""
    gaps = np.array([strain_gaps_pct(runs, wire) for wire in WIRES])
    return float((np.diff(gaps, axis=0) > 0.0).all(axis=0).sum())


def gap_rank_correlation(runs: RunCache, *, diameter_um: int) -> float:
    """Return the rank correlation of a wire's strain gap with the force ratio."""
    return rank_correlation(FORCE_RATIOS, strain_gaps_pct(runs, wire_name(diameter_um)))


def smallest_gap_at_ratio(runs: RunCache, *, diameter_um: int) -> float:
    """Return the force ratio of a wire's smallest strain gap."""
    return lowest_place(FORCE_RATIOS, strain_gaps_pct(runs, wire_name(diameter_um)))


def force_less_strain_pct(runs: RunCache, *, diameter_um: int) -> float:
    """Return the smallest force gap less the smallest strain gap of a wire [%]."""
    wire = wire_name(diameter_um)
    smallest_force_gap_pct = min(loop.force_gap_pct for loop in loops_at_ratio(runs, wire))
    return smallest_force_gap_pct - min(strain_gaps_pct(runs, wire))
