"""Equations 1 to 7: whether the runs obey them, computed independently of the code that ran."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from musclewire.controllers import DEFAULT_RULE_BASE, gain_from_ratio, infer_surface, load_rule_base
from musclewire.experiment import determined
from musclewire.extras.paper._reproduce.measures import plain_gap_pct
from musclewire.extras.paper._reproduce.paper_checks import Compare, PaperCheck
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.parameters import read_published

__all__ = ["checks"]

RATIO_OF = {"proportional_gain": "kp", "integral_gain": "ki", "derivative_gain": "kd"}
UNITS = {"proportional_gain": "1", "integral_gain": "1/s", "derivative_gain": "s"}
REACH_FRACTION = 0.05


def checks() -> list[PaperCheck]:
    """Return the checks of Eqs. 1 to 7; unless noted otherwise ours is a deviation, and 0 would be exact."""
    return [
        deviation("eq1.resistance_rms_error_ohm", "ohm", 0.01, resistance_error_ohm,
            "rms from B to C of Eq. 1 against the simulated wire's own resistance; 0.01 ohm: half of what R_min and "
            "R_max may be off; what is left is the converter's noise, and that a reading is a mean over its sample"),
        deviation("eq2.gap_difference_pct", "%", 0.1, gap_difference_pct,
            "the gap by NumPy alone, samples sorted by resistance, against ours; 0.1 points: ours smooths first, and "
            "the noise that stays in the plain way widens its gap a little"),
        PaperCheck("eq3.normalised_resistance[R_min]", 0.0, "1", 1e-9, "exact but for rounding", "equation",
            partial(normalised_at, end="resistance_min_ohm"), origin="definition"),
        PaperCheck("eq3.normalised_resistance[R_max]", 1.0, "1", 1e-9, "exact but for rounding", "equation",
            partial(normalised_at, end="resistance_max_ohm"), origin="definition"),
        *polyfit_checks(),
        deviation("eq5.average_difference_pct", "% strain", 1e-6, average_difference_pct,
            "largest difference of g_a from the mean of g_h and g_c: exact but for rounding"),
        deviation("eq5.inverse_difference_pct", "% strain", 1e-6, inverse_difference_pct,
            "a strain's required resistance put back into g_a: exact but for rounding"),
        *gain_checks(),
        deviation("eq7.mae_difference_pct", "% of target", 1e-6, mae_difference_pct,
            "largest difference of a step's MAE from the same mean taken plainly from the recording: exact but for "
            "rounding"),
    ]  # fmt: skip


def polyfit_checks() -> list[PaperCheck]:
    """Return the check of Eq. 4 for both branches."""
    return [
        deviation(f"eq4.polyfit_rms_difference_pct[{branch}]", "% strain", 0.02,
            partial(polyfit_difference_pct, branch=branch),
            "numpy.polyfit of order six on the plain samples against our polynomial, rms over B to C; 0.02 %: "
            "what Table 2's strains may be off rms; polyfit weighs samples, ours weighs resistance")
        for branch in ("heating", "cooling")
    ]  # fmt: skip


def deviation(name: str, unit: str, tolerance: float, measure: Callable[[RunCache], float], why: str) -> PaperCheck:
    """Return a check that a deviation is at most ``tolerance``."""
    return PaperCheck(name, 0.0, unit, tolerance, why, "equation", measure, "at most", origin="definition")


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
    from musclewire.sensing import normalised_resistance

    model = runs.model
    return float(normalised_resistance(getattr(model, end), model.resistance_min_ohm, model.resistance_max_ohm))


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


def gain_checks() -> list[PaperCheck]:
    """Return checks that each gain stays in its printed range over the staircase, and that it can reach both ends."""
    printed = read_published("lan_fan_2010")["controller"]
    sides: tuple[tuple[str, int, Compare], ...] = (("least", 0, "at least"), ("largest", 1, "at most"))
    inside = "Eq. 6 keeps a gain in its printed range, exactly; over the whole staircase with its approach"
    reach = (
        "the gain over all errors and changes of error, the same rule base; 5 % of the printed range: the "
        "logarithmic output sets of Zhao et al. end at 0.02 and 0.98, not at 0 and 1"
    )
    return [
        PaperCheck(f"eq6.{gain}[{end}]", printed[gain][place], UNITS[gain], 0.0, inside, "printed",
            partial(gain_end, gain=gain, end=end), side, origin="definition")
        for gain in RATIO_OF
        for end, place, side in sides
    ] + [
        PaperCheck(f"eq6.{gain}_reach[{end}]", printed[gain][place], UNITS[gain],
            REACH_FRACTION * (printed[gain][1] - printed[gain][0]), reach, "printed",
            partial(gain_reach, gain=gain, end=end, low=printed[gain][0], high=printed[gain][1]), origin="definition")
        for gain in RATIO_OF
        for end, place, _ in sides
    ]  # fmt: skip


def gain_end(runs: RunCache, *, gain: str, end: str) -> float:
    """Return the minimum or maximum of a gain while the loop was closed."""
    values = runs.control_run[gain]
    used = values[values > 0.0]
    return float(used.min() if end == "least" else used.max())


def gain_reach(_runs: RunCache, *, gain: str, end: str, low: float, high: float) -> float:
    """Return the minimum or maximum of a gain over the plane of error and change of error."""
    places = np.linspace(-1.0, 1.0, 41)
    surface = infer_surface(load_rule_base(DEFAULT_RULE_BASE), places[:, None], places[None, :])
    ratios = getattr(surface, RATIO_OF[gain])
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
