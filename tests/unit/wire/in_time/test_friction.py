"""Friction of the guide: a loop shows what was asked for, and where the load cannot pull the wire back, friction holds.

`python benchmarks/kernel_accuracy.py --only friction` goes through all combinations of friction, presliding and step.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kernel_friction import Case, case_of, shown
from wire_makers import constants

from musclewire.wire import WireState, advance, fixed_steps, resting_state, spring_load, with_table


@pytest.mark.parametrize("step_s", [1e-3, 20e-3])
@pytest.mark.parametrize("presliding_m", [1e-6, 100e-6])
@pytest.mark.parametrize("friction_n", [0.01, 0.4, 1.0, 5.0])
def test_a_loop_shows_the_friction_that_was_asked_for(friction_n: float, presliding_m: float, step_s: float) -> None:
    found = shown(case_of(friction_n, presliding_m), step_s)
    assert found.stroke_m > 1e-3, "the wire must move to show anything"
    assert found.samples > 100
    assert found.pulling == pytest.approx(1.0, rel=0.02)
    assert found.easing == pytest.approx(1.0, rel=0.02)
    assert found.worst < 0.02


def cycle(case: Case, step_s: float, turns: int) -> list[WireState]:
    """Return the states after each step of slow cycles, one drive a step."""
    times = np.arange(0.0, 60.0 * turns, step_s) + 0.5 * step_s
    at = 0.1 * np.arange(0.5, case.drive_v.size)
    state, visited = resting_state(case.constants), []
    for volts in np.interp(times % 60.0, at, case.drive_v).tolist():
        state, _ = advance(state, case.constants, volts, step_s, fixed_steps(step_s))
        visited.append(state)
    return visited


@pytest.mark.parametrize(("friction_n", "presliding_m"), [(0.05, 20e-6), (0.5, 100e-6), (1.0, 1e-6)])
def test_the_energy_that_friction_takes_in_a_cycle_is_the_area_of_the_loop(
    friction_n: float, presliding_m: float
) -> None:
    """Three ways: the area of force over displacement, sliding times friction, and the area of the parallelogram."""
    case = case_of(friction_n, presliding_m)
    visited = cycle(case, 0.02, 2)[3000 - 1 :]
    k = case.constants
    x = np.array([state.connector_contraction for state in visited]) * k.leg_length_m
    force = np.array([state.stress_pa for state in visited]) * k.legs * k.area_m2
    friction = np.array([state.friction_n for state in visited])
    area_j = float(np.trapezoid(force, x)) - 0.5 * k.spring_stiffness_n_per_m * (x[-1] ** 2 - x[0] ** 2)
    area_j -= k.pretension_n * (x[-1] - x[0])
    # What friction takes is its work less what its elastic part still holds.
    held_j = 0.5 * presliding_m / friction_n * (friction[-1] ** 2 - friction[0] ** 2)
    slid_m = np.abs(np.diff(x)) - np.abs(np.diff(friction)) * presliding_m / friction_n
    assert area_j - held_j == pytest.approx(friction_n * slid_m.sum(), rel=2e-3)
    assert area_j == pytest.approx(2.0 * friction_n * (np.ptp(x) - 2.0 * presliding_m), rel=5e-3)


def load_n(case: Case, state: WireState) -> float:
    """Return what the load without friction asks where the connector is."""
    k = case.constants
    return k.pretension_n + k.spring_stiffness_n_per_m * state.connector_contraction * k.leg_length_m


@pytest.mark.parametrize("step_s", [1e-3, 20e-3])
@pytest.mark.parametrize("presliding_m", [1e-6, 100e-6])
def test_where_the_load_cannot_pull_the_wire_back_friction_holds_it_between_both_limits(
    presliding_m: float, step_s: float
) -> None:
    """Friction of 2 N against a pretension of 1.5 N and a soft spring: up it goes, and stays up."""
    k = constants(
        load=spring_load(100.0),
        bench_values={"pretension_n": 1.0, "guide_friction_n": 2.0, "guide_presliding_m": presliding_m},
    )
    case = Case(k, np.zeros(0), 2.0, presliding_m)
    state, stepping, top = resting_state(k), fixed_steps(step_s), 0.0
    for volts in [3.4] * 100 + [0.0] * 200 + [3.4] * 100 + [0.0] * 200:
        state, means = advance(state, k, volts, 0.04, stepping)
        pulled_n = state.stress_pa * k.legs * k.area_m2
        asked_n = load_n(case, state)
        assert asked_n - 2.0 - 1e-6 <= pulled_n <= asked_n + 2.0 + 1e-6
        assert abs(state.friction_n) <= 2.0
        assert means.force_n >= 0.0
        assert state.slack >= 0.0
        top = max(top, state.connector_contraction * k.leg_length_m)
        moved = state.connector_contraction * k.leg_length_m
    assert top > 1e-3, "the wire must have pulled the connector up"
    assert moved > top - 2.0 * presliding_m - 1e-6, "and there it stays"
    assert state.stress_pa == 0.0
    assert state.slack * k.leg_length_m > 0.5e-3, "cold, the wire hangs loose"
    assert state.unsolved_steps == 0


@pytest.mark.parametrize("friction_n", [0.0, 0.05, 1.0])
@pytest.mark.parametrize("step_s", [1e-3, 50e-3])
def test_at_rest_it_stays_at_rest(friction_n: float, step_s: float) -> None:
    """Cold and without current nothing moves to the bit; held hot nothing creeps, whatever friction was left there."""
    k = constants(bench_values={"guide_friction_n": friction_n})
    cold = start = resting_state(k)
    for _ in range(20):
        cold, _ = advance(cold, k, 0.0, 1.0, fixed_steps(step_s))
    assert cold.temperature_k == pytest.approx(start.temperature_k, abs=1e-9)
    assert cold.connector_contraction == pytest.approx(0.0, abs=1e-12)
    assert cold.friction_n == pytest.approx(0.0, abs=1e-9)
    hot, _ = advance(start, k, 3.0, 5.0, fixed_steps(step_s))
    hot, _ = advance(hot, k, 2.2, 30.0, fixed_steps(step_s))
    later, _ = advance(hot, k, 2.2, 300.0, fixed_steps(step_s))
    assert 0.05 < hot.martensite_fraction < 0.95, "amid its transformation"
    assert later.temperature_k == pytest.approx(hot.temperature_k, abs=1e-6)
    assert later.friction_n == pytest.approx(hot.friction_n, abs=1e-6)
    assert later.connector_contraction == pytest.approx(hot.connector_contraction, abs=1e-9)


@pytest.mark.slow
@given(
    friction_n=st.floats(0.0, 5.0),
    presliding_m=st.floats(1e-6, 1e-4),
    pretension_n=st.floats(0.0, 4.0),
    stiffness_n_per_m=st.floats(0.0, 5e3),
    slope=st.floats(-50.0, 200.0),
    history=st.lists(st.tuples(st.floats(0.0, 3.6), st.integers(1, 60)), min_size=1, max_size=8),
    step_s=st.sampled_from([1e-3, 5e-3, 20e-3]),
)
def test_any_friction_is_solved_and_never_above_its_limit(
    friction_n: float,
    presliding_m: float,
    pretension_n: float,
    stiffness_n_per_m: float,
    slope: float,
    history: list[tuple[float, int]],
    step_s: float,
) -> None:
    """Guide and load rub together; the load's friction falls or rises with displacement."""
    load = with_table(
        stiffness_n_per_m, np.zeros_like, lambda x: np.maximum(0.02 + slope * x, 0.0), reach_m=5e-3, points=501
    )
    k = constants(
        load=load,
        bench_values={
            "guide_friction_n": friction_n,
            "guide_presliding_m": presliding_m,
            "pretension_n": pretension_n,
        },
    )
    state = resting_state(k)
    for volts, samples in history:
        state, means = advance(state, k, volts, 0.02 * samples, fixed_steps(step_s))
        x = state.connector_contraction * k.leg_length_m
        limit_n = friction_n + max(float(np.interp(x, load.step_m * np.arange(501), load.friction_n)), 0.0)
        assert abs(state.friction_n) <= limit_n + 1e-9
        assert state.slack >= 0.0
        assert np.isfinite(means[:4]).all()
        if state.stress_pa > 0.0:
            asked_n = pretension_n + stiffness_n_per_m * x + state.friction_n
            assert state.stress_pa * k.legs * k.area_m2 == pytest.approx(asked_n, abs=1e-4)
    assert state.unsolved_steps == 0
