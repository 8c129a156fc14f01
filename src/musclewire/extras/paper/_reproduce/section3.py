"""Section III: polynomials, Table 2, the staircase and its trace (Figs. 9, 11, 12)."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from musclewire.experiment import determined, elapsed
from musclewire.extras.paper._reproduce.measures import outside_band, plain_gap_pct
from musclewire.extras.paper._reproduce.paper_checks import PREDICTED_OR_LISTED, PaperCheck
from musclewire.extras.paper._reproduce.readings import AFTER_APPROACH, from_first_target_checks
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.identify import required_quantity
from musclewire.parameters import read_published

__all__ = ["STEP_TOLERANCE_PCT", "STRAIN_TOLERANCE_PCT", "checks", "strain_at_pct"]

RESISTANCE_TOLERANCE_OHM = 0.02
STRAIN_TOLERANCE_PCT, STRAIN_RMS_PCT = 0.05, 0.02
# 5 % of the 3.55 % strain at R_min.
TRACE_TOLERANCE_PCT = 0.18
# 0.05 % strain on the slope of the printed table, 0.3 % a 0.23 ohm.
REQUIRED_TOLERANCE_OHM = 0.04
STEP_TOLERANCE_PCT, MAX_STEP_TOLERANCE_PCT = 1.0, 0.9
SAME = "taken over from the paper: the number the run was made with"


def checks() -> list[PaperCheck]:
    """Return the checks of Fig. 9, Table 2, Figs. 11 and 12."""
    paper = read_published("lan_fan_2010")
    return [
        *loop_checks(paper["loop_100um"]),
        *strain_checks(paper["table2"]),
        *error_checks(paper["table2"], paper["staircase"]),
        *staircase_checks(paper),
    ]


def loop_checks(printed: dict[str, Any]) -> list[PaperCheck]:
    """Return checks of R_min, R_max, the gap and the polynomials' residuals (Fig. 9).

    Parameters
    ----------
    printed
        Table ``loop_100um`` of the published results.

    Returns
    -------
    The checks; each knows the paper's number, its tolerance and how to find ours.

    References
    ----------
    Lan and Fan 2010, Fig. 9.
    """
    ends = "0.02 ohm: a hundredth of the printed span from R_min to R_max"
    residual = (
        "rms of the samples about their sixth-order polynomial; 0.02 %: no more than Table 2's strains may be off in "
        'rms, so that "sufficient accuracy" is not what limits them'
    )
    return [
        PaperCheck("fig9.resistance_min_ohm", printed["resistance_min_ohm"], "ohm", RESISTANCE_TOLERANCE_OHM, ends,
            "printed", lambda runs: runs.model.resistance_min_ohm, origin=PREDICTED_OR_LISTED),
        PaperCheck("fig9.resistance_max_ohm", printed["resistance_max_ohm"], "ohm", RESISTANCE_TOLERANCE_OHM, ends,
            "printed", lambda runs: runs.model.resistance_max_ohm, origin=PREDICTED_OR_LISTED),
        PaperCheck("fig9.strain_gap_pct[100um,1.90N]", printed["strain_gap_pct"], "%", 0.25,
            "a quarter of a point: a fifth of the printed gap", "printed",
            lambda runs: runs.main_loop().strain_gap_pct, origin=PREDICTED_OR_LISTED),
        PaperCheck("fig9.plain_strain_gap_pct[100um,1.90N]", printed["strain_gap_pct"], "%", 0.25,
            "Eq. 2 as printed, on the samples sorted by resistance, without the smoothing of ours: presumably what the "
            "paper did; noise widens it; the tolerance is that of the smoothed gap", "printed",
            lambda runs: plain_gap_pct(runs.main_loop()), origin=PREDICTED_OR_LISTED),
        PaperCheck("fig9.polynomial_order", printed["polynomial_order"], "1", 0.0, SAME, "input",
            lambda runs: float(runs.model.order), origin="input"),
        *(
            PaperCheck(f"fig9.fit_rms_pct[{branch}]", 0.0, "% strain", STRAIN_RMS_PCT, residual, "words",
                partial(fit_rms_pct, branch=branch), "at most", origin=PREDICTED_OR_LISTED)
            for branch in ("heating", "cooling")
        ),
    ]  # fmt: skip


def fit_rms_pct(runs: RunCache, *, branch: str) -> float:
    """Return the rms of a branch's samples about its polynomial [% strain]."""
    return float(100.0 * getattr(runs.model, f"rmse_{branch}"))


