"""The air around a simulated wire: swings of its temperature, and draughts that change convection."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from musclewire.signals import measured_in

# Draughts are limited to this many standard deviations, so that convection never becomes negative.
STRONGEST = 3.0
STREAM = 7919
# The convection table is computed for the bench's own air temperature; further away it would not be accurate.
MAX_SWING_K = 20.0


Seconds = Annotated[float, measured_in("s"), Field(gt=0.0, allow_inf_nan=False)]
Kelvins = Annotated[float, measured_in("K", difference=True), Field(ge=0.0, le=MAX_SWING_K, allow_inf_nan=False)]


class Surroundings(BaseModel):
    """The table ``[surroundings]`` of a rig file: by default still air at the bench's temperature.

    Swing and draughts repeat for one seed and leave the instruments' noise as it is.

    Parameters
    ----------
    ambient_swing
        Amplitude of the swing of the air's temperature [K], at most 20 K.
    ambient_period
        Period of the swing [s], which begins at a random phase.
    draught
        Standard deviation of convection, as a fraction of that of still air, at most 0.25.
    draught_time
        Correlation time of the draughts [s].
    convection
        Convection on the average, as a fraction of that of still air: less in a sleeve or in foam, of which the
        protection of the simulated rig knows as little as that of a real one.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    ambient_swing: Kelvins = 0.0
    ambient_period: Seconds = 600.0
    draught: float = Field(default=0.0, ge=0.0, le=0.25, allow_inf_nan=False)
    draught_time: Seconds = 3.0
    convection: float = Field(default=1.0, ge=0.1, le=1.0, allow_inf_nan=False)

    @property
    def still(self) -> bool:
        """Whether temperature and convection are those of still air."""
        return self.ambient_swing == 0.0 and self.draught == 0.0 and self.convection == 1.0


class AirState(NamedTuple):
    """The air at one time: its temperature above the bench's [K], and the ratio of convection to that in still air."""

    warmer_k: float
    convection_ratio: float


class AirModel:
    """The air through time, repeatable for one seed: a slow sine, and draughts as a first-order random process."""

    def __init__(self, surroundings: Surroundings, seed: int) -> None:
        """Draw the initial phase of the temperature's swing and the first draught."""
        self._of = surroundings
        # A random stream of its own: the air does not change the noise of the instruments.
        self._random = np.random.default_rng([seed, STREAM])
        self._phase = float(self._random.uniform(0.0, 2.0 * math.pi))
        self._draught = float(self._random.standard_normal())

    @property
    def loss(self) -> float:
        """Convection on the average, as a fraction of that of still air."""
        return self._of.convection

    def after(self, time_s: float, dt_s: float) -> AirState:
        """Return the air ``dt_s`` after the last call, at a time on the rig's clock."""
        # Exact for any step: an Ornstein-Uhlenbeck process sampled at the ends of steps.
        kept = math.exp(-dt_s / self._of.draught_time)
        self._draught = kept * self._draught + math.sqrt(1.0 - kept * kept) * float(self._random.standard_normal())
        strength = min(max(self._draught, -STRONGEST), STRONGEST)
        swing = math.sin(2.0 * math.pi * time_s / self._of.ambient_period + self._phase)
        return AirState(
            warmer_k=self._of.ambient_swing * swing,
            convection_ratio=self._of.convection * (1.0 + self._of.draught * strength),
        )
