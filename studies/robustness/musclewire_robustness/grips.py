"""The held force of a grip under disturbance: trained as it is, then gripping while something is other than then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from musclewire import ElasticObject, MusclewireError, RigConfiguration, load_bench, load_wire, open_rig
from musclewire.extras.grip import (
    TARGET_N,
    GripperKnowledge,
    grip,
    object_of,
    train_gripper,
    with_object,
)
from musclewire_robustness.settings import GripCondition, settings

RIG = "gripper"
# Seed of the training; those of the grips follow the settings.
TRAINING_SEED = 1


@dataclass(frozen=True)
class GripRow:
    """Grips under one condition; errors in percent of the target.

    Parameters
    ----------
    condition
        Name of the condition.
    held_mean_pct, held_max_pct
        Mean and largest absolute error of the held force by the load cell [%]; None if no grip was held.
    estimate_mean_pct
        Mean absolute error of the estimated force against the load cell [%].
    held
        Number of grips that reached the target and held it.
    grips
        Number of grips.
    """

    condition: str
    held_mean_pct: float | None
    held_max_pct: float | None
    estimate_mean_pct: float | None
    held: int
    grips: int


def grip_rows() -> tuple[GripRow, ...]:
    """Return a row for each condition of grips, all with what the gripper has learned in one training."""
    known, knowledge = settings().grips, train_gripper(RIG, seed=TRAINING_SEED)
    return tuple(row_of(condition, knowledge, known.seeds) for condition in known.condition)


def row_of(condition: GripCondition, knowledge: GripperKnowledge, seeds: tuple[int, ...]) -> GripRow:
    """Return the row of a condition."""
    forces: list[tuple[float, float]] = []
    for seed in seeds:
        own = object_of(RIG)
        block = ElasticObject(own.stiffness_n_per_m * condition.object_factor, own.clearance_m)
        try:
            with open_rig(surrounded(with_object(RIG, block), condition), seed=seed, **changes(condition)) as rig:
                run = grip(rig, knowledge)
        except MusclewireError:
            continue  # it counts as not held
        if run.held and run.true_force_n is not None and run.estimated_force_n is not None:
            forces.append((run.true_force_n, run.estimated_force_n))
    if not forces:
        return GripRow(condition.name, None, None, None, 0, len(seeds))
    true, estimate = np.array(forces).T
    off = 100.0 * np.abs(true - TARGET_N) / TARGET_N
    estimated = 100.0 * float(np.abs(estimate - true).mean()) / TARGET_N
    return GripRow(condition.name, float(off.mean()), float(off.max()), estimated, len(forces), len(seeds))


def surrounded(configuration: RigConfiguration, condition: GripCondition) -> RigConfiguration:
    """Return a gripper in other air, if the condition has draughts."""
    if not condition.draughts:
        return configuration
    air = configuration.surroundings.model_copy(update={"draught": condition.draughts})
    return configuration.model_copy(update={"surroundings": air})


def changes(condition: GripCondition) -> dict[str, Any]:
    """Return the numbers of bench and wire that are other than at the training."""
    wire, bench = load_wire("finger-100um").values(), load_bench("finger").values()
    changed = {
        "ambient_temperature_k": bench["ambient_temperature_k"] + condition.ambient_k,
        "convection_factor": wire["convection_factor"] * condition.convection_factor,
        "resistivity_factor": wire["resistivity_factor"] * condition.resistance_factor,
        "temperature_shift_k": wire["temperature_shift_k"] + condition.transformation_shift_k,
        "acquisition_noise_v": bench["acquisition_noise_v"] * condition.noise_factor,
    }
    return {name: value for name, value in changed.items() if value != {**wire, **bench}[name]}
