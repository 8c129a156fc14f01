"""Point B: the maximum of resistance between cold wire and transformation, found so that noise hardly moves it."""

from __future__ import annotations

from functools import lru_cache
from math import sqrt
from typing import NamedTuple

import numpy as np
from scipy.special import fdtri

from musclewire.arrays import FloatArray

# The widest window: where the resistance is within this fraction of the fall from B to C below its maximum. A wider
# one gains little, as a polynomial follows the curve's bends over a part of it only.
APEX_FRACTION = 0.03
# It is also this many times the noise left in the smoothed curve high, in which its ends are looked for.
BUMP_NOISES = 6.0
# Polynomials tried in a window, the simplest first: a broad top with a corner needs more than a cubic.
ORDERS = (3, 5, 7)
CUBIC = ORDERS[0]
MORE = 2  # orders above a polynomial's in which a test looks for bends that it misses
HIGHEST = ORDERS[-1] + 2
# A window is narrowed by this factor while all of them miss bends of the curve that are certain at this level (F-test
# of two coefficients more), so that a clean curve's own maximum is found and a noisy one's averaged,
NARROWER = 0.7
CERTAIN = 0.99
# but not one that is hardly higher than the noise,
MIN_NOISES = 3.0
# nor one in which the test would have fewer degrees of freedom left to part noise from bends.
MIN_SPARE = 6
MIN_SAMPLES = CUBIC + MORE + 1 + MIN_SPARE
# A first heating has passed B once the resistance is this part of the fall from B to C below its highest, and as many
# times the noise as a bump.
PASSED_FRACTION = 0.08
# Moves of a window around the maximum of the cubic through it: where the first one lies is still up to the noise.
MOVES = 2


class ResistanceMaximum(NamedTuple):
    """The maximum of a resistance that was sampled one after the other."""

    place: float  # in samples from the first one; between two samples as a rule
    resistance_ohm: float


def resistance_maximum(
    measured_ohm: FloatArray, smoothed_ohm: FloatArray, near: int, fall_ohm: float, noise_ohm: float
) -> ResistanceMaximum:
    """Return the maximum around a sample: that of the polynomial that suffices through the samples around it.

    ``fall_ohm`` is that from B to C, of which the widest window has a fraction; ``noise_ohm`` what smoothing has left.
    Without noise it is that of :func:`parabola_maximum`.
    """
    height_ohm = max(APEX_FRACTION * fall_ohm, BUMP_NOISES * noise_ohm)
    widest = above(smoothed_ohm, near, float(smoothed_ohm[near]) - height_ohm)
    window = widest
    while window.samples >= MIN_SAMPLES:
        window = moved(measured_ohm, window, widest, height_ohm)
        fits = _WindowPolynomials.through(measured_ohm, window)
        for order in ORDERS:
            found = fits.maximum(order)
            if found is not None and (height_ohm < MIN_NOISES * fits.noise_ohm(order) or fits.suffices(order)):
                return found
        height_ohm *= NARROWER
        middle = fits.maximum(CUBIC)
        window = narrower(window, near if middle is None else round(middle.place))
    return parabola_maximum(smoothed_ohm, near)


def first_maximum(resistance_ohm: FloatArray, fall_ohm: float, noise_ohm: float) -> ResistanceMaximum | None:
    """Return the maximum, B, of a wire's first heating, fast or slow; None if resistance has not fallen from one."""
    fallen = np.maximum.accumulate(resistance_ohm) - resistance_ohm
    passed = np.flatnonzero(fallen > max(PASSED_FRACTION * fall_ohm, BUMP_NOISES * noise_ohm))
    if not passed.size:
        return None
    until = resistance_ohm[: passed[0] + 1]
    return resistance_maximum(until, until, int(np.argmax(until)), fall_ohm, noise_ohm)


def parabola_maximum(resistance_ohm: FloatArray, peak: int) -> ResistanceMaximum:
    """Return the maximum of a curve without noise: the vertex of the parabola through a peak and its two neighbours."""
    at = float(resistance_ohm[peak])
    if not 0 < peak < resistance_ohm.size - 1:
        return ResistanceMaximum(float(peak), at)
    before, after = float(resistance_ohm[peak - 1]), float(resistance_ohm[peak + 1])
    bend = 2.0 * at - before - after
    if bend <= 0.0:
        return ResistanceMaximum(float(peak), at)
    shift = min(max(0.5 * (after - before) / bend, -0.5), 0.5)
    return ResistanceMaximum(peak + shift, at + 0.25 * shift * (after - before))


class SampleWindow(NamedTuple):
    """The samples ``first`` to ``last``, both included."""

    first: int
    last: int

    @property
    def samples(self) -> int:
        """How many there are."""
        return self.last - self.first + 1


