"""The home move of a row that has one: after the drifts, before anything else changes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.errors import CallerError, RecordingError
from musclewire.experiment import home
from musclewire.extras.studies._robustness.plant import DisturbedPlant
from musclewire.extras.studies._robustness.settings import Condition
from musclewire.sensing import SensingModel

# Error of a thermometer in the air [K].
THERMOMETER_STD_K = 0.3
STREAM = 17


class HomedModel(NamedTuple):
    """The model after a home move.

    Parameters
    ----------
    model
        The model of today; the old one without a home move and after one that was refused.
    outcome
        "corrected", "not corrected", or "refused: " with the cause; "" without a home move.
    """

    model: SensingModel
    outcome: str


def homed(plant: DisturbedPlant, condition: Condition, model: SensingModel) -> HomedModel:
    """Return the model after the home move that a condition has, made on the rig as it is now.

    Parameters
    ----------
    plant
        The rig, open and cold; it is driven if the condition has a home move.
    condition
        The condition.
    model
        The user's model.

    Returns
    -------
    The model, and what became of the move.

    Raises
    ------
    RigError
        If the protection ended the move.
    """
    if not condition.home:
        return HomedModel(model, "")
    ambient_k = None
    if condition.thermometer:
        noise_k = THERMOMETER_STD_K * float(np.random.default_rng([STREAM, plant.seed]).standard_normal())
        ambient_k = plant.disturbance.ambient_k(0.0) + noise_k
    try:
        found = home(plant.rig, model, ambient_k=ambient_k)
    except (CallerError, RecordingError) as error:
        return HomedModel(model, f"refused: {' '.join(str(error).split())}")
    return HomedModel(found.model, "corrected" if found.home.corrected else "not corrected")
