"""Observations of a wire and the prior as one vector of residuals, and the uncertainty that follows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.extras.calibration._physical.candidates import CandidateParameters
from musclewire.extras.calibration._physical.observations import CURVE_STRETCHES, Observation, residuals_of


class PosteriorProblem:
    """Residuals of the observations and of the prior: their least squares are the maximum a posteriori."""

    def __init__(self, candidates: CandidateParameters, observations: Sequence[Observation]) -> None:
        """Take the unknown parameters and the observations."""
        self.candidates = candidates
        self.observations = tuple(observations)
        self.low, self.high = candidates.low, candidates.high

    def refined(self) -> PosteriorProblem:
        """Return the same problem, simulated with the finest time step."""
        return PosteriorProblem(self.candidates, [item.refined() for item in self.observations])

    def start(self, number: int, drawn: FloatArray) -> FloatArray:
        """Return the coordinates of a search's start, as :meth:`CandidateParameters.start` does."""
        return self.candidates.start(number, drawn)

    def residuals(self, coordinates: FloatArray) -> FloatArray:
        """Return residuals of the observations, then those of the prior: the coordinates themselves, (m + n,)."""
        values = self.candidates.wire_values(coordinates)
        return np.concatenate([*(residuals_of(item, values) for item in self.observations), coordinates])


# A parameter is identifiable if its interval is at most half its prior's; a wider one is mostly the prior's.
IDENTIFIABLE_FRACTION = 0.5
NEAR_BOUND = 0.02


@dataclass(frozen=True)
class ParameterEstimate:
    """One parameter: value and standard deviation in SI after and before the data, and the measurement for it."""

    name: str
    group: str
    unit: str
    value: float
    std: float
    prior_mean: float
    prior_std: float
    low: float
    high: float
    measure: str

    @property
    def identifiable(self) -> bool:
        """Whether the data narrowed the prior to half its width or less, and the value stands out from 0.

        A value that its own deviation exceeds may have either sign: nothing is known of it but that it is small. A
        number whose prior is 0, as a shift or an offset, need not stand out.
        """
        stands_out = self.prior_mean == 0.0 or abs(self.value) > self.std
        return stands_out and self.std <= IDENTIFIABLE_FRACTION * self.prior_std

    @property
    def at_bound(self) -> bool:
        """Whether the value is at a bound of the search, so that its interval means little."""
        margin = NEAR_BOUND * self.prior_std
        return self.value - self.low < margin or self.high - self.value < margin

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval, not truncated at the bounds."""
        return self.value - 1.96 * self.std, self.value + 1.96 * self.std


def excess_variance(residuals: FloatArray, unknowns: int) -> float:
    """Return the variance of normalised residuals, at least 1.

    ``residuals``, (m,), are those of the observations without the prior's. If the model cannot follow the data, or
    noise is correlated, the stated uncertainty is too small, and so would be every interval.
    """
    freedom = max(residuals.size - unknowns, 1)
    return max(1.0, float(residuals @ residuals) / freedom)


def covariance(jacobian: FloatArray, excess: float = 1.0) -> FloatArray:
    """Return the covariance of coordinates, (n, n), after data with this ``jacobian``, (m, n), and a unit prior.

    By Laplace's approximation the posterior is normal around the fit, with the curvature of the residuals.
    """
    information = jacobian.T @ jacobian / excess + np.eye(jacobian.shape[1])
    return np.asarray(np.linalg.inv(information))


def widened_covariance(
    spread: FloatArray,
    jacobian: FloatArray,
    residuals: FloatArray,
    coordinates: FloatArray,
    stretches: Sequence[int],
    ends: FloatArray,
) -> FloatArray:
    """Return a covariance with what Laplace's approximation leaves out: residuals that go together, and no minimum.

    A model that cannot follow the data errs alike at neighbouring points, which counts fewer of them than there are:
    the scatter of the gradient is summed over neighbours, up to a tenth of a channel apart and weighted less the
    farther (Newey and West 1987, doi 10.2307/1913610). Its channels then contradict each other, each of which counts as
    one more scattered measurement (Liang and Zeger 1986, doi 10.1093/biomet/73.1.13). And in a long valley a search
    ends before its minimum: the step that is left belongs to the deviation, as does how far apart its descents ended.
    No direction becomes more certain than it was.

    ``jacobian``, (m, n), and ``residuals``, (m,), are the observations', channel by channel of ``stretches``; ``ends``
    is where the best descents ended.
    """
    unknowns = coordinates.size
    inverse = np.linalg.inv(jacobian.T @ jacobian + np.eye(unknowns))
    undone = inverse @ (jacobian.T @ residuals + coordinates)
    gradients = np.split(jacobian * residuals[:, None], np.cumsum(stretches)[:-1])
    by_neighbours = np.eye(unknowns)
    for gradient in gradients:
        reach = len(gradient) // CURVE_STRETCHES
        for apart in range(min(reach + 1, len(gradient))):
            together = (1.0 - apart / (reach + 1)) * gradient[apart:].T @ gradient[: len(gradient) - apart]
            by_neighbours += together if apart == 0 else together + together.T
    found = widened(spread, inverse @ by_neighbours @ inverse)
    if len(gradients) > 1:
        sums = np.array([gradient.sum(axis=0) for gradient in gradients])
        by_channel = np.eye(unknowns) + len(gradients) / (len(gradients) - 1) * sums.T @ sums
        found = widened(found, inverse @ by_channel @ inverse)
    apart_by = ends - coordinates
    return np.asarray(found + np.outer(undone, undone) + apart_by.T @ apart_by / max(len(ends), 1))


def widened(spread: FloatArray, other: FloatArray) -> FloatArray:
    """Return a covariance, (n, n), widened in each direction in which another one is wider."""
    root = np.linalg.cholesky(spread)
    white = np.linalg.solve(root, np.linalg.solve(root, other).T)
    variances, directions = np.linalg.eigh(0.5 * (white + white.T))
    axes = root @ directions
    return np.asarray((axes * np.maximum(variances, 1.0)) @ axes.T)


def estimates(
    candidates: CandidateParameters, coordinates: FloatArray, deviation: FloatArray
) -> list[ParameterEstimate]:
    """Return every parameter with its standard deviation; ``deviation``, (n,), is in coordinates."""
    found = []
    for name, prior, number, std in zip(
        candidates.names, candidates.priors, candidates.numbers(coordinates), deviation, strict=True
    ):
        known = (prior.mean, prior.std, prior.low, prior.high, prior.measure)
        found.append(ParameterEstimate(name, prior.group, prior.unit, float(number), float(std * prior.std), *known))
    return found
