"""The spread of transformation temperatures over a wire's grains."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

__all__ = ["GrainSpread", "signed_power", "spread_grains"]


class GrainSpread(NamedTuple):
    """Grains as adjacent intervals in units of the spread.

    Parameters
    ----------
    edges
        Edges of the intervals, ascending, (n_grains + 1,).
    middle
        Middle of each interval, (n_grains,).
    width
        Width of each interval, (n_grains,).
    """

    edges: FloatArray
    middle: FloatArray
    width: FloatArray


# Half-width of the linear core, in normal quantiles: without one the middle grains would all switch at one temperature.
CORE = 0.3


def signed_power(normal_quantile: FloatArray, skew: float, tail: float) -> FloatArray:
    """Return z (z^2 + 0.3^2)^(tail/2), stretched by 1 + skew above and 1 - skew below the middle; always increasing.

    A signed power of a normal quantile with a linear core, in two pieces (Fechner's split distribution). Measured
    Flexinol isobars have a sharp core with long tails (tail near 1), unlike a normal distribution (tail 0) or a cosine
    law.

    Parameters
    ----------
    normal_quantile
        z, quantiles of the standard normal distribution, of any shape.
    skew
        Stretches the upper half by 1 + skew and the lower one by 1 - skew; between -1 and 1, 0 is symmetric.
    tail
        How heavy both tails are, 0 or more; 0 is the normal distribution.

    Returns
    -------
    Offsets in units of the spread, in the shape of ``normal_quantile``.

    Raises
    ------
    CallerError
        For a tail below 0 or a skew outside -1 to 1, for which the result would not be increasing.
    """
    if not (0.0 <= tail < np.inf and -1.0 < skew < 1.0):
        raise CallerError(f"grain_tail {tail} must be 0 or more and grain_skew {skew} between -1 and 1")
    z = np.asarray(normal_quantile, dtype=np.float64)
    return np.asarray((1.0 + skew * np.sign(z)) * z * (z * z + CORE**2) ** (0.5 * tail), dtype=np.float64)


def spread_grains(grains: int, skew: float, tail: float) -> GrainSpread:
    """Return ``grains`` classes of equal weight of a signed-power distribution.

    Class j extends from the quantile j/n to (j + 1)/n. The outermost two would be unbounded: they extend as far
    outwards from the quantile in their middle as inwards.

    Parameters
    ----------
    grains
        Number of classes, at least 2.
    skew
        Skew of the distribution, between -1 and 1: see :func:`signed_power`.
    tail
        Tail of the distribution, 0 or more.

    Returns
    -------
    Edges, middles and widths of the classes in units of the spread.

    Raises
    ------
    CallerError
        For fewer than two grains, or a skew or tail out of range.
    """
    if grains < 2:
        raise CallerError(f"grains is {grains}: an ensemble needs at least 2")
    inner = signed_power(ndtri(np.arange(1, grains) / grains), skew, tail)
    outermost = signed_power(ndtri(np.array([0.5, grains - 0.5]) / grains), skew, tail)
    edges = np.concatenate(([2.0 * outermost[0] - inner[0]], inner, [2.0 * outermost[1] - inner[-1]]))
    return GrainSpread(edges=edges, middle=0.5 * (edges[1:] + edges[:-1]), width=np.diff(edges))
