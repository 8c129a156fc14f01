"""Published isobars of Flexinol, not in the paper: the same alloy under constant stress."""

from __future__ import annotations

from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.identify import half_transformation_slope_pa_per_k
from musclewire.parameters import read_published

ZERO_CELSIUS_K = 273.15
PARTS = ("tenth", "half", "nine_tenths")


def stroke_pct(runs: RunCache, *, stress_mpa: float) -> float:
    """Return the stroke of an isobar [% strain]."""
    return 100.0 * runs.isobar_summary(stress_mpa).stroke


def branch_degc(runs: RunCache, *, branch: str, stress_mpa: float, part: str) -> float:
    """Return the temperature at which 10, 50 or 90 % of a branch are done [C]."""
    return float(getattr(runs.isobar_summary(stress_mpa), f"{branch}_k")[PARTS.index(part)]) - ZERO_CELSIUS_K


def slope_mpa_per_k(runs: RunCache, *, branch: str) -> float:
    """Return the Clausius-Clapeyron slope of a branch [MPa/K]."""
    stresses = read_published("flexinol_isobars")["stress_mpa"]
    return 1e-6 * half_transformation_slope_pa_per_k([runs.isobar_summary(stress) for stress in stresses], branch)


def largest_stroke_pct(runs: RunCache) -> float:
    """Return the largest stroke of the isobars [% strain]."""
    stresses = read_published("flexinol_isobars")["stress_mpa"]
    return max(stroke_pct(runs, stress_mpa=stress) for stress in stresses)
