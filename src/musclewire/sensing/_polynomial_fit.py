"""Fit the polynomials of a resistance curve to points (Lan and Fan 2010, Eq. 4), and choose their order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError
from musclewire.sensing._branch_equations import normalised_resistance
from musclewire.sensing._branches import Branch

# Beyond this order power coefficients lose their digits.
MAX_ORDER = 15
# Equal slices of normalised resistance, to whose means a branch of more points is averaged.
SLICES = 200
# A point at the edge of a gap in the data has at most the weight of this many ordinary ones.
MAX_WEIGHT = 4.0
FOLDS = 5
BLOCKS_PER_FOLD = 6


@dataclass(frozen=True, eq=False)
class FitPoints:
    """The points of a fit: columns of shape (n,), rising in normalised resistance."""

    normalised_resistance: FloatArray
    quantity: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class PolynomialFit:
    """Ascending power coefficients in normalised resistance, with their uncertainty from the residuals."""

    coefficients: tuple[float, ...]
    standard_errors: tuple[float, ...]  # zeros mean unknown, of a curve through all points
    # (order + 1, order + 1), widened by (1 + r) / (1 - r), r the correlation of neighbouring residuals.
    covariance: FloatArray
    spare_points: int


def fit_points(curve: Branch, resistance_min_ohm: float, resistance_max_ohm: float) -> FitPoints:
    """Prepare a single-valued branch for fitting, so that uneven sampling in time has no influence on the fit.

    More than 200 points are averaged in as many slices of normalised resistance. A point weighs as much as the interval
    around it, at most four times the median: the fit minimises the mean square error over resistance, not over time.
    """
    fraction = normalised_resistance(curve.resistance_ohm, resistance_min_ohm, resistance_max_ohm)
    quantity = curve.quantity
    if fraction.size > SLICES:
        slices = np.floor((fraction - fraction[0]) / (fraction[-1] - fraction[0]) * SLICES).clip(max=SLICES - 1)
        starts = np.flatnonzero(np.diff(slices, prepend=-1))
        counts = np.diff(np.append(starts, fraction.size))
        fraction = np.add.reduceat(fraction, starts) / counts
        quantity = np.add.reduceat(quantity, starts) / counts
    step = np.diff(fraction)
    interval = (np.append(step[:1], step) + np.append(step, step[-1:])) / 2
    interval = np.minimum(interval, MAX_WEIGHT * np.median(interval))
    return FitPoints(fraction, quantity, interval / interval.mean())


def fit_polynomial(points: FitPoints, order: int, name: str = "this") -> PolynomialFit:
    """Fit a polynomial of ``order`` by least squares (Lan and Fan 2010, Eq. 4, there of order 6).

    Solved in Chebyshev polynomials, where it is well conditioned, and returned as power coefficients. Raises
    RecordingError for too few points for the order, CallerError for an order outside 1 to 15.
    """
    check_order(order)
    count = points.normalised_resistance.size
    if count <= order:
        raise RecordingError(
            f"order {order} needs at least {order + 1} points and the {name} branch has {count}: "
            f"the largest order possible is {count - 1}"
        )
    basis, to_powers = _basis(points.normalised_resistance, order)
    scaled, solution, residuals = _least_squares(basis, points)
    spare = count - order - 1
    variance = float(residuals @ residuals) / spare if spare else 0.0
    inverse = np.linalg.inv(scaled.T @ scaled)
    covariance = to_powers @ inverse @ to_powers.T * variance * _widening(residuals, spare)
    return PolynomialFit(
        coefficients=tuple((to_powers @ solution).tolist()),
        standard_errors=tuple(np.sqrt(np.clip(np.diag(covariance), 0.0, None)).tolist()),
        covariance=covariance,
        spare_points=spare,
    )


def check_order(order: int) -> None:
    """Raise CallerError unless the order is a whole number from 1 to 15."""
    if not isinstance(order, int) or isinstance(order, bool) or not 1 <= order <= MAX_ORDER:
        raise CallerError(f"polynomial order is {order!r}: use a whole number from 1 to {MAX_ORDER}, or 'auto'")


def choose_order(branches: Sequence[FitPoints], max_order: int = 9) -> int:
    """Return the lowest order within one standard error of the best by cross-validation over blocks of samples."""
    smallest = min(points.normalised_resistance.size for points in branches)
    candidates = range(1, max(min(max_order, smallest * (FOLDS - 1) // FOLDS - 1), 1) + 1)
    errors = np.array([np.concatenate([_cross_validation_errors(p, order) for p in branches]) for order in candidates])
    means = errors.mean(axis=1)
    spread = errors.std(axis=1, ddof=1) / np.sqrt(errors.shape[1])
    best = int(np.argmin(means))
    return candidates[int(np.flatnonzero(means <= means[best] + spread[best])[0])]


def _cross_validation_errors(points: FitPoints, order: int) -> FloatArray:
    """Return the weighted mean square error on each block, fitted without its fold, shape (blocks,)."""
    count = points.normalised_resistance.size
    blocks = min(FOLDS * BLOCKS_PER_FOLD, count)
    block = np.arange(count) * blocks // count
    basis, _ = _basis(points.normalised_resistance, order)
    squares = np.empty(count)
    for fold in range(min(FOLDS, blocks)):
        out = block % FOLDS == fold
        kept = FitPoints(points.normalised_resistance[~out], points.quantity[~out], points.weights[~out])
        _, solution, _ = _least_squares(basis[~out], kept)
        squares[out] = (points.quantity[out] - basis[out] @ solution) ** 2
    weighted = np.bincount(block, weights=squares * points.weights, minlength=blocks)
    return weighted / np.bincount(block, weights=points.weights, minlength=blocks)


def _basis(fraction: FloatArray, order: int) -> tuple[FloatArray, FloatArray]:
    """Return Chebyshev polynomials at the points, shape (n, order + 1), and the matrix to power coefficients."""
    low, high = float(fraction.min()), float(fraction.max())
    columns = np.polynomial.chebyshev.chebvander((2.0 * fraction - low - high) / (high - low), order)
    to_powers = np.zeros((order + 1, order + 1))
    for k in range(order + 1):
        term = np.polynomial.Chebyshev.basis(k, domain=[low, high])
        powers = term.convert(kind=np.polynomial.Polynomial).coef
        to_powers[: powers.size, k] = powers
    return cast(FloatArray, columns), to_powers


def _least_squares(basis: FloatArray, points: FitPoints) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return weighted basis, solution and weighted residuals."""
    root = np.sqrt(points.weights)
    scaled = basis * root[:, None]
    solution = cast(FloatArray, np.linalg.lstsq(scaled, points.quantity * root)[0])
    return scaled, solution, points.quantity * root - scaled @ solution


def _widening(residuals: FloatArray, spare: int) -> float:
    """Return the factor (1 + r) / (1 - r) by which correlated residuals widen the covariance, at least 1."""
    power = float(residuals @ residuals)
    if spare < 8 or power <= 0.0:
        return 1.0
    correlation = min(max(float(residuals[1:] @ residuals[:-1]) / power, 0.0), 0.95)
    return (1.0 + correlation) / (1.0 - correlation)