class _WindowPolynomials(NamedTuple):
    """Polynomials of least squares through a window, by their parts in orthonormal ones, (10,) or fewer."""

    window: SampleWindow
    basis: FloatArray
    level_ohm: float
    parts_ohm: FloatArray
    squares: float

    @classmethod
    def through(cls, measured: FloatArray, window: SampleWindow) -> _WindowPolynomials:
        """Return the fits of all orders at once."""
        basis = orthonormal(window.samples)[0]
        values = measured[window.first : window.last + 1]
        level = float(values.mean())  # subtracted so that a small bend on a large level keeps its digits
        away = values - level
        return cls(window, basis, level, basis.T @ away, float(away @ away))

    def left(self, order: int) -> float:
        """Return the sum of squares that an order leaves of the samples."""
        return max(self.squares - float(np.sum(self.parts_ohm[: order + 1] ** 2)), 0.0)

    def spare(self, order: int) -> int:
        """Return the degrees of freedom that are left beyond a test of an order."""
        return self.window.samples - order - MORE - 1

    def noise_ohm(self, order: int) -> float:
        """Return the standard deviation that two coefficients more leave [ohm]; 0 with too few samples."""
        spare = self.spare(order)
        return sqrt(self.left(order + MORE) / spare) if spare >= MIN_SPARE else 0.0

    def suffices(self, order: int) -> bool:
        """Return whether two coefficients more follow the samples no better than noise lets them (F-test)."""
        spare = self.spare(order)
        if spare < MIN_SPARE:
            return False
        missed = float(np.sum(self.parts_ohm[order + 1 : order + MORE + 1] ** 2))
        return bool(missed <= MORE * fdtri(MORE, spare, CERTAIN) * self.noise_ohm(order) ** 2)

    def maximum(self, order: int) -> ResistanceMaximum | None:
        """Return the maximum of an order if it lies inside the window."""
        fitted = self.level_ohm + self.basis[:, : order + 1] @ self.parts_ohm[: order + 1]
        peak = int(np.argmax(fitted))
        if not 0 < peak < fitted.size - 1:
            return None
        found = parabola_maximum(fitted, peak)
        return found._replace(place=self.window.first + found.place)

    def cubic_at(self, places: FloatArray) -> FloatArray:
        """Return the cubic at places in samples, inside the window or not, of any shape."""
        middle, half = 0.5 * (self.window.first + self.window.last), 0.5 * (self.window.samples - 1)
        powers = orthonormal(self.window.samples)[1] @ self.parts_ohm[: CUBIC + 1]
        return np.asarray(self.level_ohm + np.polynomial.polynomial.polyval((places - middle) / half, powers))


@lru_cache(maxsize=32)
def orthonormal(samples: int) -> tuple[FloatArray, FloatArray]:
    """Return polynomials orthonormal on evenly spaced places, and the powers of a cubic from its parts in them.

    The first has shape (samples, n_orders), n_orders at most 10, the second (4, 4).
    """
    columns = min(HIGHEST + 1, samples)
    basis, triangle = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, samples), columns, increasing=True))
    return basis, np.linalg.inv(triangle[: CUBIC + 1, : CUBIC + 1])


def above(values: FloatArray, peak: int, level: float) -> SampleWindow:
    """Return the samples around a peak that lie above a level without a gap."""
    below = np.flatnonzero(values <= level)
    after = int(np.searchsorted(below, peak))
    first = int(below[after - 1]) + 1 if after > 0 else 0
    last = int(below[after]) - 1 if after < below.size else values.size - 1
    return SampleWindow(min(first, peak), max(last, peak))


def moved(measured: FloatArray, window: SampleWindow, widest: SampleWindow, height_ohm: float) -> SampleWindow:
    """Return the window in which the cubic through it is at most a height below its maximum."""
    for _ in range(MOVES):
        fits = _WindowPolynomials.through(measured, window)
        found = fits.maximum(CUBIC)
        if found is None:
            return window
        curve = fits.cubic_at(np.arange(widest.first, widest.last + 1, dtype=np.float64))
        part = above(curve, round(found.place) - widest.first, found.resistance_ohm - height_ohm)
        if part.samples < MIN_SAMPLES:
            return window
        window = SampleWindow(widest.first + part.first, widest.first + part.last)
    return window


def narrower(window: SampleWindow, middle: int) -> SampleWindow:
    """Return the samples of a window on both sides of one, by a part fewer on each."""
    before, after = int(NARROWER * (middle - window.first)), int(NARROWER * (window.last - middle))
    return SampleWindow(middle - before, middle + after)
