"""Tasks: what a user asks of a loop, as targets over time in fractions of what his model senses.

Nothing of them is the wire's own: the same task is other strains on another wire. Where targets jump, the first second
after a jump is left out, as the paper does (Eq. 7); of what moves all the time nothing is, once the wire is warm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from musclewire import FloatArray, SensingModel, sampled_reference, staircase
from musclewire.controllers import Reference
from musclewire.experiment import staircase_within

PERIOD_S = 0.05
STREAM = 19
# Where targets lie, as parts of the model's largest: on the shipped rig 2.1 % of strain, 0.9 or 0.2 around it.
MIDDLE, WIDE, NARROW = 0.585, 0.25, 0.056
LOW, HIGH, TOP = 0.25, 0.9, 0.84
# A step from half cooled: time [s] at the top, for cooling, and at the target after it.
TOP_S, COOLING_S, AFTER_S = 6.0, 0.6, 5.0
HOLD_S = 600.0

Targets = Callable[[SensingModel, np.random.Generator], FloatArray]


class Task(NamedTuple):
    """What is asked.

    Parameters
    ----------
    targets
        The targets of a model at samples of 50 ms; None for the staircase within the model.
    held
        Whether its targets jump and hold.
    """

    targets: Targets | None
    held: bool

    def reference(self, model: SensingModel, seed: int) -> Reference:
        """Return the task as a reference in the quantity of a model; random ones are other ones for another seed."""
        if self.targets is None:
            return stairs_within(model)
        targets = self.targets(model, np.random.default_rng([STREAM, seed]))
        return sampled_reference(PERIOD_S * np.arange(targets.size), targets)


def stairs_within(model: SensingModel) -> Reference:
    """Return the paper's staircase; one of its form in a model that does not sense all of it."""
    paper = staircase_within(model)
    if model.quantity_min <= min(paper.levels) and max(paper.levels) <= model.quantity_max:
        return paper
    top = round(TOP * model.quantity_max, 4)
    return staircase(0.5 * top, top, 0.1 * top)


def times(duration_s: float) -> FloatArray:
    """Return the times of samples [s], (n_samples,)."""
    return np.asarray(PERIOD_S * np.arange(round(duration_s / PERIOD_S) + 1), dtype=np.float64)


def sine(period_s: float, amplitude: float) -> Task:
    """Return a sine around the middle, two periods and a minute at least."""
    time_s = times(max(60.0, 2.0 * period_s))
    wave = MIDDLE + amplitude * np.sin(2.0 * np.pi * time_s / period_s)
    return Task(lambda model, _: wave * model.quantity_max, held=False)


def triangle(period_s: float) -> Task:
    """Return two triangles around the middle."""
    time_s = times(2.0 * period_s)
    wave = MIDDLE + WIDE * np.interp((time_s / period_s) % 1.0, [0.0, 0.25, 0.75, 1.0], [0.0, 1.0, -1.0, 0.0])
    return Task(lambda model, _: wave * model.quantity_max, held=False)


def held_for(levels: FloatArray, hold_s: FloatArray) -> FloatArray:
    """Return levels, each held for a time [s]."""
    return np.repeat(levels, np.maximum(np.round(hold_s / PERIOD_S).astype(np.int64), 1))


def random_steps(model: SensingModel, random: np.random.Generator) -> FloatArray:
    """Return random levels held for 2 to 6 s."""
    return held_for(model.quantity_max * random.uniform(LOW, HIGH, 16), random.uniform(2.0, 6.0, 16))


def small_steps(model: SensingModel, random: np.random.Generator) -> FloatArray:
    """Return steps of 1 to 5 % to and fro, held for 4 s."""
    sizes = random.uniform(0.01, 0.05, 15) * random.choice([-1.0, 1.0], 15)
    return held_for(model.quantity_max * (MIDDLE + np.concatenate([[0.0], np.cumsum(sizes)])), np.full(16, 4.0))


