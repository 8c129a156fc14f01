"""What happens to many simulated wires at the end of a sample, compiled: reading, protection, reward, observation.

The lanes are in arrays of records, one record a lane.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.controllers import State, commanded, judged_reading
from musclewire.extras.interfaces._environments.episodes import MAX_RESISTANCE_FACTOR, PERCENT
from musclewire.random_numbers import normal_pair, philox, uniform

# Streams of random numbers of a lane: the last word of the counter.
TARGETS = 0
READINGS = 1
# From this noise on, in steps of the converter, the error of rounding is independent of the voltage to 0.3 % of a step:
# the mean of many readings is then one normal number with the variances of noise and rounding.
MIN_DITHER_STEPS = 0.5

RUN, TRIPPED = int(State.RUN), int(State.TRIPPED)

# What a lane's rig is, beyond the rules of its protection.
FACTS = np.dtype(
    [
        (name, np.float64)
        for name in (
            "sample_period_s", "leg_length_m", "amplifier_resolution_v", "acquisition_noise_v",
            "acquisition_step_v", "acquisition_readings", "displacement_noise_m",
        )
    ]
)  # fmt: skip
# What a lane remembers beyond its wire and its protection: the drive that is out, episode and sample by number, and
# whether the episode has ended.
MEMORY = np.dtype([("drive_voltage_v", np.float64), ("episode", np.int64), ("sample", np.int64), ("ended", np.int64)])
# How a sample ends for a lane: both readings of the converter and that of the displacement sensor, as a strain; the
# number of the event by which the protection has switched off, 0 for none; the reward; and whether the time of the
# episode has come to its end.
ENDS = np.dtype(
    [
        ("wire_voltage_v", np.float64),
        ("shunt_voltage_v", np.float64),
        ("strain", np.float64),
        ("event", np.int64),
        ("reward", np.float64),
        ("truncated", np.bool_),
    ]
)

# Arrays of these records, and one of them as compiled code sees it; mypy knows no fields of either.
Rows = NDArray[np.void]
Record = Any


@compiled
def draw_levels(seed: int, lane: int, episode: int, draws: FloatArray) -> None:
    """Write the random numbers of one episode's levels, each from 0 to 1, into ``draws``, (n_levels,)."""
    for level in range(draws.shape[0]):
        word, _, _, _ = philox(level, episode, lane, TARGETS, seed)
        draws[level] = uniform(word)


@compiled
def drive_lanes(
    facts: Rows, rules: Rows, protections: Rows, memory: Rows, actions: FloatArray, drive_v: FloatArray
) -> None:
    """Write the drive voltage that each lane allows, in the amplifier's steps, for actions from -1 to 1, (n_lanes,)."""
    for lane in range(actions.shape[0]):
        rule, kept = rules[lane], memory[lane]
        highest_v = rule["maximum_voltage_v"]
        part = 0.5 * (min(max(actions[lane], -1.0), 1.0) + 1.0)
        span_v = highest_v - rule["sense_voltage_v"]
        wanted_v = rule["sense_voltage_v"] if kept["ended"] else rule["sense_voltage_v"] + part * span_v
        step_v = facts[lane]["amplifier_resolution_v"]
        stepped_v = step_v * round(min(wanted_v, highest_v) / step_v)
        # The steps may have rounded it to above the maximum, which is not refused.
        allowed_v, state = commanded(protections, rules, lane, min(stepped_v, highest_v))
        kept["drive_voltage_v"] = stepped_v if state == RUN else allowed_v
        drive_v[lane] = kept["drive_voltage_v"]


