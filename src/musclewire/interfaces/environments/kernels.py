"""What happens to many simulated wires at the end of a sample, compiled: reading, protection, reward, observation.

The lanes are in arrays of records, one record a lane. The arithmetic of the protection is that of
``controllers.protection.protect`` and held to it by a test.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.controllers.protection import ProtectionLimits
from musclewire.controllers.protection.protect import (
    CONDITION_EVENTS,
    SATURATED_FRACTION,
    SHORT_FRACTION,
    STUCK_FRACTION,
    TIME_ROUNDING_S,
    Conditions,
)
from musclewire.interfaces.environments.episodes import MAX_RESISTANCE_FACTOR, PERCENT
from musclewire.interfaces.environments.random_numbers import normal_pair, philox, uniform

__all__ = ["FACTS", "MEMORY", "NO_CURVE", "Curve", "LaneEnds", "LaneRun", "draw_levels", "drive_lanes", "end_sample"]

# Streams of random numbers of a lane: the last word of the counter.
TARGETS, READINGS = 0, 1
# From this noise on, in steps of the converter, the error of rounding is independent of the voltage to 0.3 % of a step:
# the mean of many readings is then one normal number with the variances of noise and rounding.
MIN_DITHER_STEPS = 0.5
CONDITIONS = len(Conditions._fields)
EVENT_NUMBERS = np.array([int(event) for event in CONDITION_EVENTS])
(SATURATED, SWAPPED, SHORT, CURRENT, POWER, STUCK, JUMP, OUTSIDE, _FROZEN, HOT) = range(CONDITIONS)

# What a lane's rig is; the protection's limits are among it under their own names.
FACTS = np.dtype(
    [(name, np.float64) for name in ProtectionLimits._fields]
    + [
        (name, np.float64)
        for name in (
            "sample_period_s", "leg_length_m", "amplifier_resolution_v", "acquisition_noise_v",
            "acquisition_step_v", "acquisition_readings", "displacement_noise_m",
        )
    ]
)  # fmt: skip
# What a lane remembers beyond its wire: the protection's memory, the drive that is out, episode and sample by number.
MEMORY = np.dtype(
    [
        ("temperature_k", np.float64),
        ("settled_ohm", np.float64),
        ("lasting_s", np.float64, CONDITIONS),
        ("drive_voltage_v", np.float64),
        ("episode", np.int64),
        ("sample", np.int64),
        ("ended", np.int64),
    ]
)

# Arrays of these records, and one of them as compiled code sees it; mypy knows no fields of either.
Rows = NDArray[np.void]
Record = Any


class Curve(NamedTuple):
    """The mean polynomial of a resistance curve as compiled code takes it; no coefficients: no estimate."""

    resistance_min_ohm: float
    per_ohm: float
    normalised_min: float
    normalised_max: float
    heating: FloatArray
    cooling: FloatArray


NO_CURVE = Curve(0.0, 0.0, 0.0, 0.0, np.empty(0), np.empty(0))


class LaneRun(NamedTuple):
    """What all lanes have in common: seed, length of approach and level in samples, how long conditions must last."""

    seed: int
    approach: int
    hold: int
    lasts_s: FloatArray
    curve: Curve


class LaneEnds(NamedTuple):
    """What a sample ends with, written in place: (n_lanes, n_observed), and (n_lanes,) for the others."""

    observed: FloatArray
    reward: FloatArray
    strain: FloatArray
    event: NDArray[np.int64]
    truncated: NDArray[np.bool_]


@compiled
def draw_levels(seed: int, lane: int, episode: int, draws: FloatArray) -> None:
    """Write the random numbers of one episode's levels, each from 0 to 1, into ``draws``, (n_levels,)."""
    for level in range(draws.shape[0]):
        word, _, _, _ = philox(level, episode, lane, TARGETS, seed)
        draws[level] = uniform(word)


