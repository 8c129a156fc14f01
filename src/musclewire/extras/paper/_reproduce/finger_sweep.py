"""Section 4.2: gaps of the finger over pretension, for two spools (Figs. 16 and 17, Eq. 9)."""

from __future__ import annotations

from musclewire.extras.paper._reproduce.finger_runs import pretension_n
from musclewire.extras.paper._reproduce.measures import (
    falling_steps,
    lowest_place,
    one_sided_fraction,
    rank_correlation,
)
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.extras.paper._reproduce.section2 import strain_gap_pct
from musclewire.parameters import read_published

# From a nearly slack wire to beyond twice the paper's choice, 0.12 N apart about it.
SWEEP_N = (0.15, 0.25, 0.37, 0.47, 0.59, 0.71, 0.83, 0.95, 1.15, 1.4, 1.7)


def gaps_over_pretension(runs: RunCache, wire: str, quantity: str = "displacement") -> list[float]:
    """Return the gap of displacement or force at each pretension of the sweep [%]."""
    return [float(getattr(runs.finger.loop(force, wire), f"{quantity}_gap_pct")) for force in SWEEP_N]


def gaps_to_choice_pct(runs: RunCache, wire: str, quantity: str = "displacement") -> list[float]:
    """Return the gap at each pretension of the sweep up to the chosen one [%]."""
    return gaps_over_pretension(runs, wire, quantity)[: SWEEP_N.index(pretension_n()) + 1]


def falling_count(runs: RunCache, *, wire: str) -> float:
    """Return at how many steps up to the chosen pretension the displacement gap falls."""
    return falling_steps(gaps_to_choice_pct(runs, wire))


def fall_over_fig4(runs: RunCache, *, wire: str) -> float:
    """Return the fall of the displacement gap up to the chosen pretension over that of the strain gap in Fig. 4."""
    slack, *_, chosen = gaps_to_choice_pct(runs, wire)
    low, high = read_published("lan_fan_2010")["strain_gap_125um"]["pretension_n"]
    return (slack - chosen) / (strain_gap_pct(runs, force_n=low) - strain_gap_pct(runs, force_n=high))


def force_gap_fall(runs: RunCache, *, wire: str) -> float:
    """Return the rank correlation of force gap and pretension up to the chosen one."""
    gaps = gaps_to_choice_pct(runs, wire, "force")
    return rank_correlation(SWEEP_N[: len(gaps)], gaps)


def smallest_gap_at_n(runs: RunCache, *, wire: str) -> float:
    """Return the pretension of the smallest displacement gap [N]."""
    return lowest_place(SWEEP_N, gaps_over_pretension(runs, wire))


def gap_at_choice_pct(runs: RunCache, *, wire: str) -> float:
    """Return the displacement gap at the chosen pretension [%]."""
    return runs.finger.loop(pretension_n(), wire).displacement_gap_pct


def grows_again_pct(runs: RunCache, *, wire: str) -> float:
    """Return how much the gap has grown from the chosen pretension to the largest setting [%]."""
    return gaps_over_pretension(runs, wire)[-1] - gap_at_choice_pct(runs, wire=wire)


def one_sided_at_largest(runs: RunCache, *, wire: str) -> float:
    """Return how far the branches are apart without an intersection at the largest pretension, 1 for wholly."""
    return one_sided_fraction(*runs.finger.loop(SWEEP_N[-1], wire).sensing_branches("displacement"))
