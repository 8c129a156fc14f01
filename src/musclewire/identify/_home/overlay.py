"""Laying the fall of a sweep over that of the loop that a model was fitted to, which shows where C has moved.

A loop seldom ends at C, and a fast sweep turns elsewhere, so that the lowest resistances of the two do not compare. The
fall from B has a shape, though, and both of its axes may only have stretched and moved: resistance with age, leads or
load; warming with the air, its flow, the load or the alloy. So the loop's fall is laid over today's, and where its
hottest point comes to lie is today's resistance there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.identify._home.warming import STEPS_PER_LAG, HeatCourse, heating_branch
from musclewire.wire import HeatBalance

# Latent heat of NiTi wire, 10 to 20 kJ/kg (published_ranges), as the warming that the whole fall takes up.
LATENT_K = 20.0
# Error of a point of the curve, as a fraction of the fall. Neighbouring points share theirs: with it the change at C of
# a wire that has not changed lies within two of the stated standard deviations.
CURVE_FRACTION = 0.01
# A point of the loop that the sweep did not reach is off by at least this fraction of the fall.
BEYOND_FRACTION = 0.03
# Bounds of the stretch of the warming in the search, over its first guess.
MIN_STRETCH = 0.6
MAX_STRETCH = 1.6
# Fractions of the fall of resistance, at which the warming gives the first guess; chosen: farther apart they lie where
# the curve is flat, nearer to each other they determine the stretch less.
EARLY = 0.25
LATE = 0.75
LATE = 0.75


class Overlay(NamedTuple):
    """What lays a loop's fall over that of a sweep."""

    scale: float  # the fall of the sweep over that of the loop between the same two points of the curve
    scale_std: float
    # Warming of the sweep over that of the loop, by the nominal loss to the air: the ratio of the losses where only the
    # air's flow has changed.
    stretch: float
    stretch_std: float
    warmer_k: float  # by how much more the middle of the fall warms than in the loop, by the nominal loss
    middle_k: float  # warming of the loop in the middle of its fall
    covered: float  # part of the loop's points that the sweep reached
    misfit_ohm: float  # root mean square of what is left


class Fall(NamedTuple):
    """Resistance over warming from B on, each (n,), with rising warming [K]."""

    warming_k: FloatArray
    resistance_ohm: FloatArray

    @classmethod
    def of_course(cls, course: HeatCourse, heat: HeatBalance, latent_k_per_ohm: float) -> Fall:
        """Return the fall of a course."""
        even = course.evenly(heat.lag_s / STEPS_PER_LAG)
        warming_k, resistance_ohm = heating_branch(even, even.warming_k(heat, latent_k_per_ohm))
        b = int(np.argmax(resistance_ohm))
        return cls(warming_k[b:], resistance_ohm[b:])

    def warming_at_k(self, fallen: float) -> float:
        """Return the warming at which a part of the fall is done [K]."""
        level_ohm = self.resistance_ohm[0] - fallen * float(np.ptp(self.resistance_ohm))
        return float(self.warming_k[int(np.argmax(self.resistance_ohm <= level_ohm))])


def overlay_of(
    loop: HeatCourse, sweep: HeatCourse, heat: HeatBalance, span_ohm: float, b_ohm: tuple[float, float]
) -> Overlay:
    """Lay a loop's fall over that of a sweep by least squares; ``b_ohm`` is the resistance at B in loop and sweep."""
    latent_k_per_ohm = LATENT_K / span_ohm
    then = Fall.of_course(loop, heat, latent_k_per_ohm)
    stretch = laid_over(then, Fall.of_course(sweep, heat, latent_k_per_ohm), span_ohm, b_ohm).stretch
    # A loss to the air that has changed changes the lag, and the warming that stands for the latent heat.
    slower = heat._replace(capacity_j_per_k=heat.capacity_j_per_k / stretch)
    return laid_over(then, Fall.of_course(sweep, slower, latent_k_per_ohm * stretch), span_ohm, b_ohm)


def laid_over(then: Fall, today: Fall, span_ohm: float, b_ohm: tuple[float, float]) -> Overlay:
    """Return what lays one fall over another, both of which begin at a known resistance."""
    from scipy.optimize import least_squares

    was_ohm, is_ohm = b_ohm
    early_k, late_k = then.warming_at_k(EARLY), then.warming_at_k(LATE)
    guessed = (today.warming_at_k(LATE) - today.warming_at_k(EARLY)) / (late_k - early_k)

    def difference_ohm(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        scale, stretch, shift_k = values
        at_k = stretch * then.warming_k + shift_k
        expected_ohm = is_ohm + scale * (then.resistance_ohm - was_ohm)
        left_ohm = expected_ohm - np.interp(at_k, today.warming_k, today.resistance_ohm)
        return left_ohm, at_k <= today.warming_k[-1]

    def residuals(values: FloatArray) -> FloatArray:
        left_ohm, reached = difference_ohm(values)
        missed_ohm = np.maximum(np.abs(left_ohm), BEYOND_FRACTION * span_ohm)
        return np.where(reached, left_ohm, missed_ohm) / (CURVE_FRACTION * span_ohm)

    start = (1.0, guessed, today.warming_at_k(EARLY) - guessed * early_k)
    bounds = ((0.5, MIN_STRETCH * guessed, -np.inf), (2.0, MAX_STRETCH * guessed, np.inf))
    found = least_squares(residuals, start, x_scale=(0.05, 0.1, 5.0), bounds=bounds)
    left_ohm, reached = difference_ohm(found.x)
    slopes = np.asarray(found.jac, dtype=np.float64)
    scale_std, stretch_std, _ = np.sqrt(np.diag(np.linalg.pinv(slopes.T @ slopes))).tolist()
    scale, stretch, shift_k = found.x.tolist()
    middle_k = 0.5 * (early_k + late_k)
    return Overlay(
        scale=scale,
        scale_std=scale_std,
        stretch=stretch,
        stretch_std=stretch_std,
        warmer_k=(stretch - 1.0) * middle_k + shift_k,
        middle_k=middle_k,
        covered=float(np.mean(reached)),
        misfit_ohm=float(np.sqrt(np.mean(left_ohm[reached] ** 2))) if reached.any() else float("inf"),
    )