@compiled
def drive_lanes(facts: Rows, memory: Rows, actions: FloatArray, drive_v: FloatArray) -> None:
    """Write the drive voltage of each lane, rounded to the amplifier's steps, for actions from -1 to 1, (n_lanes,)."""
    for lane in range(actions.shape[0]):
        fact, kept = facts[lane], memory[lane]
        part = 0.5 * (min(max(actions[lane], -1.0), 1.0) + 1.0)
        span_v = fact["maximum_voltage_v"] - fact["sense_voltage_v"]
        wanted_v = fact["sense_voltage_v"] if kept["ended"] else fact["sense_voltage_v"] + part * span_v
        step_v = fact["amplifier_resolution_v"]
        kept["drive_voltage_v"] = step_v * round(min(wanted_v, fact["maximum_voltage_v"]) / step_v)
        drive_v[lane] = kept["drive_voltage_v"]


@compiled
def converted(fact: Record, voltage_v: float, normal: float, place: tuple[int, int, int, int]) -> float:
    """Return a voltage as the converter reads it: the mean of many readings with noise, rounded to steps."""
    step_v, noise_v, readings = fact["acquisition_step_v"], fact["acquisition_noise_v"], fact["acquisition_readings"]
    if noise_v >= MIN_DITHER_STEPS * step_v:
        spread_v: float = math.sqrt((noise_v * noise_v + step_v * step_v / 12.0) / readings)
        return voltage_v + normal * spread_v
    sample, episode, lane, key = place
    total_v = 0.0
    for reading in range(int(readings)):
        first, second, _, _ = philox(sample, episode, lane, READINGS + 1 + reading, key)
        each, _ = normal_pair(first, second)
        total_v += step_v * round((voltage_v + noise_v * each) / step_v)
    mean_v: float = total_v / readings
    return mean_v


