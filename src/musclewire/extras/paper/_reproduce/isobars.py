"""Published isobars of Flexinol, not in the paper: the same alloy under constant stress."""

from __future__ import annotations

from functools import partial
from typing import Any

from musclewire.extras.paper._reproduce.paper_checks import PREDICTED_OR_LISTED, PaperCheck
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.identify import half_transformation_slope_pa_per_k
from musclewire.parameters import read_published

__all__ = ["checks"]

ZERO_CELSIUS_K = 273.15
STROKE_TOLERANCE_PCT, HALF_TOLERANCE_K, SLOPE_TOLERANCE_MPA_PER_K = 0.3, 4.0, 1.0
# Parts of a branch: name of the row, its place among 10, 50 and 90 %.
HALF, TAILS = ("half", 1), (("tenth", 0), ("nine_tenths", 2))
TAIL_TOLERANCE_K = 7.0
HALF_WHY = (
    "temperature at which half the stroke is done; 4 K: spools and heat treatments differ by 10 K and more, and one "
    "shift for the sample is all that is fitted to it"
)
TAIL_WHY = (
    "temperature at which 10 or 90 % of the branch are done, as recorded; 7 K: the 4 K of the halves, and 3 K "
    "that the flattest of the measured curves takes for a twentieth of the stroke"
)
HELD_OUT_WHY = (
    "no search has used this isobar; it has used others of the same sample, at stresses on either side of it; the "
    "tolerance is theirs"
)
# Beginning of the name of a row, by whether its isobar is held out.
PREFIX = {False: "", True: "held_out_"}


def checks() -> list[PaperCheck]:
    """Return checks of strokes, temperatures and slopes against the measured isobars, and against those held out."""
    published = read_published("flexinol_isobars")
    return (
        stroke_checks(published)
        + temperature_checks(published, (HALF,), HALF_TOLERANCE_K, HALF_WHY)
        + temperature_checks(published, TAILS, TAIL_TOLERANCE_K, TAIL_WHY)
        + slope_checks(published)
        + held_out_checks(published["held_out"])
    )


def held_out_checks(published: dict[str, Any]) -> list[PaperCheck]:
    """Return the same checks against the isobars that no search uses, stress by stress as the others."""
    return (
        stroke_checks(published, held_out=True)
        + temperature_checks(published, (HALF,), HALF_TOLERANCE_K, HELD_OUT_WHY, held_out=True)
        + temperature_checks(published, TAILS, TAIL_TOLERANCE_K, HELD_OUT_WHY, held_out=True)
    )


def stroke_checks(published: dict[str, Any], *, held_out: bool = False) -> list[PaperCheck]:
    """Return checks of the strokes."""
    why = HELD_OUT_WHY if held_out else "0.3 %: a fifteenth of the stroke; set before the alloy was fitted"
    return [
        PaperCheck(f"isobars.{PREFIX[held_out]}stroke_pct[{stress:.0f}MPa]", published["stroke_pct"][index],
            "% strain", STROKE_TOLERANCE_PCT, why, "literature", partial(stroke_pct, stress_mpa=stress),
            origin=PREDICTED_OR_LISTED)
        for index, stress in enumerate(published["stress_mpa"])
    ]  # fmt: skip


def temperature_checks(
    published: dict[str, Any],
    parts: tuple[tuple[str, int], ...],
    tolerance_k: float,
    why: str,
    *,
    held_out: bool = False,
) -> list[PaperCheck]:
    """Return checks of the temperatures at which some parts of each branch are done."""
    return [
        PaperCheck(f"isobars.{PREFIX[held_out]}{name}_{branch}_degc[{stress:.0f}MPa]",
            published[f"{branch}_degc"][index][place], "C", tolerance_k, why, "literature",
            partial(branch_degc, branch=branch, stress_mpa=stress, place=place), origin=PREDICTED_OR_LISTED)
        for name, place in parts
        for branch in ("heating", "cooling")
        for index, stress in enumerate(published["stress_mpa"])
    ]  # fmt: skip


def slope_checks(published: dict[str, Any]) -> list[PaperCheck]:
    """Return checks of the Clausius-Clapeyron slopes."""
    return [
        PaperCheck(f"isobars.{branch}_slope_mpa_per_k", published[f"{branch}_slope_mpa_per_k"], "MPa/K",
            SLOPE_TOLERANCE_MPA_PER_K, "straight line through the half-transformation temperatures; published slopes "
            "of NiTi wire lie between 5 and 12 MPa/K", "literature", partial(slope_mpa_per_k, branch=branch),
            origin=PREDICTED_OR_LISTED)
        for branch in ("heating", "cooling")
    ]  # fmt: skip


def stroke_pct(runs: RunCache, *, stress_mpa: float) -> float:
    """Return the stroke of an isobar [% strain]."""
    return 100.0 * runs.isobar_summary(stress_mpa).stroke


def branch_degc(runs: RunCache, *, branch: str, stress_mpa: float, place: int) -> float:
    """Return the temperature at which 10, 50 or 90 % (``place`` 0, 1, 2) of a branch are done [C]."""
    return float(getattr(runs.isobar_summary(stress_mpa), f"{branch}_k")[place]) - ZERO_CELSIUS_K


def slope_mpa_per_k(runs: RunCache, *, branch: str) -> float:
    """Return the Clausius-Clapeyron slope of a branch [MPa/K]."""
    stresses = read_published("flexinol_isobars")["stress_mpa"]
    return 1e-6 * half_transformation_slope_pa_per_k([runs.isobar_summary(stress) for stress in stresses], branch)
