"""Conditions of a wire in segments, which may change at any time: air, load, and what happens to the wire itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.parameters import require_seed

# Draughts are limited to this many standard deviations.
STRONGEST = 3.0
STREAM = 7927


class Conditions(NamedTuple):
    """Conditions during a sample; the defaults are those of the bench.

    Parameters
    ----------
    ambient_k
        Temperature of the air and of the clamps [K]; None for that of the bench.
    convection_factor
        Loss to the air as a multiple of that in still air: one number, or one for each segment, (n_segments,).
    load_force_n
        Constant force that adds to the load [N], both legs together.
    stiffness_factor
        Stiffness of the spring as a multiple of the bench's; the force at the connector's zero stays.
    pretension_force_n
        Force that the foot of the spring adds by another setting [N].
    resistance_factor
        Resistance of the wire as a multiple of its own.
    transformation_shift_k
        Rise of all transformation temperatures [K].
    """

    ambient_k: float | None = None
    convection_factor: float | FloatArray = 1.0
    load_force_n: float = 0.0
    stiffness_factor: float = 1.0
    pretension_force_n: float = 0.0
    resistance_factor: float = 1.0
    transformation_shift_k: float = 0.0


OF_THE_BENCH = Conditions()

# Asked once before each sample, with its begin [s] on the rig's clock; times never fall.
ConditionsInTime = Callable[[float], Conditions]


def steady(conditions: Conditions = OF_THE_BENCH) -> ConditionsInTime:
    """Return conditions that stay as they are; by default those of the bench.

    Parameters
    ----------
    conditions
        The conditions.

    Returns
    -------
    A function of time that always returns them.
    """
    return lambda _: conditions


class LocalDraughts:
    """Draughts that differ along the wire, around other conditions: a random process, repeatable for one seed.

    Each segment has an Ornstein-Uhlenbeck process of the time constant ``lasting_s``, correlated by ``reach`` (0 to 1,
    at 1 all move together) with that of its neighbours, so that a draught meets a part of the wire. ``strength``, 0 to
    0.3, is the standard deviation of convection over that in still air.
    """

    def __init__(
        self,
        around: ConditionsInTime,
        n_segments: int,
        *,
        strength: float,
        lasting_s: float = 3.0,
        seed: int = 1,
        reach: float = 0.7,
    ) -> None:
        """Draw the first draughts."""
        if not (0.0 <= strength <= 0.3 and 0.0 < lasting_s < math.inf and 0.0 <= reach <= 1.0):
            raise CallerError(
                f"draughts of {strength:g} that last {lasting_s:g} s with a correlation of {reach:g} cannot be: "
                "strength 0 to 0.3, a time above 0 and a correlation of 0 to 1"
            )
        self._around, self._strength, self._lasting_s, self._reach = around, strength, lasting_s, reach
        self._random = np.random.default_rng([require_seed(seed), STREAM])
        self._draught = self._drawn(n_segments)
        self._time_s: float | None = None

    def _drawn(self, n_segments: int) -> FloatArray:
        """Return standard normal numbers of which neighbours are correlated."""
        own = self._random.standard_normal(n_segments)
        for number in range(1, n_segments):
            own[number] = self._reach * own[number - 1] + math.sqrt(1.0 - self._reach**2) * own[number]
        return own

    def __call__(self, time_s: float) -> Conditions:
        """Return the conditions at a time [s], with the draughts there in the convection of each segment."""
        around = self._around(time_s)
        since_s = 0.0 if self._time_s is None else max(time_s - self._time_s, 0.0)
        self._time_s = time_s
        # Exact for any step: an Ornstein-Uhlenbeck process sampled at the ends of steps.
        kept = math.exp(-since_s / self._lasting_s)
        self._draught = kept * self._draught + math.sqrt(1.0 - kept * kept) * self._drawn(len(self._draught))
        ratio = 1.0 + self._strength * np.clip(self._draught, -STRONGEST, STRONGEST)
        return around._replace(convection_factor=np.asarray(around.convection_factor) * ratio)
