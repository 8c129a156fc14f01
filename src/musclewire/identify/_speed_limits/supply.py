"""Which step of a staircase comes late from cold as the supply is too weak, by how much, and what voltage suffices.

From cold the maximum voltage first warms the wire to its lowest level, w from the sense voltage's to w_h there, with
the heat of segment A to B, then takes it along the heating branch. What a controller, an estimate and colder air add is
not in it, so the errors are the least that there will be.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import Staircase
from musclewire.identify._speed_limits.plant import SpeedPlant, fastest_course, mean_excess_w
from musclewire.sensing import SHOWN_AS

# A step is named whose error by the supply alone is above this part of its target [%]: near the paper's largest.
LATE_PCT = 2.5
# Eq. 7 counts a step from one second after its start on.
SETTLE_S = 1.0


class WeakSupply(NamedTuple):
    """The step that the supply makes latest."""

    step: int  # its number, from 1
    start_s: float
    target: float  # in the quantity's SI unit
    error_pct: float  # the least error (Eq. 7) of this step by the supply alone, of the target
    maximum_voltage_v: float  # of the rig
    # Least with which no step has more than 2.5 %; None if none up to 16 times as much has.
    sufficient_voltage_v: float | None

    def text(self, quantity: str) -> str:
        """Return the warning, in a sentence."""
        factor, unit = SHOWN_AS[quantity]
        cure = "a later or slower first step"
        if self.sufficient_voltage_v is not None:
            cure = f"a maximum voltage of {self.sufficient_voltage_v:.3g} V, of which at most {LATE_PCT:g} % is left"
        return (
            f"the supply is too weak for step {self.step} (to {factor * self.target:.3g} {unit}, {self.start_s:g} s): "
            f"at {self.maximum_voltage_v:.3g} V the wire comes late from cold, an error of at least "
            f"{self.error_pct:.2g} % of its target. What would help: {cure}"
        )


def warming_s(plant: SpeedPlant, dead_time_s: float) -> float:
    """Return the time [s] in which a cold wire comes to its lowest level at the maximum voltage; infinite if never."""
    cold_w, lowest_w, drive_w = plant.lowest_power_w[0], plant.heating_power_w[0], plant.highest_power_w[0]
    if drive_w <= lowest_w:
        return math.inf
    heat_j = plant.time_constant_s * (lowest_w - cold_w) + plant.heat_per_unit * plant.levels[0]
    return dead_time_s + float(heat_j / mean_excess_w(np.array([drive_w - cold_w, drive_w - lowest_w]))[0])


def min_errors_pct(plant: SpeedPlant, steps: Staircase, sample_period_s: float, dead_time_s: float) -> FloatArray:
    """Return the least error (Eq. 7) of each step below its target by the supply alone, from cold [%], (n_steps,)."""
    times_s = sample_period_s * np.arange(1, round(steps.duration_s / sample_period_s) + 1)
    targets = steps.targets_at(times_s - sample_period_s)
    warms = int(min(math.ceil(min(warming_s(plant, dead_time_s), steps.duration_s) / sample_period_s), len(targets)))
    on_branch = fastest_course(plant, np.concatenate([plant.levels[:1], targets[warms:]]), sample_period_s)[1:]
    below = np.maximum(targets - np.concatenate([np.zeros(warms), on_branch]), 0.0)
    counted = [
        (times_s > step.start_s + min(SETTLE_S, 0.5 * steps.hold_s)) & (times_s <= step.stop_s) for step in steps.steps
    ]
    return np.array(
        [100.0 * float(below[rows].mean()) / step.target for rows, step in zip(counted, steps.steps, strict=True)]
    )
