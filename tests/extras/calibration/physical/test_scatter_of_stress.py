"""Isobars as a load cell shows them: the stress scatters about its mean, and may not move slowly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import RecordingError
from musclewire.extras.calibration._physical.isobaric import isobars_in
from musclewire.signals import Recording

ROWS = 200
TEMPERATURE_K = np.concatenate([np.linspace(300.0, 400.0, ROWS // 2), np.linspace(400.0, 300.0, ROWS // 2)])
STRAIN = 0.04 / (1.0 + np.exp(-(TEMPERATURE_K - 350.0) / 5.0))


def recorded(stress_pa: np.ndarray, times: int = 1) -> Recording:
    """Loops one after the other, with this stress in their rows."""
    return Recording(
        {
            "wire_temperature_k": np.tile(TEMPERATURE_K, times),
            "reference_strain": np.tile(STRAIN, times),
            "stress_pa": stress_pa,
        }
    )


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 10_000),
    scatter_pa=st.floats(0.0, 3e6),
    levels=st.lists(st.sampled_from([20e6, 50e6, 80e6, 100e6, 150e6, 200e6]), min_size=1, max_size=4, unique=True),
)
def test_stress_that_scatters_as_a_load_cell_does_is_one_isobar_for_each_level(
    seed: int, scatter_pa: float, levels: list[float]
) -> None:
    noise = np.random.default_rng(seed).normal(0.0, scatter_pa, ROWS * len(levels))
    found = isobars_in(recorded(np.repeat(levels, ROWS) + noise, len(levels)))
    assert [item.stress_pa for item in found] == pytest.approx(levels, abs=0.5 * scatter_pa + 1.0)
    # With scatter, the row of a step is found to a few rows.
    assert [item.strain.size for item in found] == pytest.approx([ROWS] * len(levels), abs=3 if scatter_pa else 0)


MOVING = {
    "a drift of a tenth": np.linspace(95e6, 105e6, ROWS),
    "a spring, which follows the wire": 100e6 + 1e9 * STRAIN,
    "a step back within the loop": np.repeat([100e6, 110e6, 100e6, 110e6], [15, 15, ROWS - 45, 15]),
}


@pytest.mark.parametrize("scatter_pa", [0.0, 1e6, 3e6])
@pytest.mark.parametrize("name", MOVING)
def test_stress_that_moves_slowly_is_refused(name: str, scatter_pa: float) -> None:
    noise = np.random.default_rng(7).normal(0.0, scatter_pa, ROWS)
    with pytest.raises(RecordingError, match=r"stress is not constant|stress changes at row"):
        isobars_in(recorded(MOVING[name] + noise))


def test_a_load_near_zero_may_scatter_below_it() -> None:
    noise = np.random.default_rng(3).normal(0.0, 3e6, ROWS)
    (found,) = isobars_in(recorded(5e6 + noise))
    assert found.stress_pa == pytest.approx(5e6, abs=1e6)
