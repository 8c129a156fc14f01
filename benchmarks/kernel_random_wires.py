"""Random wires on random loads, driven in jumps up to the largest drive: is every step solved, and how far is 10 ms?

Alloys are drawn uniformly between the limits of the priors of calibration; loads are springs, tables with a kink, walls
and guides that rub. The largest drive is that of the spool's file. In air that cools more than that spool's, a wire
stays colder; ``as_hot`` raises the drive there, so that it becomes as hot. Draws are repeated where they describe no
wire: an R-phase that spreads more than martensite (refused by the kernel), or martensite that orients less under load
than without (it would shorten when pulled, and wire and load would have more than one balance).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from kernel_courses import SAMPLE_S, SENSE_V, Array, Numbers, shipped

from musclewire.errors import CallerError
from musclewire.parameters import load_priors, load_wire
from musclewire.wire import (
    ConnectorLoad,
    WireConstants,
    advance,
    constants_of,
    fixed_steps,
    resting_state,
    spring_load,
    with_table,
)

SPOOLS = ("paper-100um", "paper-125um", "paper-200um")
REACH_M = 7e-3
COURSE_S = 12.0


class RandomWire(NamedTuple):
    """A wire, a drive in jumps (n_samples,), and what the load is."""

    constants: WireConstants
    drive_v: Array
    load: str


class Outcome(NamedTuple):
    """What a random wire showed: unsolved steps in all runs, and the largest distance of 10 ms from 1 ms [K]."""

    unsolved: int
    distance_k: float
    hottest_k: float
    stroke: float
    load: str


def random_load(random: np.random.Generator) -> tuple[str, ConnectorLoad]:
    """Return a load of one of four kinds, and its name."""
    stiffness = float(np.exp(random.uniform(math.log(10.0), math.log(20e3))))
    kind = str(random.choice(["spring", "kink", "wall", "rubbing"]))
    if kind == "spring":
        return kind, spring_load(stiffness)
    at_m = float(random.uniform(0.1e-3, 2e-3))
    hard = float(np.exp(random.uniform(math.log(1e4), math.log(1e7)))) if kind == "wall" else stiffness
    soft = min(stiffness, 1000.0)
    rubs_n = float(random.uniform(0.0, 0.3)) if kind == "rubbing" else 0.0
    return kind, with_table(
        soft,
        lambda x: hard * np.maximum(x - at_m, 0.0),
        lambda x: rubs_n * (1.0 + x / REACH_M),
        reach_m=REACH_M,
    )


def random_numbers(random: np.random.Generator, *, as_hot: bool) -> Numbers:
    """Return an alloy within the priors' limits, a spool and a bench with a guide that rubs."""
    alloy, _, bench = (dict(group) for group in shipped())
    spool = dict(load_wire(str(random.choice(SPOOLS))).values())
    groups = {"alloy": alloy, "wire": spool, "bench": bench}
    still_factor = spool["convection_factor"]
    for name, prior in load_priors("niti-wire").parameters.items():
        groups[prior.group][name] = float(random.uniform(prior.low, prior.high))
    if as_hot:
        spool["maximum_voltage_v"] *= math.sqrt(max(spool["convection_factor"] / still_factor, 1.0))
    section_m2 = bench["legs"] * 0.25 * math.pi * spool["diameter_m"] ** 2
    bench["pretension_n"] = float(random.uniform(20e6, 250e6)) * section_m2
    bench["guide_friction_n"] = float(random.choice([0.0, random.uniform(0.0, 0.3), random.uniform(0.3, 1.0)]))
    bench["guide_presliding_m"] = float(np.exp(random.uniform(math.log(1e-6), math.log(1e-4))))
    return alloy, spool, bench


def random_drive_v(random: np.random.Generator, largest_v: float) -> Array:
    """Return jumps between random levels, every third one to the largest drive and every third one to 0 or sensing."""
    levels, samples = [], []
    while sum(samples) * SAMPLE_S < COURSE_S:
        turn = len(levels) % 3
        levels.append((largest_v, random.choice([0.0, SENSE_V]), random.uniform(0.0, largest_v))[turn])
        samples.append(random.integers(4, 40))
    return np.repeat(levels, samples)[: round(COURSE_S / SAMPLE_S)].astype(np.float64)


def draw(random: np.random.Generator, *, as_hot: bool = False) -> tuple[RandomWire, int]:
    """Return a random wire and how many draws were refused before."""
    refused = 0
    while True:
        numbers = random_numbers(random, as_hot=as_hot)
        if numbers[0]["strain_saturated"] < numbers[0]["strain_at_no_stress"]:
            refused += 1
            continue
        name, load = random_load(random)
        drive_v = random_drive_v(random, numbers[1]["maximum_voltage_v"])
        try:
            return RandomWire(constants_of(*numbers, load=load), drive_v, name), refused
        except CallerError as error:
            if "spread" not in str(error):
                raise
            refused += 1


class Course(NamedTuple):
    """A wire along its drive: temperature [K] and contraction after each sample, and the steps that were not solved."""

    temperature_k: Array
    contraction: Array
    unsolved: int


def along(wire: RandomWire, step_s: float) -> Course:
    """Return a wire along its drive, sample by sample; a path would raise for an unsolved step."""
    state, stepping, shown = resting_state(wire.constants), fixed_steps(step_s), []
    for volts in wire.drive_v.tolist():
        state, _ = advance(state, wire.constants, volts, SAMPLE_S, stepping)
        shown.append((state.temperature_k, state.contraction))
    return Course(*np.array(shown).T, int(state.unsolved_steps))


def outcome(wire: RandomWire, steps_s: tuple[float, float] = (10e-3, 1e-3)) -> Outcome:
    """Return what a wire shows in steps of two lengths."""
    coarse, fine = (along(wire, step_s) for step_s in steps_s)
    return Outcome(
        coarse.unsolved + fine.unsolved,
        float(np.abs(coarse.temperature_k - fine.temperature_k).max()),
        float(fine.temperature_k.max()),
        float(np.ptp(fine.contraction)),
        wire.load,
    )


def outcomes(count: int, seed: int, *, as_hot: bool = False) -> tuple[list[Outcome], int]:
    """Return what so many random wires show, and how many draws were refused."""
    random = np.random.default_rng(seed)
    found, refused = [], 0
    for _ in range(count):
        wire, again = draw(random, as_hot=as_hot)
        refused += again
        found.append(outcome(wire))
    return found, refused
