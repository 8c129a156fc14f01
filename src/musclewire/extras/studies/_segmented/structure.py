"""What makes a wire in segments another wire than the one-segment model: its segments, grains, barriers and ageing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.wire import ONE_CLASS, BarrierClass, OffsetDistribution, tabulated_distribution

# Flexinol's data sheet (Dynalloy): 0.18 W/(cm K). Austenite; martensite has about half (Otsuka and Wayman 1998).
CONDUCTIVITY_W_PER_M_K = 18.0
REACH = 4.5
TABLE_POINTS = 800


class NormalMixture(NamedTuple):
    """A population of grains whose offsets are normal, in units of the spread."""

    weight: float  # above 0; the weights of a mixture add up to 1
    mean: float  # offset
    deviation: float  # above 0


class WireAgeing(NamedTuple):
    """What a wire changes by use: each effect grows with ln(1 + cycles / scale).

    References
    ----------
    Functional fatigue that slows down with the number of cycles: Eggeler et al. 2004, doi
    10.1016/j.msea.2003.10.327. The logarithm is assumed.
    """

    cycles_scale: float = 20.0  # cycles after which each effect has reached ln 2 of its number
    residual_strain: float = 0.0  # gain per unit of the logarithm
    resistance: float = 0.0  # relative rise per unit of the logarithm
    temperature_k: float = 0.0  # rise of the transformation temperatures per unit of the logarithm
    cycles_before: float = 0.0  # behind it at the start

    def effects(self, cycles: float) -> tuple[float, float, float]:
        """Return residual strain, resistance factor and shift of the transformation temperatures [K]."""
        before, after = (math.log1p(number / self.cycles_scale) for number in (self.cycles_before, cycles))
        grown = math.log1p((self.cycles_before + cycles) / self.cycles_scale) - before if before else after
        return self.residual_strain * grown, 1.0 + self.resistance * grown, self.temperature_k * grown


@dataclass(frozen=True)
class WireStructure:
    """How a wire is divided, and what its segments are made of.

    Parameters
    ----------
    n_segments
        Number of segments along the wire, 1 or more; ten or more resolve cold ends and draughts.
    clamped
        Whether both ends are held by clamps at the temperature of the air, into which they conduct.
    length_fractions
        Fractions of the length, from end to end, which add up to 1. None: equal, and of a clamped wire short at the
        ends and growing to the middle, so that cold ends are resolved.
    thermal_conductivity_w_per_m_k
        Conductivity along the wire [W/(m K)]; the default is the vendor's for austenite.
    temperature_shifts_k
        Transformation temperatures of each segment beyond the wire's [K]; none for all alike.
    convection_factors
        Convection of each segment as a multiple of the wire's; none for all alike.
    classes
        Grains by their barrier.
    grains
        Distribution of the grains' offsets; None for that of the alloy.
    ageing
        What the wire changes by use.
    """

    n_segments: int = 12
    clamped: bool = True
    length_fractions: Sequence[float] | None = None
    thermal_conductivity_w_per_m_k: float = CONDUCTIVITY_W_PER_M_K
    temperature_shifts_k: Sequence[float] = ()
    convection_factors: Sequence[float] = ()
    classes: Sequence[BarrierClass] = ONE_CLASS
    grains: OffsetDistribution | None = None
    ageing: WireAgeing = field(default_factory=WireAgeing)

    def along(self, name: str, absent: float) -> FloatArray:
        """Return a number of each segment.

        Parameters
        ----------
        name
            Field that holds the numbers.
        absent
            What each is if the field is empty.

        Returns
        -------
        The numbers, (n_segments,).

        Raises
        ------
        CallerError
            Unless there are as many as segments, or none.
        """
        values = np.asarray(getattr(self, name), dtype=np.float64)
        if values.size == 0:
            return np.full(self.n_segments, absent)
        if values.shape != (self.n_segments,) or not np.isfinite(values).all():
            raise CallerError(
                f"{name} has {values.size} numbers: give a finite one for each of the {self.n_segments} segments"
            )
        return values

    def fractions(self, end_fraction: float) -> FloatArray:
        """Return the fraction of the length of each segment.

        Parameters
        ----------
        end_fraction
            Fraction of a segment at a clamp, where the structure states no lengths.

        Returns
        -------
        The fractions from end to end, (n_segments,), which add up to 1.

        Raises
        ------
        CallerError
            If those that are stated do not make up a wire.
        """
        if self.n_segments < 1:
            raise CallerError(f"a wire has 1 segment or more, not {self.n_segments}")
        if self.length_fractions is None:
            return graded_fractions(self.n_segments, end_fraction if self.clamped else math.inf)
        given = self.along("length_fractions", 0.0)
        if not (given.min() > 0.0 and abs(given.sum() - 1.0) < 1e-9):
            raise CallerError(f"length_fractions add up to {given.sum():g}: each above 0, and 1 together")
        return given


def fin_length_m(conductivity_w_per_m_k: float, diameter_m: float, convection_w_per_m2_k: float) -> float:
    """Return the length over which a cold clamp cools a wire [m], to 1/e of its effect: sqrt(k A / (h P)) of a fin.

    References
    ----------
    Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, fins of uniform cross section.
    """
    return math.sqrt(conductivity_w_per_m_k * diameter_m / (4.0 * convection_w_per_m2_k))


def graded_fractions(n_segments: int, end_fraction: float) -> FloatArray:
    """Return lengths, with a sum of 1, that grow from a given one at both ends by one ratio; else equal ones."""
    if n_segments < 4 or end_fraction * n_segments >= 1.0:
        return np.full(n_segments, 1.0 / n_segments)
    steps = np.minimum(np.arange(n_segments), np.arange(n_segments)[::-1])
    low, high = 1.0, 1.0 / end_fraction
    for _ in range(200):
        ratio = 0.5 * (low + high)
        if end_fraction * (ratio**steps).sum() < 1.0:
            low = ratio
        else:
            high = ratio
    lengths = end_fraction * low**steps
    return np.asarray(lengths / lengths.sum())


def mixture_distribution(parts: Sequence[NormalMixture]) -> OffsetDistribution:
    """Return the distribution of a mixture of grains, cut off at 4.5 standard deviations of the outermost."""
    weights = [part.weight for part in parts]
    if not parts or min(weights) <= 0.0 or abs(sum(weights) - 1.0) > 1e-9 or min(part.deviation for part in parts) <= 0:
        raise CallerError(
            "a mixture needs populations whose weights are above 0 and add up to 1, deviations above 0, not "
            f"{list(parts)}"
        )
    low = min(part.mean - REACH * part.deviation for part in parts)
    high = max(part.mean + REACH * part.deviation for part in parts)
    offset = np.linspace(low, high, TABLE_POINTS)
    below = sum(part.weight * ndtr((offset - part.mean) / part.deviation) for part in parts)
    cumulative = np.asarray(below)
    cumulative[0], cumulative[-1] = 0.0, 1.0
    return tabulated_distribution(offset, cumulative)
