"""By how much a wire of today differs from its model: the scale of its resistance, and where today's zero is.

Whatever is seen of that is evidence of both, by their deviations: a home move of the resistance, the height of B, a
strain that is known at one moment, the temperature of the room. It is applied to the model, and never to a reading:
what was recorded is what was read.
"""

from __future__ import annotations

from dataclasses import replace
from math import exp
from typing import NamedTuple, TypeVar

from musclewire.sensing._curve import ResistanceCurve
from musclewire.sensing._fit_report import FittedCurve

FittedKind = TypeVar("FittedKind", bound=FittedCurve)


class Correction(NamedTuple):
    """What makes a model that of today: a Gaussian estimate of two numbers, by default certainly of no change."""

    scale: float = 1.0  # the model's resistance over today's
    zero: float = 0.0  # what a model says in its own unit where the wire of today is at zero
    scale_variance: float = 0.0  # of the scale's logarithm
    covariance: float = 0.0  # of the scale's logarithm and the zero
    zero_variance: float = 0.0  # in the square of the quantity's unit

    @property
    def is_believed(self) -> bool:
        """Whether nothing has put it in doubt."""
        return self.scale_variance == 0.0 == self.zero_variance

    def variance(self, by_scale: float) -> float:
        """Return the variance of an estimate by it, where a relative change of scale makes so much of the quantity."""
        of_zero = self.zero_variance - 2.0 * by_scale * self.covariance
        return max(by_scale * by_scale * self.scale_variance + of_zero, 0.0)

    def updated(self, missed: float, by_scale: float, by_zero: float, variance: float) -> Correction:
        """Return the correction after a Kalman update: a prediction missed by so much, within a variance.

        A change of the scale's logarithm, and one of the zero, change the prediction by ``by_scale`` and ``by_zero``.
        """
        with_scale = by_scale * self.scale_variance + by_zero * self.covariance
        with_zero = by_scale * self.covariance + by_zero * self.zero_variance
        total = by_scale * with_scale + by_zero * with_zero + variance
        return Correction(
            self.scale * exp(-with_scale * missed / total),
            self.zero - with_zero * missed / total,
            self.scale_variance - with_scale * with_scale / total,
            self.covariance - with_scale * with_zero / total,
            self.zero_variance - with_zero * with_zero / total,
        )

    def with_zero_less_certain(self, variance: float) -> Correction:
        """Return it with a zero that is known less well by such a variance."""
        return self._replace(zero_variance=self.zero_variance + variance)

    def applied_to(self, model: FittedKind) -> FittedKind:
        """Return the model with the resistances of today; its zero stays, which the estimate counts from."""
        return model if self.scale == 1.0 else with_resistances(model, 1.0 / self.scale, 0.0)


UNCORRECTED = Correction()


def with_resistances(model: FittedKind, scale: float, offset_ohm: float) -> FittedKind:
    """Return a model with every resistance in it a factor and an offset [ohm] away from what it was."""

    def moved(resistance_ohm: float) -> float:
        return scale * resistance_ohm + offset_ohm

    return replace(
        model,
        resistance_min_ohm=moved(model.resistance_min_ohm),
        resistance_max_ohm=moved(model.resistance_max_ohm),
        heating_samples=tuple((moved(one), value) for one, value in model.heating_samples),
        cooling_samples=tuple((moved(one), value) for one, value in model.cooling_samples),
        slow_loop=tuple((time_s, power_w, moved(one)) for time_s, power_w, one in model.slow_loop),
    )


def by_scale_of(curve: ResistanceCurve) -> float:
    """Return what a relative change of the resistance makes of the quantity, in the mean of the curve's range."""
    low_ohm, high_ohm = curve.valid_resistance_ohm
    return -0.5 * (curve.quantity_max - curve.quantity_min) * (low_ohm + high_ohm) / (high_ohm - low_ohm)
