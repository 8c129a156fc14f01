"""The spread of transformation temperatures over a wire's grains."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from musclewire.errors import CallerError

__all__ = ["GrainSpread", "signed_power", "spread_grains"]

FloatArray = NDArray[np.float64]


class GrainSpread(NamedTuple):
    """Middle and width of each grain in units of the spread, both (n_grains,), middles rising."""

    middle: FloatArray
    width: FloatArray


def signed_power(normal_quantile: FloatArray, skew: float, tail: float) -> FloatArray:
    """Return z |z|^tail, stretched by 1 + skew above and 1 - skew below the middle; always increasing.

    A signed power of a normal quantile, in two pieces (Fechner's split distribution). Measured Flexinol isobars
    have a sharp core with long tails (tail near 1), which a normal distribution (tail 0) or a cosine law has not.

    Raises CallerError for a tail below 0 or a skew outside -1 to 1, with which it would fold back.
    """
    if tail < 0.0 or not -1.0 < skew < 1.0:
        raise CallerError(f"grain_tail {tail} must be 0 or more and grain_skew {skew} between -1 and 1")
    z = np.asarray(normal_quantile, dtype=np.float64)
    return np.asarray((1.0 + skew * np.sign(z)) * z * np.abs(z) ** tail, dtype=np.float64)


def spread_grains(grains: int, skew: float, tail: float) -> GrainSpread:
    """Return ``grains`` classes of equal share of a signed-power distribution.

    Class j lies at the quantile (j + 1/2)/n and reaches to its neighbours; the outermost two, whose true
    reach is endless, are as wide outwards as inwards.
    """
    if grains < 2:
        raise CallerError(f"grains is {grains}: an ensemble needs at least 2")
    middle = signed_power(ndtri((np.arange(grains) + 0.5) / grains), skew, tail)
    inner = signed_power(ndtri(np.arange(1, grains) / grains), skew, tail)
    lower = np.concatenate(([2.0 * middle[0] - inner[0]], inner))
    upper = np.concatenate((inner, [2.0 * middle[-1] - inner[-1]]))
    return GrainSpread(middle=middle, width=upper - lower)
