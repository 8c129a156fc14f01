"""Observations of a wire and the prior as one vector of residuals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.identify._physical.candidates import CandidateParameters
from musclewire.identify._physical.observations import Observation, residuals_of


class PosteriorProblem:
    """Residuals of the observations and of the prior: their least squares are the maximum a posteriori."""

    def __init__(self, candidates: CandidateParameters, observations: Sequence[Observation]) -> None:
        """Take the unknown parameters and the observations."""
        self.candidates = candidates
        self.observations = tuple(observations)

    @property
    def low(self) -> FloatArray:
        """Lower bounds in coordinates, (n,)."""
        return self.candidates.low

    @property
    def high(self) -> FloatArray:
        """Upper bounds in coordinates, (n,)."""
        return self.candidates.high

    def refined(self) -> PosteriorProblem:
        """Return the same problem, simulated with the finest time step."""
        return PosteriorProblem(self.candidates, [item.refined() for item in self.observations])

    def observed_residuals(self, coordinates: FloatArray) -> FloatArray:
        """Return residuals of the observations alone, (m,)."""
        values = self.candidates.wire_values(coordinates)
        return np.concatenate([residuals_of(item, values) for item in self.observations])

    def residuals(self, coordinates: FloatArray) -> FloatArray:
        """Return residuals of the observations, then those of the prior: the coordinates themselves, (m + n,)."""
        return np.concatenate([self.observed_residuals(coordinates), coordinates])
