"""Point B: the maximum of resistance between cold wire and transformation, found so that noise hardly moves it."""

from __future__ import annotations

from functools import lru_cache
from math import sqrt
from typing import NamedTuple

import numpy as np
from scipy.special import fdtri

from musclewire.arrays import FloatArray

__all__ = ["ResistanceMaximum", "parabola_maximum", "resistance_maximum"]


# The widest window: where the resistance is within this fraction of the fall from B to C below its maximum. A wider
# one gains little, as a cubic follows the curve's bends over a part of it only.
APEX_FRACTION = 0.03
# It is also this many times the noise left in the smoothed curve high, in which its ends are looked for.
BUMP_NOISES = 6.0
# A window is narrowed by this factor while a cubic misses bends of the curve that are certain at this level (F-test
# of the two coefficients more of a quintic), so that a clean curve's own maximum is found and a noisy one's averaged,
NARROWER = 0.7
CERTAIN = 0.99
# but not one that is hardly higher than the noise,
MIN_NOISES = 3.0
# nor one in which a quintic would have too few degrees of freedom left to part noise from bends.
MIN_SAMPLES = 12
CUBIC, QUINTIC = 3, 5
# Moves of a window around the maximum of the cubic through it: where the first one lies is still up to the noise.
MOVES = 2


class ResistanceMaximum(NamedTuple):
    """The maximum of a resistance that was sampled one after the other.

    Parameters
    ----------
    place
        Where, in samples from the first one; between two samples as a rule.
    resistance_ohm
        The resistance there [ohm].
    """

    place: float
    resistance_ohm: float


def resistance_maximum(
    measured_ohm: FloatArray, smoothed_ohm: FloatArray, near: int, fall_ohm: float, noise_ohm: float
) -> ResistanceMaximum:
    """Return the maximum around a sample: that of the cubic through as many samples as one cubic can follow.

    Parameters
    ----------
    measured_ohm
        Resistance in the order of the samples, (n_times,) [ohm].
    smoothed_ohm
        The same smoothed as far as its noise requires, (n_times,) [ohm].
    near
        The sample of the largest smoothed resistance.
    fall_ohm
        Fall of resistance from there to C [ohm]; the widest window is a fraction of it high.
    noise_ohm
        Standard deviation of the noise that is left in the smoothed resistance [ohm]; 0 without any.

    Returns
    -------
    The maximum. On a curve without noise it is the curve's own, as :func:`parabola_maximum` finds it.
    """
    height_ohm = max(APEX_FRACTION * fall_ohm, BUMP_NOISES * noise_ohm)
    widest = above(smoothed_ohm, near, float(smoothed_ohm[near]) - height_ohm)
    window = widest
    while window.samples >= MIN_SAMPLES:
        window = moved(measured_ohm, window, widest, height_ohm)
        cubic = _Cubic.through(measured_ohm, window)
        found = cubic.maximum()
        if found is not None and (height_ohm < MIN_NOISES * cubic.noise_ohm or cubic.suffices()):
            return found
        height_ohm *= NARROWER
        window = narrower(window, near if found is None else round(found.place))
    return parabola_maximum(smoothed_ohm, near)


def parabola_maximum(resistance_ohm: FloatArray, peak: int) -> ResistanceMaximum:
    """Return the maximum of a curve without noise: the vertex of the parabola through a peak and its two neighbours.

    Parameters
    ----------
    resistance_ohm
        Resistance in the order of the samples, (n_times,) [ohm].
    peak
        The sample of the largest resistance; at an end of the samples it is the maximum itself.

    Returns
    -------
    The maximum, at most half a sample from the peak.
    """
    at = float(resistance_ohm[peak])
    if not 0 < peak < resistance_ohm.size - 1:
        return ResistanceMaximum(float(peak), at)
    before, after = float(resistance_ohm[peak - 1]), float(resistance_ohm[peak + 1])
    bend = 2.0 * at - before - after
    if bend <= 0.0:
        return ResistanceMaximum(float(peak), at)
    shift = min(max(0.5 * (after - before) / bend, -0.5), 0.5)
    return ResistanceMaximum(peak + shift, at + 0.25 * shift * (after - before))


class Window(NamedTuple):
    """The samples ``first`` to ``last``, both included."""

    first: int
    last: int

    @property
    def samples(self) -> int:
        """How many there are."""
        return self.last - self.first + 1


