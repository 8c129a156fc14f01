"""The two staircases: of strain on the spring (Table 2, Fig. 11), of the endpoint on the finger (Table 3, Fig. 18)."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from musclewire.controllers import Staircase
from musclewire.experiment import ControlRun, StepMetrics, determined, elapsed
from musclewire.extras.paper._reproduce.finger_runs import staircase_of_fig18
from musclewire.extras.paper._reproduce.runs import RunCache
from musclewire.identify import required_quantity

Which = Literal["spring", "finger"]


class StaircaseQuantity(NamedTuple):
    """What a staircase is of: its name, the column of its estimate, and the paper's unit, so many of SI."""

    name: str
    estimate: str
    unit: str
    per_si: float


QUANTITIES: dict[Which, StaircaseQuantity] = {
    "spring": StaircaseQuantity("strain", "estimated_strain", "%", 100.0),
    "finger": StaircaseQuantity("displacement", "estimated_displacement_m", "mm", 1e3),
}
# Digits to which a step is what it was set to.
DIGITS = 9


def run_of(runs: RunCache, staircase: Which) -> ControlRun:
    """Return the run of a staircase."""
    return runs.control_run if staircase == "spring" else runs.finger.control_run


def steps_of(runs: RunCache, staircase: Which) -> tuple[StepMetrics, ...]:
    """Return the errors of a staircase's steps."""
    return tuple(run_of(runs, staircase).metrics.steps)


def level(runs: RunCache, *, staircase: Which, index: int) -> float:
    """Return a level of the staircase that ran, in the paper's unit."""
    return QUANTITIES[staircase].per_si * steps_of(runs, staircase)[index].target


def step_size(runs: RunCache, *, staircase: Which) -> float:
    """Return the size of the staircase's steps, the one that differs most from the first, in the paper's unit."""
    sizes = np.abs(np.diff([step.target for step in steps_of(runs, staircase)]))
    return float(np.round(QUANTITIES[staircase].per_si * sizes[np.argmax(np.abs(sizes - sizes[0]))], DIGITS))


def hold_s(runs: RunCache, *, staircase: Which) -> float:
    """Return for how long a step is held [s]."""
    held: Staircase = runs.staircase if staircase == "spring" else staircase_of_fig18()
    return held.hold_s


def sample_period_s(runs: RunCache) -> float:
    """Return the period of the samples of Fig. 12 [s]."""
    return float(np.median(np.diff(runs.control_run["time_s"])))


def step_error_pct(runs: RunCache, *, staircase: Which, target: float, direction: str) -> float:
    """Return the MAE of one step after the approach [% of target]; ``target`` is in the paper's unit."""
    found = [
        step.mae_approached_pct
        for step in steps_of(runs, staircase)
        if step.direction == direction and abs(QUANTITIES[staircase].per_si * step.target - target) < 1e-6
    ]
    return determined(found[0], f"the error of the step to {target:g} {QUANTITIES[staircase].unit}")


def error_pct(runs: RunCache, *, staircase: Which, name: str) -> float:
    """Return an error of the whole staircase by its name among the metrics [% of target]."""
    which = "largest" if "_max_" in name else "mean"
    return determined(getattr(run_of(runs, staircase).metrics, name), f"the {which} error")


def largest_but_last_pct(runs: RunCache, *, staircase: Which) -> float:
    """Return the largest MAE after the approach of all steps but the last, the lowest on the way back [% of target]."""
    return largest_pct(steps_of(runs, staircase)[:-1])


def last_less_others_pct(runs: RunCache, *, staircase: Which) -> float:
    """Return by how much the MAE of the last step, the lowest on the way back, is above all others' [% of target]."""
    steps = steps_of(runs, staircase)
    return largest_pct(steps[-1:]) - largest_pct(steps[:-1])


def largest_beyond_pct(runs: RunCache, *, staircase: Which, beyond: float) -> float:
    """Return the largest MAE after the approach of steps to levels beyond one, in the paper's unit [% of target]."""
    scale = QUANTITIES[staircase].per_si
    return largest_pct(tuple(step for step in steps_of(runs, staircase) if scale * step.target > beyond + 1e-6))


def largest_pct(steps: tuple[StepMetrics, ...]) -> float:
    """Return the largest MAE after the approach of some steps [% of target]."""
    return max(determined(step.mae_approached_pct, "a step's error") for step in steps)


def first_error_pct(runs: RunCache, *, staircase: Which) -> float:
    """Return the MAE of the first step from the first target on [% of target]."""
    return determined(steps_of(runs, staircase)[0].mae_pct, "the error of the first step")


def from_first_target_pct(runs: RunCache, *, staircase: Which, which: Literal["largest", "mean"]) -> float:
    """Return the largest or the mean MAE from the first target on [% of target]."""
    return error_pct(runs, staircase=staircase, name={"largest": "mae_max_pct", "mean": "mae_mean_pct"}[which])


def estimate_rms(runs: RunCache, *, staircase: Which) -> float:
    """Return the rms difference of estimate and instrument over the staircase, in the paper's unit."""
    run, quantity = run_of(runs, staircase), QUANTITIES[staircase]
    counted = elapsed(run) > 0.0
    difference = (run[quantity.estimate] - required_quantity(run, quantity.name))[counted]
    return float(quantity.per_si * np.sqrt(np.mean(difference**2)))