@compiled
def converter_reading(fact: Record, voltage_v: float, normal: float, place: tuple[int, int, int, int]) -> float:
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
    fact: Record, rule: Record, kept: Record, lane: int, seed: int, means: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return the readings of wire voltage, shunt voltage and displacement for their true means over a sample."""
    words = philox(kept["sample"], kept["episode"], lane, READINGS, seed)
    wire, shunt = normal_pair(words[0], words[1])
    sensor, _ = normal_pair(words[2], words[3])
    place = (kept["sample"], kept["episode"], lane, seed)
    # The readings of one channel one by one have streams of their own: those of the shunt follow the wire's.
    other = (kept["sample"], kept["episode"], lane, seed ^ -1)
    wire_v, shunt_v = converter_reading(fact, means[0], wire, place), converter_reading(fact, means[1], shunt, other)
    return (
        min(max(wire_v, -rule["wire_range_v"]), rule["wire_range_v"]),
        min(max(shunt_v, -rule["shunt_range_v"]), rule["shunt_range_v"]),
        means[2] + fact["displacement_noise_m"] * sensor,
    )


@compiled
def read_lanes(
    facts: Rows, rules: Rows, protections: Rows, memory: Rows, seed: int, means: FloatArray, ends: Rows
) -> None:
    """Read all lanes from mean wire voltage, shunt voltage and displacement, (3, n_lanes), and judge the readings."""
    for lane in range(means.shape[1]):
        fact, kept, end = facts[lane], memory[lane], ends[lane]
        wire_v, shunt_v, displacement_m = read_lane(
            fact, rules[lane], kept, lane, seed, (means[0, lane], means[1, lane], means[2, lane])
        )
        end["wire_voltage_v"], end["shunt_voltage_v"] = wire_v, shunt_v
        end["strain"] = displacement_m / fact["leg_length_m"]
        drive_v, period_s = kept["drive_voltage_v"], fact["sample_period_s"]
        judged_reading(protections, rules, lane, drive_v, wire_v, shunt_v, drive_v, period_s)
        end["event"] = protections[lane]["event"] if protections[lane]["state"] == TRIPPED else 0


@compiled
def estimate_lanes(
    tick: Any,
    constants: FloatArray,
    states: FloatArray,
    time_s: FloatArray,
    drive_v: FloatArray,
    ends: Rows,
    answer: FloatArray,
    observed: FloatArray,
) -> int:
    """Write an estimator's strain of all driven lanes as last column; return a lane that failed, else -1."""
    given, failed = np.empty(4), -1
    for lane in range(drive_v.shape[0]):
        if ends[lane]["event"] != 0:
            continue
        given[0], given[1] = time_s[lane], drive_v[lane]
        given[2], given[3] = ends[lane]["wire_voltage_v"], ends[lane]["shunt_voltage_v"]
        tick(constants[lane], states[lane], given, answer)
        observed[lane, 5] = answer[0]
        if answer[4] != 0.0:
            failed = lane
    return failed


@compiled
def judge_lanes(
    rules: Rows,
    memory: Rows,
    targets: FloatArray,
    level_of_sample: NDArray[np.int64],
    ends: Rows,
    observed: FloatArray,
) -> None:
    """Reward and observe all lanes at the end of a sample; ``targets`` are their levels, (n_lanes, n_levels).

    ``level_of_sample`` is the level asked for in each sample from the first after the reset on, and after the last. A
    lane that had ended was at rest before this sample, which was the first of its episode.
    """
    last = level_of_sample.shape[0] - 1
    for lane in range(targets.shape[0]):
        rule, kept, end, seen = rules[lane], memory[lane], ends[lane], observed[lane]
        before = level_of_sample[max(kept["sample"] - 1, 0)]
        # The sample that has just ended is judged by the target that was asked for while it was taken.
        error = abs(targets[lane, before] - end["strain"])
        end["reward"] = 0.0 if kept["ended"] else -PERCENT * error
        tripped = end["event"] != 0
        if tripped:
            end["reward"] = -PERCENT * targets[lane].max() * (last - kept["sample"] + 1)
            kept["drive_voltage_v"] = 0.0
        else:
            wire_v, shunt_v = end["wire_voltage_v"], end["shunt_voltage_v"]
            resistance_ohm = wire_v / shunt_v * rule["shunt_resistance_ohm"]
            seen[0], seen[1] = wire_v, shunt_v
            seen[2] = min(max(resistance_ohm, 0.0), MAX_RESISTANCE_FACTOR * rule["resistance_high_ohm"])
        seen[3] = kept["drive_voltage_v"]
        seen[4] = targets[lane, level_of_sample[kept["sample"]]]
        end["truncated"] = not tripped and kept["sample"] >= last
        kept["ended"] = tripped or end["truncated"]
        kept["sample"] += 1