def dragged(model: SensingModel, random: np.random.Generator) -> FloatArray:
    """Return a slider that is dragged in 0.3 to 1.5 s, ten times a second, and left for 1 to 4 s."""
    levels = random.uniform(LOW, HIGH, 18)
    parts: list[FloatArray] = [np.full(round(4.0 / PERIOD_S), levels[0])]
    for before, after in pairwise(levels):
        moved = np.linspace(0.0, 1.0, max(round(random.uniform(0.3, 1.5) / 0.1), 2))
        smooth = moved**3 * (10.0 - 15.0 * moved + 6.0 * moved**2)
        parts += [np.repeat(before + (after - before) * smooth, 2), np.full(round(random.uniform(20.0, 80.0)), after)]
    return np.asarray(model.quantity_max * np.concatenate(parts))


def half_cooled(model: SensingModel, _: np.random.Generator) -> FloatArray:
    """Return steps up that come while the wire still cools."""
    levels = np.tile([0.8, 0.3, 0.6], 5)
    return held_for(model.quantity_max * levels, np.tile([TOP_S, COOLING_S, AFTER_S], 5))


def near(end: float) -> Targets:
    """Return steps within a twentieth of what the model senses from its end near B (0) or near C (1)."""

    def targets(model: SensingModel, random: np.random.Generator) -> FloatArray:
        inside = random.uniform(0.0, 0.05, 10)
        place = inside if end == 0.0 else 1.0 - inside
        middle = np.where(np.arange(10) % 3 == 0, 0.5, place)
        span = model.quantity_max - model.quantity_min
        return held_for(model.quantity_min + middle * span, np.full(10, 6.0))

    return targets


TASKS: Mapping[str, Task] = {
    "staircase": Task(None, held=True),
    "random steps": Task(random_steps, held=True),
    "small steps": Task(small_steps, held=True),
    **{f"sine {period_s} s": sine(period_s, WIDE) for period_s in (3, 10, 30, 60)},
    **{f"small sine {period_s} s": sine(period_s, NARROW) for period_s in (3, 10, 30, 60)},
    "triangle 40 s": triangle(40.0),
    "slider": Task(dragged, held=True),
    "hold 10 min": Task(
        lambda model, _: held_for(np.array([MIDDLE * model.quantity_max]), np.array([HOLD_S])), held=True
    ),
    "half cooled": Task(half_cooled, held=True),
    "near B": Task(near(0.0), held=True),
    "near C": Task(near(1.0), held=True),
}


class Change(NamedTuple):
    """What is other than at the characterization, from some time after the beginning of a task on.

    Parameters
    ----------
    convection
        Factor on the loss to the air.
    draught
        Standard deviation of the convection in draughts of 3 s, relative.
    warmer_k
        By how much the air is warmer [K].
    load
        A constant force, as a fraction of the pretension.
    drive
        Factor on every voltage of the drive, from the beginning on; nothing measures that it is not what was asked for.
    most
        Largest voltage of the drive, as a fraction of the rig's, likewise.
    """

    convection: float = 1.0
    draught: float = 0.0
    warmer_k: float = 0.0
    load: float = 0.0
    drive: float = 1.0
    most: float = 1.0

    @property
    def of_the_air(self) -> bool:
        """Whether the air changes."""
        return (self.convection, self.draught, self.warmer_k) != (1.0, 0.0, 0.0)

    @property
    def of_the_supply(self) -> bool:
        """Whether the supply is weaker."""
        return (self.drive, self.most) != (1.0, 1.0)


STILL = "still air"
CHANGES: Mapping[str, Change] = {
    STILL: Change(),
    "draughts": Change(draught=0.25),
    "half the heat loss": Change(convection=0.5),
    "twice the heat loss": Change(convection=2.0),
    "air +10 K": Change(warmer_k=10.0),
    "air -10 K": Change(warmer_k=-10.0),
    "load +30 %": Change(load=0.3),
    "load -30 %": Change(load=-0.3),
    "supply 15 % low": Change(drive=0.85),
    "supply limited to 70 %": Change(most=0.7),
}
# What is asked in changed conditions.
IN_CHANGES = ("staircase", "sine 30 s", "random steps")
