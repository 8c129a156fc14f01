"""Published isobars of Flexinol, not in the paper: the same alloy under constant stress."""

from __future__ import annotations

from functools import partial
from typing import Any

from musclewire.experiment.reproduce.paper_checks import PaperCheck
from musclewire.experiment.reproduce.runs import Runs
from musclewire.identify.isobaric_loops import half_transformation_slope_pa_per_k
from musclewire.parameters.library import read_published

__all__ = ["checks"]

ZERO_CELSIUS_K = 273.15
STROKE_TOLERANCE_PCT, HALF_TOLERANCE_K, SLOPE_TOLERANCE_MPA_PER_K = 0.3, 4.0, 1.0
# The ends of a branch: name of the row, its place among 10, 50 and 90 %.
TAILS = (("tenth", 0), ("nine_tenths", 2))
TAIL_TOLERANCE_K = 7.0
HALF_WHY = (
    "temperature at which half the stroke is done; 4 K: spools and heat treatments differ by 10 K and more, and one "
    "shift for the sample is all that is fitted to it"
)


def checks() -> list[PaperCheck]:
    """Return checks of strokes, half-transformation temperatures and slopes against the measured ones."""
    published = read_published("flexinol_isobars")
    strokes = [
        PaperCheck(f"isobars.stroke_pct[{stress:.0f}MPa]", published["stroke_pct"][index], "% strain",
            STROKE_TOLERANCE_PCT, "0.3 %: a fifteenth of the stroke; set before the alloy was fitted",
            "literature", partial(stroke_pct, stress_mpa=stress), origin="fitted")
        for index, stress in enumerate(published["stress_mpa"])
    ]  # fmt: skip
    halves = [
        PaperCheck(f"isobars.half_{branch}_degc[{stress:.0f}MPa]", published[f"{branch}_degc"][index][1], "C",
            HALF_TOLERANCE_K, HALF_WHY, "literature",
            partial(branch_degc, branch=branch, stress_mpa=stress, place=1), origin="fitted")
        for branch in ("heating", "cooling")
        for index, stress in enumerate(published["stress_mpa"])
    ]  # fmt: skip
    return strokes + halves + tail_checks(published) + [
        PaperCheck(f"isobars.{branch}_slope_mpa_per_k", published[f"{branch}_slope_mpa_per_k"], "MPa/K",
            SLOPE_TOLERANCE_MPA_PER_K, "straight line through the half-transformation temperatures; published slopes "
            "of NiTi wire lie between 5 and 12 MPa/K", "literature", partial(slope_mpa_per_k, branch=branch),
            origin="fitted")
        for branch in ("heating", "cooling")
    ]  # fmt: skip


def tail_checks(published: dict[str, Any]) -> list[PaperCheck]:
    """Return checks of the temperatures at which a tenth and nine tenths of each branch are done."""
    why = (
        "temperature at which 10 or 90 % of the branch are done; 7 K: the 4 K of the halves, and 3 K "
        "that the flattest of the measured curves takes for a twentieth of the stroke"
    )
    return [
        PaperCheck(f"isobars.{name}_{branch}_degc[{stress:.0f}MPa]", published[f"{branch}_degc"][index][place], "C",
            TAIL_TOLERANCE_K, why, "literature",
            partial(branch_degc, branch=branch, stress_mpa=stress, place=place), origin="fitted")
        for name, place in TAILS
        for branch in ("heating", "cooling")
        for index, stress in enumerate(published["stress_mpa"])
    ]  # fmt: skip


def stroke_pct(runs: Runs, *, stress_mpa: float) -> float:
    """Return the stroke of an isobar [% strain]."""
    return 100.0 * runs.isobar_summary(stress_mpa).stroke


def branch_degc(runs: Runs, *, branch: str, stress_mpa: float, place: int) -> float:
    """Return the temperature at which 10, 50 or 90 % (``place`` 0, 1, 2) of a branch are done [C]."""
    return float(getattr(runs.isobar_summary(stress_mpa), f"{branch}_k")[place]) - ZERO_CELSIUS_K


def slope_mpa_per_k(runs: Runs, *, branch: str) -> float:
    """Return the Clausius-Clapeyron slope of a branch [MPa/K]."""
    stresses = read_published("flexinol_isobars")["stress_mpa"]
    return 1e-6 * half_transformation_slope_pa_per_k([runs.isobar_summary(stress) for stress in stresses], branch)
