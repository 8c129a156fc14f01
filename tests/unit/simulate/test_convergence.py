"""Finer steps and more grains lead to one answer, at the pace that the scheme promises."""

from __future__ import annotations

import numpy as np
import pytest
from wire_makers import Array, constants, run, slow_sine_v

from musclewire.simulate.wire import resting_state

# A cycle of 90 s as in the paper, held in pieces of 40 ms so that every step length divides them.
HOLD_S = 0.04
CYCLE_V = np.array([slow_sine_v(t) for t in np.arange(HOLD_S / 2, 90.0, HOLD_S)])


def loop(dt_s: float, grains: int) -> Array:
    """Return strain and resistance relative to the cold wire's, every 0.4 s, (n_times, 2)."""
    wire = constants(bench_values={"grains": float(grains)})
    start = resting_state(wire)
    states, _ = run(start, wire, CYCLE_V, dt_s=dt_s, hold_s=HOLD_S)
    return np.array([(s.contraction, s.resistance_ohm / start.resistance_ohm) for s in states[9::10]])


def distances(loops: list[Array], reference: Array) -> Array:
    """Return the root mean square distances of strain and of resistance, (n_loops, 2)."""
    return np.array([np.sqrt(np.mean((item - reference) ** 2, axis=0)) for item in loops])


def test_halving_the_time_step_about_halves_the_error() -> None:
    """Order one: against 0.25 ms, ratios of 2.1 and 2.3 are due; steps at switching grains blur them."""
    errors = distances([loop(dt, 160) for dt in (4e-3, 2e-3, 1e-3)], loop(2.5e-4, 160))
    ratios = errors[:-1] / errors[1:]
    assert ((ratios > 1.5) & (ratios < 3.0)).all(), ratios
    assert errors[-1, 0] < 1e-4, "at the default step the strain must be right to a hundredth of a percent"


def test_more_grains_lead_to_one_loop() -> None:
    errors = distances([loop(1e-3, grains) for grains in (40, 80, 160)], loop(1e-3, 640))
    assert (errors[1:] < errors[:-1]).all(), errors
    assert errors[-1, 0] == pytest.approx(0.0, abs=1e-4)
