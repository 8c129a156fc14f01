"""The first-order lag and the local parabola's slope, against SciPy's filters and against what is known exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter, savgol_filter

from musclewire.sensing import lagged, smooth, smooth_slope


@given(st.floats(1e-4, 1.0), st.floats(-5.0, 5.0), st.integers(0, 2**31))
def test_a_lag_is_the_filter_of_first_order(gain: float, before: float, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=200)
    expected, _ = lfilter([gain], [1.0, gain - 1.0], values, zi=[(1.0 - gain) * before])
    np.testing.assert_allclose(lagged(values, gain, before), expected, rtol=0.0, atol=1e-11)


@given(st.integers(2, 20), st.integers(0, 2**31))
def test_smoothing_and_slope_are_those_of_savitzky_and_golay(half: int, seed: int) -> None:
    values, window = np.random.default_rng(seed).normal(size=120), 2 * half + 1
    np.testing.assert_allclose(smooth(values, window), savgol_filter(values, window, 2), atol=1e-11)
    np.testing.assert_allclose(smooth_slope(values, window), savgol_filter(values, window, 2, deriv=1), atol=1e-11)


@pytest.mark.parametrize("mark", [np.nan, 9.9e37])
def test_a_reading_that_is_none_spoils_its_own_window_alone(mark: float) -> None:
    values = np.random.default_rng(3).normal(size=120)
    marked = values.copy()
    marked[60] = mark
    away = np.abs(np.arange(120) - 60) > 4
    for smoothing in (smooth, smooth_slope):
        np.testing.assert_allclose(smoothing(marked, 7)[away], smoothing(values, 7)[away], atol=1e-11)


def test_a_parabola_keeps_its_slope_to_the_ends() -> None:
    places = np.arange(50.0)
    np.testing.assert_allclose(smooth_slope(0.1 * places**2 - places, 7), 0.2 * places - 1.0, atol=1e-10)
