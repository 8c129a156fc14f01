"""The local parabola, against SciPy's filter and against what is known exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import savgol_filter

from musclewire.sensing import smooth


@given(st.integers(2, 20), st.integers(0, 2**31))
def test_smoothing_is_that_of_savitzky_and_golay(half: int, seed: int) -> None:
    values, window = np.random.default_rng(seed).normal(size=120), 2 * half + 1
    np.testing.assert_allclose(smooth(values, window), savgol_filter(values, window, 2), atol=1e-11)


@pytest.mark.parametrize("mark", [np.nan, 9.9e37])
def test_a_reading_that_is_none_spoils_its_own_window_alone(mark: float) -> None:
    values = np.random.default_rng(3).normal(size=120)
    marked = values.copy()
    marked[60] = mark
    away = np.abs(np.arange(120) - 60) > 4
    np.testing.assert_allclose(smooth(marked, 7)[away], smooth(values, 7)[away], atol=1e-11)
