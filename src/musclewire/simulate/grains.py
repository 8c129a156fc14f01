"""The spread of transformation temperatures over a wire's grains."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from musclewire.errors import CallerError

__all__ = ["GrainSpread", "g_and_h", "spread_grains"]

FloatArray = NDArray[np.float64]


class GrainSpread(NamedTuple):
    """Middle and width of each grain in units of the spread, both (n_grains,), middles rising."""

    middle: FloatArray
    width: FloatArray


def g_and_h(normal_quantile: FloatArray, skew: float, tail: float) -> FloatArray:
    """Return Tukey's g-and-h transform of normal quantiles: skew g, tail weight h >= 0; always increasing.

    Tukey 1977; Hoaglin 1985 in "Exploring Data Tables, Trends, and Shapes", ch. 11. Measured Flexinol isobars
    have a sharp core with long tails, which a normal distribution (g = h = 0) or a cosine law does not have.

    Raises CallerError for a negative tail weight, with which the transform would fold back.
    """
    if tail < 0.0:
        raise CallerError(f"grain_tail is {tail}: it must be 0 (normal) or more, or grains would fold back")
    z = np.asarray(normal_quantile, dtype=np.float64)
    core = z if skew == 0.0 else np.expm1(skew * z) / skew
    return np.asarray(core * np.exp(0.5 * tail * z * z), dtype=np.float64)


def spread_grains(grains: int, skew: float, tail: float) -> GrainSpread:
    """Return ``grains`` classes of equal share of a g-and-h distribution.

    Class j lies at the quantile (j + 1/2)/n and reaches to its neighbours; the outermost two, whose true
    reach is endless, are as wide outwards as inwards.
    """
    if grains < 2:
        raise CallerError(f"grains is {grains}: an ensemble needs at least 2")
    middle = g_and_h(ndtri((np.arange(grains) + 0.5) / grains), skew, tail)
    inner = g_and_h(ndtri(np.arange(1, grains) / grains), skew, tail)
    lower = np.concatenate(([2.0 * middle[0] - inner[0]], inner))
    upper = np.concatenate((inner, [2.0 * middle[-1] - inner[-1]]))
    return GrainSpread(middle=middle, width=upper - lower)
