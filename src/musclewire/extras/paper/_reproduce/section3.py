"""Section III: polynomials, the strains of Table 2, the staircase's trace (Figs. 9 and 12)."""

from __future__ import annotations

import numpy as np

from musclewire.experiment import elapsed
from musclewire.extras.paper._reproduce.measures import outside_band, plain_gap_pct
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.identify import fit, required_quantity
from musclewire.parameters import read_published
from musclewire.sensing import SensingModel


def resistance_ohm(runs: RunCache, *, end: str) -> float:
    """Return R_min or R_max of our model [ohm]."""
    return float(getattr(runs.model, f"resistance_{end}_ohm"))


def order(runs: RunCache) -> float:
    """Return the order of our model's polynomials."""
    return float(runs.model.order)


def strain_gap_pct(runs: RunCache) -> float:
    """Return the strain gap of the loop of Fig. 9 [%]."""
    return runs.main_loop().strain_gap_pct


def strain_gap_plainly_pct(runs: RunCache) -> float:
    """Return the same by Eq. 2 as printed, without smoothing [%]."""
    return plain_gap_pct(runs.main_loop())


def fit_rms_pct(runs: RunCache, *, branch: str) -> float:
    """Return the rms of a branch's samples about its polynomial [% strain]."""
    return float(100.0 * getattr(runs.model, f"rmse_{branch}"))


def other_model_error_pct(runs: RunCache, *, wire: str, force_n: float) -> float:
    """Return how far our model is from that of another wire or pretension at equal resistance [% of S_max]."""
    other = fit(runs.loop(wire, force_n).recording)
    low = max(runs.model.resistance_min_ohm, other.resistance_min_ohm)
    high = min(runs.model.resistance_max_ohm, other.resistance_max_ohm)
    return distance_of_models_pct(runs.model, (low, high), other, (low, high))


def other_polynomials_error_pct(runs: RunCache, *, wire: str, force_n: float) -> float:
    """Return the same at equal lambda, each of its own R_min and R_max [% of S_max]."""
    models = runs.model, fit(runs.loop(wire, force_n).recording)
    ours, other = ((model, (model.resistance_min_ohm, model.resistance_max_ohm)) for model in models)
    return distance_of_models_pct(*ours, *other)


def distance_of_models_pct(
    ours: SensingModel, ours_ohm: tuple[float, float], other: SensingModel, other_ohm: tuple[float, float]
) -> float:
    """Return the mean distance of two averages, each over its span of resistances [% of the other's largest strain]."""
    strain, true = (
        np.asarray(model.strain(np.linspace(*ends, 400))) for model, ends in ((ours, ours_ohm), (other, other_ohm))
    )
    return float(100.0 * np.abs(strain - true).mean() / true.max())


def required_ohm(runs: RunCache, *, target_pct: float) -> float:
    """Return the resistance our model requires for a strain."""
    return runs.model.resistance_ohm(target_pct / 100.0)


def strain_at_pct(runs: RunCache, *, branch: str, ohm: float) -> float:
    """Return a branch's polynomial at a resistance [% strain]."""
    return float(100.0 * getattr(runs.model, f"strain_{branch}")(ohm))


def strain_of_table_pct(runs: RunCache, *, branch: str, target_pct: float) -> float:
    """Return a branch's polynomial at the resistance that Table 2 prints for a strain [% strain]."""
    table = read_published("lan_fan_2010")["table2"]
    ohm = table["required_resistance_ohm"][table["desired_strain_pct"].index(target_pct)]
    return strain_at_pct(runs, branch=branch, ohm=ohm)


def strain_rms_pct(runs: RunCache) -> float:
    """Return the rms difference of both branches from the twelve printed strains [% strain]."""
    table = read_published("lan_fan_2010")["table2"]
    differences = [
        strain_at_pct(runs, branch=branch, ohm=ohm) - strain
        for branch in ("heating", "cooling")
        for ohm, strain in zip(table["required_resistance_ohm"], table[f"strain_{branch}_pct"], strict=True)
    ]
    return float(np.sqrt(np.mean(np.square(differences))))


def outside_band_pct(runs: RunCache) -> float:
    """Return the largest distance of the staircase's trace from the band between the branches [% strain]."""
    run = runs.control_run
    heating, cooling = runs.main_loop().sensing_branches("strain")
    counted = elapsed(run) > 0.0
    return 100.0 * outside_band(run["wire_resistance_ohm"][counted], required_quantity(run)[counted], heating, cooling)
