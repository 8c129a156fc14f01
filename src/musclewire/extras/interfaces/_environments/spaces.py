"""What the environments observe, do and reward, once for the single and the vectorised one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import ProtectionLimits
from musclewire.errors import CallerError
from musclewire.extras.interfaces._environments.episodes import MAX_RESISTANCE_FACTOR, Episode
from musclewire.sensing import SensingModel, load_model

# The drive that is out is the commanded one in the amplifier's steps, which may round it up.
DRIVE_ROUNDING = 1.01
# An estimate at the end of a branch may be beyond it by this fraction of the range: it is a sum of powers.
ROUNDING = 1e-9
# Resistances at which the gap between the branches is asked for; a gap is a polynomial, and changes little between two.
N_RESISTANCES = 1001


def action_space() -> Any:
    """Return the space of actions: one number, -1 for the sense voltage and 1 for the maximum."""
    return gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float64)


def observation_space(limits: ProtectionLimits, episode: Episode, model: SensingModel | None) -> Any:
    """Return the space of observations, each within the range of its channel, of the protection or of the model."""
    low = [-limits.wire_range_v, -limits.shunt_range_v, 0.0, 0.0, episode.low]
    high = [
        limits.wire_range_v,
        limits.shunt_range_v,
        MAX_RESISTANCE_FACTOR * limits.resistance_high_ohm,
        DRIVE_ROUNDING * limits.maximum_voltage_v,
        episode.high,
    ]
    if model is not None:
        least, most = range_of_branches(model)
        low.append(least)
        high.append(most)
    return gymnasium.spaces.Box(np.array(low), np.array(high), dtype=np.float64)


def range_of_branches(model: SensingModel) -> tuple[float, float]:
    """Return the least and the largest strain that an estimate between the heating and the cooling branch can have.

    The model's own range is that of their mean, which a filter that knows the branch leaves by half of the gap.
    """
    resistance_ohm = np.linspace(*model.valid_resistance_ohm, N_RESISTANCES)
    half_gap = 0.5 * np.abs(model.strain_heating(resistance_ohm) - model.strain_cooling(resistance_ohm)).max()
    beyond = float(half_gap) + ROUNDING * (model.quantity_max - model.quantity_min)
    return model.quantity_min - beyond, model.quantity_max + beyond


def strain_model(given: SensingModel | str | Path | None) -> SensingModel | None:
    """Return the model of an environment's estimator. Raises CallerError for one that does not estimate strain."""
    if given is None:
        return None
    model = given if isinstance(given, SensingModel) else load_model(given)
    if model.quantity != "strain":
        raise CallerError(
            f"the environments follow targets of strain, and this model estimates {model.quantity}: fit one of strain"
        )
    return model


def no_options(options: dict[str, Any] | None) -> None:
    """Raise CallerError for options of a reset: none are known."""
    if options:
        raise CallerError(f"a reset has no option '{next(iter(options))}': give seed alone")


def checked_actions(action: Any, shape: tuple[int, ...]) -> FloatArray:
    """Return actions as numbers. Raises CallerError for another shape, or for one that is not a number."""
    numbers = np.asarray(action, dtype=np.float64)
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise CallerError(f"an action is an array of shape {shape} with finite numbers from -1 to 1, not {action!r}")
    return numbers
