"""The wires that a resistance leaves possible: the most likely one, and others drawn around it."""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import NumericsError
from musclewire.identify._physical.candidates import CandidateParameters
from musclewire.identify._physical.posterior import PosteriorProblem
from musclewire.identify._physical.search import FINAL_STEP, SEARCH_STEP, ParallelProblem, descend, jacobian, threads
from musclewire.identify._physical.uncertainty import covariance, excess_variance
from musclewire.identify._resistance_alone.observation import ResistanceAndMarks

# Factors on the observations' uncertainty, descent by descent; one start suffices, since the prior is a named wire.
SCALES = (30.0, 5.0, 1.0)
EVALUATIONS = 15


class PosteriorWires(NamedTuple):
    """The most likely wire in coordinates, (n,), their covariance, (n, n), and the misfit of the resistance.

    ``misfit`` is the root mean square of the residuals over their uncertainty, 1 for a wire that the model can be.
    """

    coordinates: FloatArray
    covariance: FloatArray
    misfit: float

    def draw(self, candidates: CandidateParameters, count: int, seed: int) -> FloatArray:
        """Return coordinates of wires drawn from the posterior, within the prior's bounds, (count, n)."""
        random = np.random.default_rng(seed)
        drawn = random.multivariate_normal(self.coordinates, self.covariance, size=count, method="cholesky")
        return np.clip(drawn, candidates.low, candidates.high)


def posterior_wires(
    candidates: CandidateParameters, observation: ResistanceAndMarks, start: FloatArray | None = None
) -> PosteriorWires:
    """Return the wires that an observation leaves possible, by least squares (Laplace).

    It starts at the prior's mean, or at ``start``, (n,), where an observation with less in it ended.
    Raises NumericsError if the named wire cannot be simulated on this bench and drive.
    """
    problem = PosteriorProblem(candidates, [observation])
    with threads(os.cpu_count()) as each:
        parallel = ParallelProblem(problem, each)
        best = np.zeros(len(candidates)) if start is None else start
        for scale in SCALES if start is None else SCALES[-1:]:
            cost, best = descend(parallel, best, scale, EVALUATIONS, SEARCH_STEP)
            if not np.isfinite(cost):
                raise NumericsError("the named wire cannot be simulated: check the recording's bench, drive and units")
        residuals = parallel.residuals(best)
        if residuals is None:
            raise NumericsError("the best wire cannot be simulated: report this with the recording")
        slope = jacobian(parallel, best, residuals, FINAL_STEP, central=True)
    unknowns = len(candidates)
    observed = residuals[:-unknowns]
    spread = covariance(slope[:-unknowns], excess_variance(observed, unknowns))
    return PosteriorWires(best, spread, float(np.sqrt(np.mean(observed**2))))