def strain_checks(table: dict[str, Any]) -> list[PaperCheck]:
    """Return the strains of Table 2 at the paper's resistances, and the resistances that ours requires.

    Parameters
    ----------
    table
        Table ``table2`` of the published results.

    Returns
    -------
    The checks; each knows the paper's number, its tolerance and how to find ours.

    References
    ----------
    Lan and Fan 2010, Table 2.
    """
    desired, printed_ohm = table["desired_strain_pct"], table["required_resistance_ohm"]
    found = [
        PaperCheck(f"table2.desired_strain_pct[{target:.1f}]", target, "% strain", 0.0, SAME, "input",
            partial(staircase_level_pct, index=index), origin="input")
        for index, target in enumerate(desired)
    ]  # fmt: skip
    found += [
        PaperCheck(f"table2.required_resistance_ohm[{target:.1f}]", ohm, "ohm", REQUIRED_TOLERANCE_OHM,
            "our own g_a inverted; 0.04 ohm is 0.05 % strain on the slope of the printed table",
            "printed", partial(required_ohm, target_pct=target), origin=PREDICTED_OR_LISTED)
        for target, ohm in zip(desired, printed_ohm, strict=True)
    ]  # fmt: skip
    found += branch_checks(table)
    found.append(
        PaperCheck("table2.strain_rms_pct", 0.0, "% strain", STRAIN_RMS_PCT,
            "rms of the twelve differences; 0.02 %: single ones may be off by more, all together may not",
            "words", strain_rms_pct, "at most", origin=PREDICTED_OR_LISTED)
    )  # fmt: skip
    return found


def branch_checks(table: dict[str, Any]) -> list[PaperCheck]:
    """Return both branches' strains at the paper's resistances."""
    desired, printed_ohm = table["desired_strain_pct"], table["required_resistance_ohm"]
    return [
        PaperCheck(f"table2.strain_{branch}_pct[{target:.1f}]", strain, "% strain", STRAIN_TOLERANCE_PCT,
            "our polynomial at the paper's printed resistance; 0.05 %: a sixth of a step; set before the wire "
            "was fitted",
            "printed", partial(strain_at_pct, branch=branch, ohm=ohm), origin=PREDICTED_OR_LISTED)
        for branch in ("heating", "cooling")
        for target, ohm, strain in zip(desired, printed_ohm, table[f"strain_{branch}_pct"], strict=True)
    ]  # fmt: skip


def staircase_level_pct(runs: RunCache, *, index: int) -> float:
    """Return a level of the staircase that ran [% strain]."""
    return 100.0 * runs.control_run.metrics.steps[index].target


def required_ohm(runs: RunCache, *, target_pct: float) -> float:
    """Return the resistance our model requires for a strain."""
    return runs.model.resistance_ohm(target_pct / 100.0)


def strain_at_pct(runs: RunCache, *, branch: str, ohm: float) -> float:
    """Return a branch's polynomial at a resistance [% strain]."""
    return float(100.0 * getattr(runs.model, f"strain_{branch}")(ohm))


def strain_rms_pct(runs: RunCache) -> float:
    """Return the rms difference of both branches from the twelve printed strains [% strain]."""
    table = read_published("lan_fan_2010")["table2"]
    differences = [
        strain_at_pct(runs, branch=branch, ohm=ohm) - strain
        for branch in ("heating", "cooling")
        for ohm, strain in zip(table["required_resistance_ohm"], table[f"strain_{branch}_pct"], strict=True)
    ]
    return float(np.sqrt(np.mean(np.square(differences))))


def error_checks(table: dict[str, Any], text: dict[str, Any]) -> list[PaperCheck]:
    """Return the MAE of every step, the largest, and the largest of the others (Table 2, Eq. 7).

    Parameters
    ----------
    table
        Table ``table2`` of the published results.
    text
        Table ``staircase`` of the published results: what the text says of the other errors.

    Returns
    -------
    The checks, one for each step and two for the largest errors.

    References
    ----------
    Lan and Fan 2010, Table 2 and Eq. 7.
    """
    found = []
    for direction in ("rise", "return"):
        for target, error in zip(table["desired_strain_pct"], table[f"mae_{direction}_pct"], strict=False):
            found.append(
                PaperCheck(f"table2.mae_{direction}_pct[{target:.1f}]", error, "% of target", STEP_TOLERANCE_PCT,
                    "one-sided, a smaller error is no failure; 1 point: the paper's own steps scatter by more than "
                    "that (0.2 to 2.6 %), and it prints neither its rule base nor the unit of its gains; "
                    + AFTER_APPROACH,
                    "printed", partial(step_mae_pct, target_pct=target, direction=direction), "at most",
                    origin=PREDICTED_OR_LISTED)
            )  # fmt: skip
    printed = [*table["mae_rise_pct"], *table["mae_return_pct"]]
    below = text["other_mae_below_pct"]
    return [
        *found,
        PaperCheck("table2.mae_largest_pct", max(printed), "% of target", MAX_STEP_TOLERANCE_PCT,
            "one-sided; 0.9 points: the closed loop was built to stay below 3.5 %, whatever the wire; "
            + AFTER_APPROACH,
            "printed", lambda runs: determined(runs.control_run.metrics.mae_max_approached_pct, "the largest error"),
            "at most", origin=PREDICTED_OR_LISTED),
        PaperCheck("table2.mae_largest_other_pct", below, "% of target", 0.0,
            f'"for other desired strains, the MAE is less than {below} %": the largest but that of 1.5 % (return); the '
            "paper's own table prints 2.000 there; " + AFTER_APPROACH,
            "words", largest_other_mae_pct, "at most", origin=PREDICTED_OR_LISTED),
        *from_first_target_checks("table2"),
    ]  # fmt: skip


