from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from musclewire.wire.grains import signed_power, spread_grains
from scipy.stats import norm

from musclewire.errors import CallerError

SKEW = st.floats(-0.9, 0.9)
TAIL = st.floats(0.0, 2.0)


def test_without_skew_and_tail_the_grains_are_the_quantiles_of_a_normal_distribution() -> None:
    spread = spread_grains(40, 0.0, 0.0)
    inner_edges = norm.ppf(np.arange(1, 40) / 40)
    assert spread.edges[1:-1] == pytest.approx(inner_edges, abs=1e-12)


@settings(derandomize=True, deadline=None, max_examples=50)
@given(grains=st.integers(2, 300), skew=SKEW, tail=TAIL)
def test_grains_are_intervals_that_touch_and_rise(grains: int, skew: float, tail: float) -> None:
    spread = spread_grains(grains, skew, tail)
    assert spread.middle.shape == spread.width.shape == (grains,)
    assert (spread.width > 0.0).all()
    assert (np.diff(spread.middle) > 0.0).all()
    assert spread.edges == pytest.approx(
        np.append(spread.middle - spread.width / 2, spread.middle[-1] + spread.width[-1] / 2), abs=1e-9
    )


@settings(derandomize=True, deadline=None, max_examples=50)
@given(skew=SKEW, tail=TAIL)
def test_the_signed_power_always_rises_and_keeps_its_middle(skew: float, tail: float) -> None:
    z = np.linspace(-3.0, 3.0, 61)
    values = signed_power(z, skew, tail)
    # Next to zero a high power is flat to rounding, so rising is asked for from one step away.
    assert (np.diff(values) > 0.0).all()
    assert signed_power(np.zeros(1), skew, tail)[0] == 0.0


@pytest.mark.parametrize(("skew", "tail"), [(1.0, 0.0), (-1.0, 0.0), (0.0, -0.1), (0.0, float("nan"))])
def test_a_spread_that_would_fold_back_is_the_callers_error(skew: float, tail: float) -> None:
    with pytest.raises(CallerError, match="grain_tail"):
        signed_power(np.linspace(-1, 1, 3), skew, tail)


def test_one_grain_is_no_ensemble() -> None:
    with pytest.raises(CallerError, match="at least 2"):
        spread_grains(1, 0.0, 0.0)