class _Cubic(NamedTuple):
    """The cubic of least squares through a window: in powers of the place from -1 to 1, and what it leaves."""

    window: Window
    powers_ohm: FloatArray
    missed_by_cubic: float
    noise_ohm: float

    @classmethod
    def through(cls, measured: FloatArray, window: Window) -> _Cubic:
        """Return the cubic; the noise is what a quintic leaves."""
        basis, to_powers = orthonormal_powers(window.samples)
        values = measured[window.first : window.last + 1]
        level = float(values.mean())  # subtracted so that a small bend on a large level keeps its digits
        parts = basis.T @ (values - level)
        left = values - level - basis @ parts
        powers = to_powers @ parts[: CUBIC + 1]
        powers[0] += level
        noise = sqrt(float(left @ left) / (window.samples - QUINTIC - 1))
        return cls(window, powers, float(np.sum(parts[CUBIC + 1 :] ** 2)), noise)

    def suffices(self) -> bool:
        """Return whether the quintic follows the samples no better than noise lets it (F-test)."""
        more = QUINTIC - CUBIC
        largest = fdtri(more, self.window.samples - QUINTIC - 1, CERTAIN)
        return bool(self.missed_by_cubic <= more * largest * self.noise_ohm**2)

    def maximum(self) -> ResistanceMaximum | None:
        """Return the maximum if it lies inside the window."""
        _, slope, bend, third = (float(power) for power in self.powers_ohm)
        square = bend * bend - 3.0 * third * slope
        if square <= 0.0:
            return None
        # Where the derivative is 0 and the second one negative, in the form that holds for a vanishing cube, too.
        divisor = sqrt(square) - bend
        place = slope / divisor if divisor > 0.0 else 2.0
        if not -1.0 < place < 1.0:
            return None
        middle, half = 0.5 * (self.window.first + self.window.last), 0.5 * (self.window.samples - 1)
        return ResistanceMaximum(middle + half * place, float(self.at(np.array([middle + half * place]))[0]))

    def at(self, places: FloatArray) -> FloatArray:
        """Return the cubic at places in samples, of any shape."""
        middle, half = 0.5 * (self.window.first + self.window.last), 0.5 * (self.window.samples - 1)
        return np.asarray(np.polynomial.polynomial.polyval((places - middle) / half, self.powers_ohm))


@lru_cache(maxsize=32)
def orthonormal_powers(samples: int) -> tuple[FloatArray, FloatArray]:
    """Return polynomials to the quintic that are orthonormal on evenly spaced places, and a cubic's powers from them.

    The first has shape (samples, 6), the second (4, 4).
    """
    vandermonde = np.vander(np.linspace(-1.0, 1.0, samples), QUINTIC + 1, increasing=True)
    basis, triangle = np.linalg.qr(vandermonde)
    return basis, np.linalg.inv(triangle[: CUBIC + 1, : CUBIC + 1])


def above(values: FloatArray, peak: int, level: float) -> Window:
    """Return the samples around a peak that lie above a level without a gap."""
    below = np.flatnonzero(values <= level)
    after = int(np.searchsorted(below, peak))
    first = int(below[after - 1]) + 1 if after > 0 else 0
    last = int(below[after]) - 1 if after < below.size else values.size - 1
    return Window(min(first, peak), max(last, peak))


def moved(measured: FloatArray, window: Window, widest: Window, height_ohm: float) -> Window:
    """Return the window in which the cubic through it is at most a height below its maximum."""
    for _ in range(MOVES):
        cubic = _Cubic.through(measured, window)
        found = cubic.maximum()
        if found is None:
            return window
        curve = cubic.at(np.arange(widest.first, widest.last + 1, dtype=np.float64))
        part = above(curve, round(found.place) - widest.first, found.resistance_ohm - height_ohm)
        if part.samples < MIN_SAMPLES:
            return window
        window = Window(widest.first + part.first, widest.first + part.last)
    return window


def narrower(window: Window, middle: int) -> Window:
    """Return the samples of a window on both sides of one, by a part fewer on each."""
    before, after = int(NARROWER * (middle - window.first)), int(NARROWER * (window.last - middle))
    return Window(middle - before, middle + after)
