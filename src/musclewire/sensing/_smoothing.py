"""Noise of a sampled curve, and smoothers that leave a curve without noise unchanged."""

from __future__ import annotations

from math import sqrt

import numpy as np

from musclewire.arrays import FloatArray

# Smoothing suffices when the remaining noise is this fraction of the span of the curve.
NOISE_GOAL = 1e-3
# A local parabola over w samples leaves about sqrt(2.25 / w) of the noise in the middle of the window.
PARABOLA_VARIANCE = 2.25
MIN_WINDOW = 5
# Standard deviation of a fourth difference of unit white noise: sqrt(1 + 16 + 36 + 16 + 1).
FOURTH_DIFFERENCE_STD = sqrt(70.0)
MEDIAN_TO_STD = 0.6744897501960817


def noise_level(values: FloatArray, weights: FloatArray | None = None) -> float:
    """Estimate the standard deviation of white noise on a smooth curve; 0 for fewer than 9 values.

    The median of fourth differences ignores steps and slow bends of the curve; jitter of the sampling counts as noise.
    ``weights`` are factors of each value's noise, where it is not the same everywhere.
    """
    if values.size < 9:
        return 0.0
    differences = np.diff(values, n=4) * (1.0 if weights is None else weights[2:-2])
    spread = median_of(np.abs(differences - median_of(differences)))
    return spread / MEDIAN_TO_STD / FOURTH_DIFFERENCE_STD


def median_of(values: FloatArray) -> float:
    """Return the number of ``numpy.median``, in a third of its time for some thousand values."""
    middle = values.size // 2
    ordered = np.partition(values, (middle - 1, middle, values.size - 1))
    if np.isnan(ordered[-1]):  # NaN is the largest of all
        return float(np.nan)
    return float(ordered[middle]) if values.size % 2 else float(0.5 * (ordered[middle - 1] + ordered[middle]))


def smoothing_window(noise: float, span: float, max_window: int) -> int:
    """Return the odd number of samples to smooth over, so that noise falls to 0.1 % of ``span``; 1 for no smoothing."""
    if noise <= 0.0 or span <= 0.0:
        return 1
    window = int(min(PARABOLA_VARIANCE * (noise / (NOISE_GOAL * span)) ** 2, max_window))
    if window < MIN_WINDOW:
        return 1
    return window if window % 2 else window - 1


def smoothed_noise(noise: float, window: int) -> float:
    """Return the noise that remains after ``smooth`` with this window."""
    return noise if window == 1 else noise * sqrt(PARABOLA_VARIANCE / window)


def centred_mean(values: FloatArray, samples: int) -> FloatArray:
    """Return the mean around each value, over fewer near the ends."""
    reach = samples // 2
    total = np.concatenate([[0.0], np.cumsum(values)])
    place = np.arange(values.size)
    first, after = np.maximum(place - reach, 0), np.minimum(place + reach + 1, values.size)
    return np.asarray((total[after] - total[first]) / (after - first))


def smooth(values: FloatArray, window: int) -> FloatArray:
    """Replace samples by local parabolas' values (Savitzky-Golay), at each end by one parabola of half a window."""
    if window == 1 or values.size < window:
        return values
    half = window // 2
    offset = np.arange(-half, half + 1, dtype=np.float64)
    norm = (2 * half + 3) * (2 * half + 1) * (2 * half - 1)
    kernel = 3.0 * (3 * half * half + 3 * half - 1 - 5 * offset**2) / norm
    # Subtracted so that a small ripple on a large level keeps its digits; a reading that is none, or an overload mark,
    # spoils its own window and not the level.
    level = float(np.median(values[np.isfinite(values)])) if np.isfinite(values).any() else 0.0
    centred = values - level
    result = np.empty_like(values)
    result[half:-half] = np.convolve(centred, kernel, mode="valid")
    basis = np.vander(offset / half, 3)
    project = basis @ np.linalg.pinv(basis)
    result[:half] = (project @ centred[:window])[:half]
    result[-half:] = (project @ centred[-window:])[-half:]
    return result + level
