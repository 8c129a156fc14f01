"""Equations 1 to 7: whether the runs obey them, computed independently of the code that ran."""

from __future__ import annotations

import numpy as np

from musclewire.controllers import DEFAULT_RULE_BASE, gain_from_ratio, infer_surface, load_rule_base
from musclewire.experiment import determined
from musclewire.extras.paper._reproduce.measures import plain_gap_pct
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.parameters import read_published
from musclewire.sensing import normalised_resistance

RATIO_OF = {"proportional_gain": "kp", "integral_gain": "ki", "derivative_gain": "kd"}
ENDS = {"R_min": "resistance_min_ohm", "R_max": "resistance_max_ohm"}


def resistance_error_ohm(runs: RunCache) -> float:
    """Return the rms difference of Eq. 1 from the simulated truth from B to C, both branches."""
    loop = runs.main_loop()
    found = loop.gaps.segments
    part = slice(found.heating_b, found.cooling_b + 1)
    difference = loop.resistance_ohm[part] - loop.true_resistance_ohm[part]
    return float(np.sqrt(np.mean(difference**2)))


def gap_difference_pct(runs: RunCache) -> float:
    """Return the difference of the gap by plain means from ours."""
    loop = runs.main_loop()
    return abs(plain_gap_pct(loop) - loop.strain_gap_pct)


def normalised_at(runs: RunCache, *, end: str) -> float:
    """Return Eq. 3 at one end of segment B-C."""
    model = runs.model
    return float(normalised_resistance(getattr(model, ENDS[end]), model.resistance_min_ohm, model.resistance_max_ohm))


def polyfit_difference_pct(runs: RunCache, *, branch: str) -> float:
    """Return the rms difference of our polynomial of a branch from numpy.polyfit's over the model's range."""
    model = runs.model
    samples = getattr(runs.main_loop().gaps.segments, branch)
    span = model.resistance_max_ohm - model.resistance_min_ohm
    fitted = np.polyfit((samples.resistance_ohm - model.resistance_min_ohm) / span, samples.quantity, model.order)
    grid = np.linspace(*model.valid_resistance_ohm, 400)
    ours = np.asarray(getattr(model, f"strain_{branch}")(grid))
    theirs = np.polyval(fitted, (grid - model.resistance_min_ohm) / span)
    return float(100.0 * np.sqrt(np.mean((ours - theirs) ** 2)))


def average_difference_pct(runs: RunCache) -> float:
    """Return the largest difference of g_a from the mean of both branches."""
    model = runs.model
    grid = np.linspace(*model.valid_resistance_ohm, 400)
    mean = (np.asarray(model.strain_heating(grid)) + np.asarray(model.strain_cooling(grid))) / 2.0
    return float(100.0 * np.abs(np.asarray(model.strain(grid)) - mean).max())


def inverse_difference_pct(runs: RunCache) -> float:
    """Return the largest difference of Table 2's six strains after conversion to resistance and back."""
    model = runs.model
    desired = np.array(read_published("lan_fan_2010")["table2"]["desired_strain_pct"]) / 100.0
    return float(100.0 * np.abs(np.asarray(model.strain(np.asarray(model.resistance_ohm(desired)))) - desired).max())


def gain_end(runs: RunCache, *, gain: str, end: str) -> float:
    """Return the minimum or maximum of a gain while the loop was closed."""
    values = runs.control_run[gain]
    used = values[values > 0.0]
    return float(used.min() if end == "least" else used.max())


def gain_reach(_runs: RunCache, *, gain: str, end: str) -> float:
    """Return the minimum or maximum of a gain over the plane of error and change of error."""
    places = np.linspace(-1.0, 1.0, 41)
    surface = infer_surface(load_rule_base(DEFAULT_RULE_BASE), places[:, None], places[None, :])
    ratios = getattr(surface, RATIO_OF[gain])
    low, high = read_published("lan_fan_2010")["controller"][gain]
    return float(gain_from_ratio(float(ratios.min() if end == "least" else ratios.max()), low, high))


def mae_difference_pct(runs: RunCache) -> float:
    """Return the largest difference between our MAE and Eq. 7 taken plainly from the recording."""
    run, settle_s = runs.control_run, read_published("lan_fan_2010")["staircase"]["settle_s"]
    strain = run["displacement_m"] / run.facts.leg_length_m
    period_s, approach_s = run.facts.sample_period_s, run.facts.approach_s
    hold_s = runs.staircase.hold_s
    first, held, settle = (round(seconds / period_s) for seconds in (approach_s, hold_s, settle_s))
    differences = []
    for index, step in enumerate(run.metrics.steps):
        counted = strain[first + index * held + settle : first + (index + 1) * held]
        plain = 100.0 * np.mean(np.abs(counted - step.target)) / step.target
        differences.append(abs(plain - determined(step.mae_approached_pct, "a step's error")))
    return float(max(differences))
