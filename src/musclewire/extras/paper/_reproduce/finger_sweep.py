"""Section 4.2: gaps of the finger over pretension, for two spools (Figs. 16 and 17, Eq. 9)."""

from __future__ import annotations

from functools import partial
from typing import Any

from musclewire.extras.paper._reproduce.finger_runs import COMMON_WIRE, FINGER_WIRE, pretension_n
from musclewire.extras.paper._reproduce.measures import falling_steps, lowest_place, one_sided_fraction
from musclewire.extras.paper._reproduce.paper_checks import PREDICTED_OR_LISTED, PaperCheck
from musclewire.extras.paper._reproduce.runs import RunCache

__all__ = ["SWEEP_N", "gaps_over_pretension", "sweep_checks"]

SPOOLS = ((FINGER_WIRE, "the finger's own spool"), (COMMON_WIRE, "the spool of section III, for comparison"))
# From a nearly slack wire to beyond twice the paper's choice, 0.12 N apart about it.
SWEEP_N = (0.15, 0.25, 0.37, 0.47, 0.59, 0.71, 0.83, 0.95, 1.15, 1.4, 1.7)
PLACE_TOLERANCE_N, GAP_TOLERANCE_PCT = 0.15, 0.7
# Signed over absolute gap from which two branches are said not to intersect.
NO_CROSSING = 0.95


def sweep_checks(printed: dict[str, Any]) -> list[PaperCheck]:
    """Return the checks of Figs. 16 and 17 for both spools.

    Parameters
    ----------
    printed
        Table ``displacement_gap`` of the published results.

    Returns
    -------
    The checks, figure by figure.

    References
    ----------
    Lan and Fan 2010, section 4.2.
    """
    return [
        *(falling_check(wire, whose) for wire, whose in SPOOLS),
        *(check for wire, whose in SPOOLS for check in gap_checks(printed, wire, whose)),
    ]


def gaps_over_pretension(runs: RunCache, wire: str, quantity: str = "displacement") -> list[float]:
    """Return the gap of displacement or force at each pretension of the sweep [%]."""
    return [float(getattr(runs.finger.loop(force, wire), f"{quantity}_gap_pct")) for force in SWEEP_N]


def falling_check(wire: str, whose: str) -> PaperCheck:
    """Return whether the displacement gap falls from the slack end to the chosen pretension (Fig. 16).

    Parameters
    ----------
    wire
        Name of the wire file of the spool.
    whose
        Which spool that is, in the words of the check's explanation.

    Returns
    -------
    The check, by the number of steps of the sweep at which the gap falls.

    References
    ----------
    Lan and Fan 2010, Fig. 16.
    """
    before = SWEEP_N.index(pretension_n())
    return PaperCheck(f"fig16.falling_steps[{wire}]", before, "1", 0.0,
        '"heating and cooling paths are closer with increasing pretension force": steps from the slack end to '
        f"{pretension_n()} N at which the displacement gap falls; {whose}",
        "words", partial(falling_count, wire=wire),
        origin=PREDICTED_OR_LISTED)  # fmt: skip


def gap_checks(printed: dict[str, Any], wire: str, whose: str) -> list[PaperCheck]:
    """Return the displacement gap over pretension (Fig. 17, Eq. 9) for one spool.

    Parameters
    ----------
    printed
        Table ``displacement_gap`` of the published results.
    wire
        Name of the wire file of the spool.
    whose
        Which spool that is, in the words of the checks' explanations.

    Returns
    -------
    The checks: place and size of the smallest gap, and that it grows beyond, where the branches intersect no more.

    References
    ----------
    Lan and Fan 2010, Fig. 17 and Eq. 9.
    """
    force, gap = printed["pretension_n"], printed["displacement_gap_pct"]
    return [
        PaperCheck(f"fig17.smallest_gap_at_n[{wire}]", force, "N", PLACE_TOLERANCE_N,
            f"vertex of the parabola through the lowest three of the sweep; {whose}", "printed",
            partial(smallest_gap_at_n, wire=wire), origin=PREDICTED_OR_LISTED),
        PaperCheck(f"fig17.displacement_gap_pct[{wire},{force:.2f}N]", gap, "%", GAP_TOLERANCE_PCT,
            f"Eq. 9 at the chosen pretension; 0.7 points, a third of it; {whose}", "printed",
            partial(gap_at_choice_pct, wire=wire), origin=PREDICTED_OR_LISTED),
        PaperCheck(f"fig17.grows_again_pct[{wire}]", 0.0, "%", 0.0,
            '"if the pretension force is too large, the paths move away from each other": gap at the largest setting '
            f"less that at {force} N, above 0; {whose}",
            "words", partial(grows_again_pct, wire=wire), "at least",
            origin=PREDICTED_OR_LISTED),
        PaperCheck(f"fig17.one_sided_fraction[{wire},{SWEEP_N[-1]:.2f}N]", NO_CROSSING, "1", 0.0,
            '"if the pretension force is too large, the heating and cooling curves have no intersection": mean signed '
            "difference at equal resistance over the mean absolute one, at the largest setting: 1 without an "
            f"intersection; 0.05 less for noise at the ends B and C, where the curves meet; {whose}",
            "words", partial(one_sided_at_largest, wire=wire), "at least",
            origin=PREDICTED_OR_LISTED),
    ]  # fmt: skip


def falling_count(runs: RunCache, *, wire: str) -> float:
    """Return at how many steps up to the chosen pretension the displacement gap falls."""
    before = SWEEP_N.index(pretension_n())
    return falling_steps(gaps_over_pretension(runs, wire)[: before + 1])


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