@compiled
def read_lane(
    fact: Record, kept: Record, lane: int, seed: int, means: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return the readings of wire voltage, shunt voltage and displacement for their true means over a sample."""
    words = philox(kept["sample"], kept["episode"], lane, READINGS, seed)
    wire, shunt = normal_pair(words[0], words[1])
    sensor, _ = normal_pair(words[2], words[3])
    place = (kept["sample"], kept["episode"], lane, seed)
    # The readings of one channel one by one have streams of their own: those of the shunt follow the wire's.
    other = (kept["sample"], kept["episode"], lane, seed ^ -1)
    wire_v, shunt_v = converted(fact, means[0], wire, place), converted(fact, means[1], shunt, other)
    return (
        min(max(wire_v, -fact["wire_range_v"]), fact["wire_range_v"]),
        min(max(shunt_v, -fact["shunt_range_v"]), fact["shunt_range_v"]),
        means[2] + fact["displacement_noise_m"] * sensor,
    )


@compiled
def protect_lane(fact: Record, kept: Record, lasts_s: FloatArray, wire_v: float, shunt_v: float) -> int:
    """Return the number of the event by which a reading trips the protection, 0 for none.

    A simulated circuit without faults always carries the sense current, and its noisy channels never freeze: the
    conditions for missing readings and frozen channels cannot occur.
    """
    dt_s, drive_v = fact["sample_period_s"], kept["drive_voltage_v"]
    current_a = shunt_v / fact["shunt_resistance_ohm"]
    resistance = wire_v / shunt_v * fact["shunt_resistance_ohm"]
    low, high, settled = fact["resistance_low_ohm"], fact["resistance_high_ohm"], kept["settled_ohm"]
    outside = not low <= resistance <= high
    jumped = not outside and settled > 0.0 and abs(resistance - settled) > fact["jump_share"] * settled
    if not (outside or jumped):
        kept["settled_ohm"] = resistance
    rate = fact["heat_loss_w_per_k"] / fact["heat_capacity_j_per_k"] * dt_s
    rise = dt_s * wire_v * current_a / fact["heat_capacity_j_per_k"]
    ambient = fact["ambient_temperature_k"]
    kept["temperature_k"] = ambient + (kept["temperature_k"] - ambient + rise) / (1.0 + rate)
    fits = low <= shunt_v / wire_v * fact["shunt_resistance_ohm"] <= high
    end = SATURATED_FRACTION
    seen = np.zeros(CONDITIONS, np.bool_)
    seen[SATURATED] = abs(wire_v) >= end * fact["wire_range_v"] or abs(shunt_v) >= end * fact["shunt_range_v"]
    seen[SWAPPED] = resistance < 0.0 or (resistance < low and fits)
    seen[SHORT] = resistance < SHORT_FRACTION * low
    seen[CURRENT] = abs(current_a) > fact["maximum_current_a"]
    seen[POWER] = wire_v * current_a > fact["maximum_power_w"]
    seen[STUCK] = wire_v + shunt_v > drive_v + STUCK_FRACTION * fact["maximum_voltage_v"]
    seen[JUMP], seen[OUTSIDE] = jumped, outside
    seen[HOT] = kept["temperature_k"] > fact["maximum_temperature_k"]
    tripped = 0
    for place in range(CONDITIONS):
        kept["lasting_s"][place] = kept["lasting_s"][place] + dt_s if seen[place] else 0.0
        if tripped == 0 and seen[place] and kept["lasting_s"][place] > lasts_s[place] - TIME_ROUNDING_S:
            tripped = EVENT_NUMBERS[place]
    return tripped


@compiled
def estimate_of(curve: Curve, resistance_ohm: float) -> float:
    """Return the mean of both branches at a resistance (Eqs. 3 to 5), as ``ResistanceCurve.estimate`` does."""
    fraction = (resistance_ohm - curve.resistance_min_ohm) * curve.per_ohm
    inside = min(max(fraction, curve.normalised_min), curve.normalised_max)
    heating = cooling = 0.0
    for power in range(curve.heating.shape[0] - 1, -1, -1):
        heating = heating * inside + curve.heating[power]
        cooling = cooling * inside + curve.cooling[power]
    return (heating + cooling) / 2.0


@compiled
def level_at(run: LaneRun, levels: int, sample: int) -> int:
    """Return the number of the level that is asked for in a sample, counted from the first after the reset."""
    return min(max((sample - run.approach) // run.hold, 0), levels - 1)


@compiled
def end_sample(facts: Rows, memory: Rows, targets: FloatArray, run: LaneRun, means: FloatArray, ends: LaneEnds) -> None:
    """Read, protect, judge and observe all lanes at the end of a sample.

    ``means`` are wire voltage, shunt voltage and displacement, (3, n_lanes); ``targets`` the levels, (n_lanes,
    n_levels). A lane that had ended was at rest before this sample, which was the first of its episode.
    """
    levels = targets.shape[1]
    last = run.approach + levels * run.hold
    for lane in range(targets.shape[0]):
        fact, kept, seen = facts[lane], memory[lane], ends.observed[lane]
        wire_v, shunt_v, displacement_m = read_lane(
            fact, kept, lane, run.seed, (means[0, lane], means[1, lane], means[2, lane])
        )
        strain = displacement_m / fact["leg_length_m"]
        event = protect_lane(fact, kept, run.lasts_s, wire_v, shunt_v)
        first = kept["ended"] != 0
        # The sample that has just ended is judged by the target that was asked for while it was taken.
        error = abs(targets[lane, level_at(run, levels, kept["sample"] - 1)] - strain)
        reward = 0.0 if first else -PERCENT * error
        if event:
            highest = targets[lane].max()
            reward = -PERCENT * highest * (last - kept["sample"] + 1)
            kept["drive_voltage_v"] = 0.0
        else:
            resistance = wire_v / shunt_v * fact["shunt_resistance_ohm"]
            seen[0], seen[1] = wire_v, shunt_v
            seen[2] = min(max(resistance, 0.0), MAX_RESISTANCE_FACTOR * fact["resistance_high_ohm"])
            if run.curve.heating.shape[0]:
                seen[5] = estimate_of(run.curve, resistance)
        seen[3] = kept["drive_voltage_v"]
        seen[4] = targets[lane, level_at(run, levels, kept["sample"])]
        ends.reward[lane], ends.strain[lane], ends.event[lane] = reward, strain, event
        ends.truncated[lane] = event == 0 and kept["sample"] >= last
        kept["ended"] = event != 0 or ends.truncated[lane]
        kept["sample"] += 1
