"""The closest that a wire can follow a target: full heat as long as it is below, the sense voltage as long as above."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.identify._speed_limits.plant import SpeedPlant


class TimedBranch(NamedTuple):
    """One branch for a walk along it: level and time along it [s], steady and driving power [W]."""

    levels: FloatArray
    times_s: FloatArray
    steady_w: FloatArray
    drive_w: FloatArray

    def power_w(self, level: float) -> float:
        """Return the steady power at a level."""
        return float(np.interp(level, self.levels, self.steady_w))

    def after(self, level: float, time_s: float) -> float:
        """Return the level reached from another one in a time, negative for the way down."""
        return float(np.interp(np.interp(level, self.levels, self.times_s) + time_s, self.times_s, self.levels))

    def time_to(self, power_w: float, level: float, time_constant_s: float) -> float:
        """Return the time [s] in which a wire that stands still comes to this branch; infinite if it never does."""
        drive = float(np.interp(level, self.levels, self.drive_w))
        left, there = power_w - drive, self.power_w(level) - drive
        if left * there <= 0.0 or abs(left) <= abs(there):
            return 0.0 if left * there > 0.0 else math.inf
        return time_constant_s * math.log(left / there)


def branches_of(plant: SpeedPlant) -> tuple[TimedBranch, TimedBranch]:
    """Return heating and cooling branch of a plant, driven as far as its circuit goes."""
    return (
        TimedBranch(plant.levels, plant.heating_times_s(), plant.heating_power_w, plant.highest_power_w),
        TimedBranch(plant.levels, plant.cooling_times_s(), plant.cooling_power_w, plant.lowest_power_w),
    )


def followed(plant: SpeedPlant, targets: FloatArray, period_s: float) -> FloatArray:
    """Return where the wire is at the end of each period, (n,), if each target holds for one period.

    It begins at the first target, on the heating branch. Between the branches it stands still and only its temperature
    changes. No controller does better without knowing targets beforehand.
    """
    heating, cooling = branches_of(plant)
    level = float(np.clip(targets[0], plant.levels[0], plant.levels[-1]))
    power, found = heating.power_w(level), np.empty(len(targets))
    for index, target in enumerate(np.clip(targets, plant.levels[0], plant.levels[-1]).tolist()):
        if target != level:
            branch = heating if target > level else cooling
            level, power = towards(branch, level, power, (target, period_s, plant.time_constant_s))
        found[index] = level
    return found


def towards(branch: TimedBranch, level: float, power_w: float, way: tuple[float, float, float]) -> tuple[float, float]:
    """Return level and steady power after a period on the way to a target: target, period [s], time constant [s]."""
    target, period_s, time_constant_s = way
    rising = target > level
    waits_s = branch.time_to(power_w, level, time_constant_s)
    if waits_s >= period_s:
        drive = float(np.interp(level, branch.levels, branch.drive_w))
        return level, drive + (power_w - drive) * math.exp(-period_s / time_constant_s)
    moves_s = period_s - waits_s
    reached = branch.after(level, moves_s if rising else -moves_s)
    level = min(target, reached) if rising else max(target, reached)
    return level, branch.power_w(level)
