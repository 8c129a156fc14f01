"""How fast a wire moves along its branches, from its slow loop and its circuit.

One heat balance, as the wire's model has it: tau dw/dt = P - w - lambda dS/dt. On a branch w is known over S, so
a constant P moves the wire from S_0 to S_1 in

    t = (tau (w_1 - w_0) + lambda (S_1 - S_0)) / e,   e the logarithmic mean of P - w over the way

which is exact where w is straight over S. Without latent heat this is the exponential cooling of a lumped capacity.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import FeedforwardSettings
from musclewire.errors import CallerError, RecordingError
from musclewire.sensing import SensingModel, wire_model_of
from musclewire.signals import RunFacts
from musclewire.wire import approached

LEVELS = 33
# No steady power is less [W]: tables and gains are of powers above 0.
MIN_POWER_W = 1e-6
# Power [W] that a wire must at least give to the air, or take, to move at all.
MIN_EXCESS_W = 1e-9


class SteadyLevels(NamedTuple):
    """Power [W] that holds each level on both branches, and the wire's resistance [ohm] there, (n_levels,) each."""

    heating_w: FloatArray
    cooling_w: FloatArray
    resistance_ohm: FloatArray


def steady_levels(model: SensingModel, levels: FloatArray) -> SteadyLevels:
    """Return what the model of a wire says of levels of its quantity."""
    wire = wire_model_of(model)
    heating_w, cooling_w, heating, cooling = (
        np.interp(levels / model.quantity_max, wire.places, column) for column in wire.tables.T
    )
    ohm = model.resistance_min_ohm + 0.5 * (heating + cooling) * (model.resistance_max_ohm - model.resistance_min_ohm)
    heating_w = np.maximum(heating_w, MIN_POWER_W)
    return SteadyLevels(heating_w, np.clip(cooling_w, MIN_POWER_W, heating_w), ohm)


class SpeedPlant(NamedTuple):
    """What limits the speed of a wire, by levels of the quantity: arrays of shape (n,)."""

    levels: FloatArray  # in the quantity's SI unit, rising
    heating_power_w: FloatArray  # holds each level on the heating branch
    cooling_power_w: FloatArray  # holds each level on the cooling branch
    lowest_power_w: FloatArray  # in the wire at the sense voltage, at each level
    highest_power_w: FloatArray  # in the wire at the maximum voltage, at each level
    time_constant_s: float  # heat capacity over heat loss to the air
    heat_per_unit: float  # heat [J] that the transformation takes for one unit of the quantity

    def with_loss(self, factor: float) -> Self:
        """Return the plant with the loss to the air times a factor."""
        return self._replace(
            heating_power_w=factor * self.heating_power_w,
            cooling_power_w=factor * self.cooling_power_w,
            time_constant_s=self.time_constant_s / factor,
        )

    def with_voltage(self, factor: float) -> Self:
        """Return the plant with the maximum voltage times a factor."""
        return self._replace(highest_power_w=factor**2 * self.highest_power_w)

    def with_warmer_cooling(self, power_w: float) -> Self:
        """Return the plant whose cooling branch is held by so much more power [W]."""
        return self._replace(cooling_power_w=self.cooling_power_w + power_w)

    def heating_times_s(self) -> FloatArray:
        """Return the time [s] from the first to each level at the maximum voltage, (n,)."""
        return self._times_s(self.highest_power_w - self.heating_power_w, self.heating_power_w)

    def cooling_times_s(self) -> FloatArray:
        """Return the time [s] from each level down to the first at the sense voltage, (n,)."""
        return self._times_s(self.cooling_power_w - self.lowest_power_w, self.cooling_power_w)

    def _times_s(self, excess_w: FloatArray, branch_w: FloatArray) -> FloatArray:
        """Return the time along a branch [s], summed from level to level."""
        heat_j = self.time_constant_s * np.diff(branch_w) + self.heat_per_unit * np.diff(self.levels)
        return np.concatenate([[0.0], np.cumsum(heat_j / mean_excess_w(np.maximum(excess_w, MIN_EXCESS_W)))])


def mean_excess_w(excess_w: FloatArray) -> FloatArray:
    """Return the logarithmic mean of power over loss [W] between each two levels, (n - 1,)."""
    ratio = np.log(excess_w[1:] / excess_w[:-1])
    even = np.abs(ratio) < 1e-9
    return np.asarray(np.where(even, excess_w[1:], np.diff(excess_w) / np.where(even, 1.0, ratio)))


def plant_of_gains(settings: FeedforwardSettings, facts: RunFacts) -> SpeedPlant:
    """Return the plant that a gains file states, in the circuit of a rig."""
    return in_circuit(
        settings.levels,
        np.array(settings.heating_power_w),
        np.array(settings.cooling_power_w),
        np.array(settings.resistance_ohm),
        (settings.thermal_time_constant_s, settings.heat_per_unit),
        facts,
    )


def plant_of_model(model: SensingModel, facts: RunFacts) -> SpeedPlant:
    """Return a model's plant in a rig's circuit. Raises RecordingError without the loop's power or the limits."""
    try:
        wire = wire_model_of(model)
    except CallerError:
        raise RecordingError("the model has no power through its loop: fit it again, from voltages") from None
    levels = np.linspace(model.quantity_min, model.quantity_max, LEVELS)
    heat = wire.time_constant_s.value, wire.heat_j_per_unit.value
    return in_circuit(levels, *steady_levels(model, levels), heat, facts)


def in_circuit(
    levels: FloatArray,
    heating_w: FloatArray,
    cooling_w: FloatArray,
    resistance_ohm: FloatArray,
    heat: tuple[float, float],
    facts: RunFacts,
) -> SpeedPlant:
    """Return a plant between the lowest and the highest power of a rig. Raises RecordingError for unstated limits."""
    shunt_ohm = facts.shunt_resistance_ohm
    per_v2 = resistance_ohm / (resistance_ohm + shunt_ohm) ** 2
    sense_v = facts.number("limit_sense_voltage_v", "sense voltage of the rig")
    maximum_v = facts.number("limit_maximum_voltage_v", "maximum voltage of the rig")
    return SpeedPlant(levels, heating_w, cooling_w, sense_v**2 * per_v2, maximum_v**2 * per_v2, *heat)


class TimedBranch(NamedTuple):
    """One branch for a walk along it: level and time along it [s], steady and driving power [W]."""

    levels: FloatArray
    times_s: FloatArray
    steady_w: FloatArray
    drive_w: FloatArray

    def power_w(self, level: float) -> float:
        """Return the steady power at a level."""
        return float(np.interp(level, self.levels, self.steady_w))

    def ends_at(self, level: float, *, rising: bool) -> bool:
        """Return whether the circuit holds the wire at a level and takes it no farther."""
        excess_w = float(np.interp(level, self.levels, self.drive_w)) - self.power_w(level)
        return (excess_w if rising else -excess_w) <= MIN_EXCESS_W

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


def fastest_course(plant: SpeedPlant, targets: FloatArray, period_s: float) -> FloatArray:
    """Return where the wire is at the end of each period, (n,), if each target holds for one period.

    It begins at the first target, on the heating branch; between the branches only its temperature changes. No
    controller does better without knowing targets beforehand.
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
        return level, float(approached(power_w, drive, period_s / time_constant_s))
    moves_s = period_s - waits_s
    reached = branch.after(level, moves_s if rising else -moves_s)
    level = min(target, reached) if rising else max(target, reached)
    return level, branch.power_w(level)
