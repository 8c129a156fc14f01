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


class Quantity(NamedTuple):
    """What a staircase is of: its name, the column of its estimate, and the paper's unit, so many of SI."""

    name: str
    estimate: str
    unit: str
    per_si: float


QUANTITIES: dict[Which, Quantity] = {
    "spring": Quantity("strain", "estimated_strain", "%", 100.0),
    "finger": Quantity("displacement", "estimated_displacement_m", "mm", 1e3),
}
# Digits to which a step is what it was set to.
DIGITS = 9


def run_of(runs: RunCache, of: Which) -> ControlRun:
    """Return the run of a staircase."""
    return runs.control_run if of == "spring" else runs.finger.control_run


def steps_of(runs: RunCache, of: Which) -> tuple[StepMetrics, ...]:
    """Return the errors of a staircase's steps."""
    return tuple(run_of(runs, of).metrics.steps)


def level(runs: RunCache, *, of: Which, index: int) -> float:
    """Return a level of the staircase that ran, in the paper's unit."""
    return QUANTITIES[of].per_si * steps_of(runs, of)[index].target


def step_size(runs: RunCache, *, of: Which) -> float:
    """Return the size of the staircase's steps, the one that differs most from the first, in the paper's unit."""
    sizes = np.abs(np.diff([step.target for step in steps_of(runs, of)]))
    return float(np.round(QUANTITIES[of].per_si * sizes[np.argmax(np.abs(sizes - sizes[0]))], DIGITS))


def hold_s(runs: RunCache, *, of: Which) -> float:
    """Return for how long a step is held [s]."""
    held: Staircase = runs.staircase if of == "spring" else staircase_of_fig18()
    return held.hold_s


def sample_period_s(runs: RunCache) -> float:
    """Return the period of the samples of Fig. 12 [s]."""
    return float(np.median(np.diff(runs.control_run["time_s"])))


def step_error_pct(runs: RunCache, *, of: Which, target: float, direction: str) -> float:
    """Return the MAE of one step after the approach [% of target]; ``target`` is in the paper's unit."""
    found = [
        step.mae_approached_pct
        for step in steps_of(runs, of)
        if step.direction == direction and abs(QUANTITIES[of].per_si * step.target - target) < 1e-6
    ]
    return determined(found[0], f"the error of the step to {target:g} {QUANTITIES[of].unit}")


def error_pct(runs: RunCache, *, of: Which, name: str) -> float:
    """Return an error of the whole staircase by its name among the metrics [% of target]."""
    which = "largest" if "_max_" in name else "mean"
    return determined(getattr(run_of(runs, of).metrics, name), f"the {which} error")


def largest_but_last_pct(runs: RunCache, *, of: Which) -> float:
    """Return the largest MAE after the approach of all steps but the last, the lowest on the way back [% of target]."""
    return largest_pct(steps_of(runs, of)[:-1])


def largest_beyond_pct(runs: RunCache, *, of: Which, beyond: float) -> float:
    """Return the largest MAE after the approach of steps to levels beyond one, in the paper's unit [% of target]."""
    scale = QUANTITIES[of].per_si
    return largest_pct(tuple(step for step in steps_of(runs, of) if scale * step.target > beyond + 1e-6))


def largest_pct(steps: tuple[StepMetrics, ...]) -> float:
    """Return the largest MAE after the approach of some steps [% of target]."""
    return max(determined(step.mae_approached_pct, "a step's error") for step in steps)


def first_error_pct(runs: RunCache, *, of: Which) -> float:
    """Return the MAE of the first step from the first target on [% of target]."""
    return determined(steps_of(runs, of)[0].mae_pct, "the error of the first step")


def from_first_target_pct(runs: RunCache, *, of: Which, which: Literal["largest", "mean"]) -> float:
    """Return the largest or the mean MAE from the first target on [% of target]."""
    return error_pct(runs, of=of, name={"largest": "mae_max_pct", "mean": "mae_mean_pct"}[which])


def estimate_rms(runs: RunCache, *, of: Which) -> float:
    """Return the rms difference of estimate and instrument over the staircase, in the paper's unit."""
    run, quantity = run_of(runs, of), QUANTITIES[of]
    counted = elapsed(run) > 0.0
    difference = (run[quantity.estimate] - required_quantity(run, quantity.name))[counted]
    return float(quantity.per_si * np.sqrt(np.mean(difference**2)))
