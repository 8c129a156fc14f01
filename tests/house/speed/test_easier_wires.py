"""The wires that the benchmark compares with are what it says they are: each solves its equations."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.speed.compiled_wires import EXPLICIT_STEP_S, numba_batch, numba_cycle
from benchmarks.speed.easier_wire import PERIOD_S, START, ScipyLoop, drive_v, rates, scipy_cycle
from benchmarks.speed.numpy_wires import numpy_batch
from benchmarks.speed.plain_grains import GrainWire
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


def test_the_easier_wire_transforms_and_returns_and_scipy_is_as_accurate_as_said(converged: np.ndarray) -> None:
    martensite = converged[1]
    assert martensite.min() < 0.01
    assert martensite[-1] > 0.99
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


def test_the_grains_in_plain_python_transform_and_remember() -> None:
    wire = GrainWire()
    shown = []
    for number in range(18_000):
        wire.advance(drive_v(5e-3 * number), 5e-3)
        shown.append((wire.temperature_k, wire.martensite))
    kelvin, martensite = np.transpose(shown)
    assert martensite.min() < 0.05
    assert martensite[-1] > 0.95
    warm = [martensite[half][np.argmin(np.abs(kelvin[half] - 365.0))] for half in (slice(9000), slice(9000, None))]
    assert warm[0] > warm[1] + 0.3


def test_many_wires_go_as_one_in_numpy_as_in_numba() -> None:
    voltages = np.linspace(0.5, 3.5, 7)
    both = [(np.full(7, START[0]), np.full(7, START[1])) for _ in range(2)]
    for run, state in zip((numba_batch, numpy_batch), both, strict=True):
        run(*state, voltages, 6000)
    np.testing.assert_allclose(both[0], both[1], rtol=1e-9)
    assert both[0][1].min() < 0.1 < 0.9 < both[0][1].max()
    loop = ScipyLoop(6.0)
    loop.advance(voltages[3])
    assert (both[0][0][3], both[0][1][3]) == pytest.approx(loop.state, abs=0.05)
