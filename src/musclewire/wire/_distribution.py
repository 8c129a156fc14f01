"""The distribution of transformation temperatures over a wire's grains, as a table that compiled code interpolates."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.special import ndtr, ndtri

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

# Half-width of the linear core, in normal quantiles: without one the middle grains would all switch at one temperature.
CORE = 0.3
# The table ends at these normal quantiles: 3 grains in a million lie beyond each, and count as those at its end.
REACH = 4.5
# The same number for all: compiled code then knows the table's size. 32 kB, of which a step touches a few lines.
CELLS = 1024
CORE_REACH = 1.0  # normal quantile to either side at which the core of fine cells ends
CORE_CELLS = CELLS // 2  # cells in it: with heavy tails, equal cells would leave a steep middle too few


class OffsetDistribution(NamedTuple):
    """Cumulative distribution of the grains' offsets in units of the spread: cubics on cells.

    Cells have one width, or two: narrow ones in a core, where a heavy-tailed distribution is steep, wide ones outside.
    Cumulative is 0 below the first cell, 1 above the last.
    """

    start: float  # offset of the first cell's lower end
    step: float  # width of a cell outside the core
    cells: FloatArray  # each cell's cubic over the place in it, 0 to 1, constant term first; (n_cells, 4)
    core_start: float = 0.0  # an end of a cell; that of the core, too, for no core
    core_end: float = 0.0
    core_step: float = 1.0  # width of a cell in the core

    def cumulative(self, offset: FloatArray) -> FloatArray:
        """Return the fraction of the grains below offsets of any shape."""
        offset = np.asarray(offset, dtype=np.float64)
        core = np.clip(offset, self.core_start, self.core_end)
        place = (self.core_start - self.start) / self.step + (core - self.core_start) / self.core_step
        place = np.clip(place + (offset - core) / self.step, 0.0, len(self.cells))
        low = np.minimum(place.astype(int), len(self.cells) - 1)
        part = place - low
        a, b, c, d = np.moveaxis(self.cells[low], -1, 0)
        return np.asarray(a + part * (b + part * (c + part * d)))


class BarrierClass(NamedTuple):
    """A class of grains with a barrier of its own: an ensemble, of which the wire is the weighted sum."""

    weight: float  # fraction of the wire's grains, above 0; all add up to 1
    barrier_k: float  # beyond the alloy's martensite_barrier_k, of either sign


ONE_CLASS = (BarrierClass(1.0, 0.0),)


def of_classes(classes: Sequence[BarrierClass]) -> tuple[FloatArray, FloatArray]:
    """Return weights, positive and adding up to 1, and barriers [K] of classes, each (n_classes,)."""
    weights = np.array([item.weight for item in classes])
    if not (len(weights) and weights.min() > 0.0 and abs(weights.sum() - 1.0) < 1e-9):
        raise CallerError(f"the classes' weights {weights.tolist()} must be above 0 and add up to 1")
    return weights, np.array([item.barrier_k for item in classes])


def signed_power(normal_quantile: FloatArray, skew: float, tail: float) -> FloatArray:
    """Return z (z^2 + 0.3^2)^(tail/2), stretched by 1 + skew above and 1 - skew below the middle; always increasing.

    A signed power of a normal quantile z with a linear core, in two pieces (Fechner's split distribution), for a skew
    between -1 and 1 and a tail of 0 or more. Measured Flexinol isobars have a sharp core with long tails (tail near 1),
    unlike a normal distribution (tail 0) or a cosine law.
    """
    if not (0.0 <= tail < np.inf and -1.0 < skew < 1.0):
        raise CallerError(f"grain_tail {tail} must be 0 or more and grain_skew {skew} between -1 and 1")
    z = np.asarray(normal_quantile, dtype=np.float64)
    return np.asarray((1.0 + skew * np.sign(z)) * z * (z * z + CORE**2) ** (0.5 * tail), dtype=np.float64)


@lru_cache(maxsize=64)
def signed_power_distribution(skew: float, tail: float) -> OffsetDistribution:
    """Return the distribution of :func:`signed_power` over normal quantiles of -4.5 to 4.5, tabulated.

    Value and density are exact at every end of a cell. The density jumps at offset 0 if there is a skew; a cell ends
    there.
    """
    core_end = abs(signed_power(np.array([-CORE_REACH, CORE_REACH]), skew, tail))
    core_step, below = cells_on_both_sides(core_end, CORE_CELLS)
    core = core_step * np.arange(-below, CORE_CELLS - below + 1)
    beyond = abs(signed_power(np.array([-REACH, REACH]), skew, tail)) - (-core[0], core[-1])
    step, below = cells_on_both_sides(beyond, CELLS - CORE_CELLS)
    outside = step * np.arange(1, CELLS - CORE_CELLS + 1)
    offset = np.concatenate((core[0] - outside[:below][::-1], core, core[-1] + outside[: CELLS - CORE_CELLS - below]))
    quantile = quantile_at(np.asarray(offset, dtype=np.float64), skew, tail)
    cumulative = ndtr(quantile)
    cumulative[0], cumulative[-1] = 0.0, 1.0
    density = np.exp(-0.5 * quantile**2) / math.sqrt(2.0 * math.pi) / unskewed_slope(quantile, tail)
    left = density / np.where(offset > 0.0, 1.0 + skew, 1.0 - skew)
    right = density / np.where(offset >= 0.0, 1.0 + skew, 1.0 - skew)
    width = np.diff(offset)
    cells = cubic_cells(cumulative, right[:-1] * width, left[1:] * width)
    return OffsetDistribution(float(offset[0]), step, cells, float(core[0]), float(core[-1]), core_step)


def two_populations(
    normal_quantile: FloatArray, skew: float, tail: float, early_fraction: float, early_width: float
) -> FloatArray:
    """Return :func:`signed_power`, below it the ``early_fraction`` of the grains spread evenly over ``early_width``."""
    require_early_population(early_fraction, early_width)
    z = np.asarray(normal_quantile, dtype=np.float64)
    offset = signed_power(np.maximum(z, ndtri(early_fraction)), skew, tail)
    if early_fraction == 0.0:
        return offset
    return np.asarray(offset - early_width * np.maximum(1.0 - ndtr(z) / early_fraction, 0.0))


def require_early_population(early_fraction: float, early_width: float) -> None:
    """Raise CallerError for an early population that cannot be."""
    if not (0.0 <= early_fraction < 1.0 and 0.0 < early_width < math.inf):
        raise CallerError(f"early_fraction {early_fraction} must be 0 to below 1, early_width {early_width} above 0")


@lru_cache(maxsize=64)
def two_population_distribution(
    skew: float, tail: float, early_fraction: float, early_width: float
) -> OffsetDistribution:
    """Return the distribution of :func:`two_populations` up to the quantile of +4.5, tabulated.

    Value and density are exact at every end of a cell. Cells end where the early grains begin and where they end, and
    at offset 0 if that is not within a cell of the kink: there, for an early fraction just below a half, the jump of a
    skewed density costs up to 0.2 % of the wire. An early fraction too small for a table is taken as none.
    """
    require_early_population(early_fraction, early_width)
    if early_fraction <= ndtr(-REACH):
        return signed_power_distribution(skew, tail)
    cells = cells_with_an_even_end(skew, tail, float(ndtri(early_fraction)), early_width)
    early = cells.early
    quantile = quantile_at(cells.ends[early:], skew, tail)
    cumulative = np.concatenate((early_fraction * np.arange(early) / early, ndtr(quantile)))
    cumulative[early], cumulative[-1] = early_fraction, 1.0
    density = np.exp(-0.5 * quantile**2) / math.sqrt(2.0 * math.pi) / unskewed_slope(quantile, tail)
    left, right = np.full((2, CELLS + 1), early_fraction / early_width)
    left[early + 1 :] = (density / np.where(cells.ends[early:] > 0.0, 1.0 + skew, 1.0 - skew))[1:]
    right[early:] = density / np.where(cells.ends[early:] >= 0.0, 1.0 + skew, 1.0 - skew)
    width, most = np.diff(cells.ends), 3.0 * np.diff(cumulative)
    # A very narrow early population leaves a steep middle cells too wide, which would overshoot (Fritsch, Carlson).
    rises = np.minimum(right[:-1] * width, most), np.minimum(left[1:] * width, most)
    return OffsetDistribution(
        float(cells.ends[0]),
        cells.step,
        cubic_cells(cumulative, *rises),
        float(cells.ends[cells.core]),
        float(cells.ends[cells.core + CORE_CELLS]),
        cells.core_step,
    )


class EvenEndCells(NamedTuple):
    """Ends of a table's cells, ascending; how many cells the early grains have and how many lie below the core."""

    ends: FloatArray
    early: int
    core: int
    step: float
    core_step: float


def cells_with_an_even_end(skew: float, tail: float, kink_quantile: float, early_width: float) -> EvenEndCells:
    """Return a table's cells; early grains end at one's end, the core a whole number of cells above it, or there."""
    top_quantile = max(CORE_REACH, kink_quantile + 1.0)
    quantiles = np.array([kink_quantile, -CORE_REACH, top_quantile, max(REACH, top_quantile)])
    kink, bottom, top, end = (float(offset) for offset in signed_power(quantiles, skew, tail))
    outside = CELLS - CORE_CELLS
    between = max(bottom - kink, 0.0)
    early = int(outside * early_width / (between + early_width + end - top))
    step = early_width / max(early, 1)
    if early == 0:  # the narrowest early grains: the core takes whatever cells as narrow as they leave
        early, between, top = 1, 0.0, max(top, end - (outside - 1) * step)
    below = int(between / step)
    core, core_step = core_cells(kink + below * step, top)
    lower = kink + step * np.arange(-early, below)
    upper = core[-1] + step * np.arange(1, outside - early - below + 1)
    return EvenEndCells(np.concatenate((lower, core, upper)), early, early + below, step, core_step)


def core_cells(bottom: float, top: float) -> tuple[FloatArray, float]:
    """Return the ends of a core's cells from an offset up to another or beyond, and their width; one ends at 0."""
    below = int(CORE_CELLS * -bottom / (top - bottom))
    if below < 1:  # 0 lies below the core, or in its first cell
        step = (top - bottom) / CORE_CELLS
        return np.asarray(bottom + step * np.arange(CORE_CELLS + 1)), step
    step = -bottom / below
    return np.asarray(step * np.arange(-below, CORE_CELLS - below + 1)), step


def cells_on_both_sides(reach: FloatArray, cells: int) -> tuple[float, int]:
    """Return the width of cells that reach as far below a place and above it, (2,), and how many lie below."""
    below = min(max(round(cells * float(reach[0] / reach.sum())), 1), cells - 1)
    return max(float(reach[0]) / below, float(reach[1]) / (cells - below)), below


def unskewed_slope(quantile: FloatArray, tail: float) -> FloatArray:
    """Return the derivative of :func:`signed_power` without skew by the normal quantile."""
    square = quantile * quantile + CORE**2
    return np.asarray(square ** (0.5 * tail) + tail * quantile * quantile * square ** (0.5 * tail - 1.0))


def quantile_at(offset: FloatArray, skew: float, tail: float) -> FloatArray:
    """Return the normal quantiles of offsets within the table: the inverse of :func:`signed_power`."""
    target = np.abs(offset) / (1.0 + skew * np.sign(offset))
    grid = np.linspace(0.0, REACH + 1.0, 1001)
    quantile = np.interp(target, signed_power(grid, 0.0, tail), grid)
    for _ in range(5):  # Newton from a hundredth of the answer: the third step is already at rounding
        missing = target - quantile * (quantile * quantile + CORE**2) ** (0.5 * tail)
        quantile = np.maximum(quantile + missing / unskewed_slope(quantile, tail), 0.0)
    return np.asarray(np.sign(offset) * quantile)


def cubic_cells(value: FloatArray, rise_at_start: FloatArray, rise_at_end: FloatArray) -> FloatArray:
    """Return Hermite cubics (n_cells, 4) through values (n_cells + 1,) with slopes per cell at both ends of each."""
    rise = np.diff(value)
    square = 3.0 * rise - 2.0 * rise_at_start - rise_at_end
    cube = rise_at_start + rise_at_end - 2.0 * rise
    return np.ascontiguousarray(np.stack((value[:-1], rise_at_start, square, cube), axis=1))


def tabulated_distribution(offset: FloatArray, cumulative: FloatArray, *, cells: int = CELLS) -> OffsetDistribution:
    """Return a distribution through any table: monotone cubics between its points, resampled onto equal cells.

    Offsets ascend, and fractions from 0 to 1. The default of cells resolves points a hundredth of the table's width
    apart.

    References
    ----------
    Monotone cubic interpolation: Fritsch and Butland 1984, doi 10.1137/0905021.
    """
    offset, cumulative = np.asarray(offset, dtype=np.float64), np.asarray(cumulative, dtype=np.float64)
    if offset.ndim != 1 or offset.shape != cumulative.shape or len(offset) < 2 or cells < 2:
        raise CallerError(
            f"a distribution's table needs two columns of the same length, 2 points and 2 cells at least, not "
            f"{offset.shape}, {cumulative.shape} and {cells} cells"
        )
    if not (np.diff(offset) > 0.0).all():
        raise CallerError(f"the offsets of a distribution's table must ascend, not by {np.diff(offset).min():g}")
    if not ((np.diff(cumulative) >= 0.0).all() and cumulative[0] == 0.0 and cumulative[-1] == 1.0):
        raise CallerError(
            f"the fractions of a distribution's table must ascend from 0 to 1, not from {cumulative[0]:g} to "
            f"{cumulative[-1]:g} by {np.diff(cumulative).min():g} at least"
        )
    curve = PchipInterpolator(offset, cumulative)
    ends = np.linspace(offset[0], offset[-1], cells + 1)
    step = float(ends[1] - ends[0])
    slope = curve.derivative()(ends) * step
    value = np.clip(curve(ends), 0.0, 1.0)
    value[0], value[-1] = 0.0, 1.0
    return OffsetDistribution(float(ends[0]), step, cubic_cells(value, slope[:-1], slope[1:]))


@lru_cache(maxsize=64)
def quantile_distribution(offset: tuple[float, ...], fraction: tuple[float, ...]) -> OffsetDistribution:
    """Return the distribution through measured quantiles, the same table for the same numbers: batches share it."""
    return tabulated_distribution(np.array(offset), np.array(fraction))
