"""The wires that the benchmark compares with are what it says they are: each solves its equations."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.speed.compiled_wires import EXPLICIT_STEP_S, numba_cycle
from benchmarks.speed.easier_wire import PERIOD_S, START, ScipyLoop, drive_v, rates, scipy_cycle
from scipy.integrate import solve_ivp

SAMPLE_S = 0.05


@pytest.fixture(scope="module")
def converged() -> np.ndarray:
    """Temperature [K] and martensite along the slow sine, (2, n_samples), at tight tolerances of another method."""
    found = solve_ivp(
        lambda time_s, state: rates(state[0], state[1], drive_v(time_s)), (0.0, PERIOD_S), START,
        t_eval=np.arange(round(PERIOD_S / SAMPLE_S) + 1) * SAMPLE_S, method="Radau", rtol=1e-8, atol=1e-10,
    )  # fmt: skip
    return np.asarray(found.y)


def test_scipy_is_as_accurate_as_said(converged: np.ndarray) -> None:
    assert np.abs(scipy_cycle(SAMPLE_S).y[0] - converged[0]).max() < 0.010


@pytest.mark.parametrize(("step_s", "most_k"), [(EXPLICIT_STEP_S, 0.005), (5e-3, 0.05)])
def test_the_numba_loop_is_as_accurate_as_said(converged: np.ndarray, step_s: float, most_k: float) -> None:
    shown = numba_cycle(round(PERIOD_S / SAMPLE_S), round(SAMPLE_S / step_s))
    assert np.abs(shown - converged[0, 1:]).max() < most_k


def test_the_loop_that_is_called_for_each_period_follows_the_one_call(converged: np.ndarray) -> None:
    loop = ScipyLoop(SAMPLE_S)
    for sample in range(600):
        loop.advance(drive_v((sample + 0.5) * SAMPLE_S))
    assert loop.state[0] == pytest.approx(converged[0, 600], abs=0.05)