def step_mae_pct(runs: RunCache, *, target_pct: float, direction: str) -> float:
    """Return the MAE of one step after the approach [% of target]."""
    found = [
        step.mae_approached_pct
        for step in runs.control_run.metrics.steps
        if step.direction == direction and abs(100.0 * step.target - target_pct) < 1e-6
    ]
    return determined(found[0], f"the error of the step to {target_pct:g} %")


def largest_other_mae_pct(runs: RunCache) -> float:
    """Return the largest MAE after the approach but that of the last step, 1.5 % on the way back."""
    return max(determined(step.mae_approached_pct, "a step's error") for step in runs.control_run.metrics.steps[:-1])


def staircase_checks(paper: dict[str, Any]) -> list[PaperCheck]:
    """Return checks of Figs. 11 and 12: sizes of the steps, estimate against sensor, the trace within its loop.

    Parameters
    ----------
    paper
        All tables of the published results.

    Returns
    -------
    The checks.

    References
    ----------
    Lan and Fan 2010, Figs. 11 and 12.
    """
    text, largest = paper["staircase"], max(paper["table2"]["mae_return_pct"])
    lowest = min(paper["table2"]["desired_strain_pct"])
    near = round(largest / 100.0 * lowest, 3)
    return [
        PaperCheck("fig11.step_pct", text["step_pct"], "% strain", 0.0, SAME, "input", step_size_pct, origin="input"),
        PaperCheck("fig11.step_s", text["step_s"], "s", 0.0, SAME, "input", lambda runs: runs.staircase.hold_s,
            origin="input"),
        PaperCheck("fig11.estimate_rms_pct", 0.0, "% strain", near,
            f'rms of resistance-converted less actual strain after the approach; "very close" is read as {near} % '
            f"strain, the largest printed MAE ({largest} % of {lowest} %)",
            "words", estimate_rms_pct, "at most", origin=PREDICTED_OR_LISTED),
        PaperCheck("fig12.sample_period_s", paper["controller"]["sample_period_s"], "s", 0.0, SAME, "input",
            lambda runs: float(np.median(np.diff(runs.control_run["time_s"]))), origin="input"),
        PaperCheck("fig12.outside_band_pct", 0.0, "% strain", TRACE_TOLERANCE_PCT,
            "largest distance of a sample of the staircase, noise included, from the band between the loop's branches; "
            '5 % of the largest strain, as "minimal" is read in Fig. 7',
            "words", outside_band_pct, "at most", origin=PREDICTED_OR_LISTED),
    ]  # fmt: skip


def step_size_pct(runs: RunCache) -> float:
    """Return the size of the staircase's steps, the one that differs most from the first."""
    sizes = np.abs(np.diff([step.target for step in runs.control_run.metrics.steps]))
    return float(100.0 * sizes[np.argmax(np.abs(sizes - sizes[0]))])


def estimate_rms_pct(runs: RunCache) -> float:
    """Return the rms difference of estimate and displacement sensor over the staircase [% strain]."""
    run = runs.control_run
    counted = elapsed(run) > 0.0
    difference = (run["estimated_strain"] - required_quantity(run))[counted]
    return float(100.0 * np.sqrt(np.mean(difference**2)))


def outside_band_pct(runs: RunCache) -> float:
    """Return the largest distance of the staircase's trace from the band between the branches [% strain]."""
    run = runs.control_run
    heating, cooling = runs.main_loop().sensing_branches("strain")
    counted = elapsed(run) > 0.0
    return 100.0 * outside_band(run["wire_resistance_ohm"][counted], required_quantity(run)[counted], heating, cooling)
