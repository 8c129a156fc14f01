"""Loads that are no straight line: what the wire pulls must be what it feels, at every moment and to what accuracy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_makers import (
    ALLOYS,
    Array,
    balanced_stress_pa,
    constants,
    load_n,
    run,
    slow_sine_v,
    stepped,
    stored_heat_j,
)

from musclewire.errors import CallerError
from musclewire.parameters import load_alloy, load_bench, load_wire, published_ranges
from musclewire.wire import (
    ConnectorLoad,
    WireConstants,
    WireState,
    constants_from,
    resting_state,
    spring_load,
    with_table,
)

REACH_M = 7e-3
SMOOTH = {"guide_friction_n": 0.0}
CYCLE_V = [slow_sine_v(t) for t in np.arange(0.025, 90.0, 0.05)]


def nothing(displacement_m: Array) -> Array:
    return np.zeros_like(displacement_m)


def tabulated(
    stiffness_n_per_m: float, force_n: Callable[[Array], Array], friction_n: Callable[[Array], Array] = nothing
) -> ConnectorLoad:
    return with_table(stiffness_n_per_m, force_n, friction_n, reach_m=REACH_M)


def hook(slack_m: float, stiffness_n_per_m: float) -> Callable[[Array], Array]:
    """Return a spring that begins to pull only after some displacement."""
    return lambda x: stiffness_n_per_m * np.maximum(x - slack_m, 0.0)


LOADS = {
    "hardening": tabulated(300.0, lambda x: 2e5 * x**2, lambda x: 0.02 + 20.0 * x),
    "softening": tabulated(0.0, lambda x: 2.0 * (1.0 - np.exp(-x / 1e-3))),
    "slack": tabulated(400.0, hook(0.7e-3, 1500.0)),
    "wall": tabulated(500.0, hook(1.0e-3, 2e5)),
    "mount": spring_load(1e6),
    "weight": spring_load(0.0),
}
WIRES = {name: constants(load=load) for name, load in LOADS.items()}


def missing_n(state: WireState, wire: WireConstants, load: ConnectorLoad, friction_n: float) -> float:
    """Return F_T - F_p - k x - table(x) - friction, of numbers that the state shows."""
    pulled_n = state.stress_pa * wire.legs * wire.area_m2
    return pulled_n - wire.pretension_n - load_n(load, state.contraction * wire.leg_length_m) - friction_n


def test_a_table_that_is_a_straight_line_is_a_spring_step_by_step_to_rounding() -> None:
    """From one and the same state: over a run, the predictions would blow up the last bit (test_advance.py)."""
    spring = constants(load=spring_load(588.6))
    line = constants(load=tabulated(0.0, lambda x: 588.6 * x))
    half = constants(load=tabulated(300.0, lambda x: 288.6 * x))
    state, compared = resting_state(spring), 0
    for voltage in CYCLE_V[::5]:
        state, _ = stepped(state, spring, voltage, 1e-3, 249)
        for other in (line, half) if state.contraction > 1e-5 else ():
            after, _ = stepped(state, spring, voltage, 1e-3, 1)
            same, _ = stepped(state, other, voltage, 1e-3, 1)
            assert same.stress_pa == pytest.approx(after.stress_pa, rel=1e-11)
            assert same.contraction == pytest.approx(after.contraction, rel=1e-11)
            assert same.resistance_ohm == pytest.approx(after.resistance_ohm, rel=1e-11)
            compared += 1
    assert compared > 300


def test_a_weight_is_one_force_whatever_the_wire_does() -> None:
    wire = constants(load=spring_load(0.0), bench_values={**SMOOTH, "pretension_n": 1.4})
    states, means = run(resting_state(wire), wire, CYCLE_V)
    assert max(state.contraction for state in states) > 0.03
    assert [state.stress_pa for state in states] == pytest.approx([0.7 / wire.area_m2] * len(states), rel=1e-12)
    assert [mean.force_n for mean in means] == pytest.approx([1.4] * len(means), rel=1e-12)


BALANCED = {name: (WIRES[name], load) for name, load in LOADS.items()}
BALANCED |= {kind: (constants(kind, load=spring_load(588.6)), spring_load(588.6)) for kind in ALLOYS}


@pytest.mark.parametrize("name", sorted(BALANCED))
def test_after_every_step_wire_and_load_are_in_balance(name: str) -> None:
    """Against the balance solved anew by bisection: 1e-8 of the stress, on a kink 1e-6."""
    wire, load = BALANCED[name]
    state, wrong, moments = resting_state(wire), [], 0
    for voltage in CYCLE_V[::3]:
        state, _ = stepped(state, wire, voltage, 1e-3, 150)
        exact = balanced_stress_pa(state, wire, load, state.friction_n)
        wrong.append(abs(state.stress_pa / exact - 1.0))
        moments += state.contraction > 1e-3
    assert moments > 100 or name == "mount"
    assert np.quantile(wrong, 0.98) < 1e-8
    assert max(wrong) < 1e-6


@settings(derandomize=True, deadline=None, max_examples=40)
@given(
    points=st.lists(st.floats(0.0, 1.0), min_size=3, max_size=8),
    stiffness_n_per_m=st.floats(0.0, 2000.0),
    friction_n=st.floats(0.0, 0.1),
    history=st.lists(st.tuples(st.floats(0.0, 3.4), st.integers(20, 1500)), min_size=1, max_size=8),
)
def test_any_load_that_rises_keeps_wire_and_load_in_balance_and_the_shares_shares(
    points: list[float], stiffness_n_per_m: float, friction_n: float, history: list[tuple[float, int]]
) -> None:
    """Any table that never falls, up to 3 N of it over the whole stroke, with friction."""
    rising = np.cumsum(points) / max(sum(points), 1.0) * 3.0
    at = np.linspace(0.0, 3e-3, rising.size)
    load = tabulated(stiffness_n_per_m, lambda x: np.interp(x, at, rising), lambda x: friction_n + 0.0 * x)
    wire = constants(load=load)
    # What the load begins with is part of its force, as it is of a rig's pretension.
    state = run(resting_state(wire), wire, [0.0])[0][-1]
    for voltage, steps in history:
        state, _ = stepped(state, wire, voltage, 1e-3, steps)
        assert abs(missing_n(state, wire, load, state.friction_n)) < 1e-5
        assert min(state.martensite_fraction, state.r_phase_fraction) >= -1e-9
        assert state.martensite_fraction + state.r_phase_fraction <= 1.0 + 1e-9
        assert state.unsolved_steps == 0


@pytest.mark.parametrize("name", ["hardening", "slack", "wall", "mount"])
def test_over_slow_cycles_the_heat_account_is_closed_to_rounding_on_any_load(name: str) -> None:
    wire = WIRES[name]
    start = resting_state(wire)
    end = run(start, wire, CYCLE_V * 2)[0][-1]
    assert end.heat_in_j > 10.0 * wire.latent_heat_j, "little heat went through: this would show little"
    supplied_j = end.heat_in_j - end.heat_out_j - end.carried_heat_j
    assert supplied_j == pytest.approx(end.enthalpy_j - start.enthalpy_j, abs=1e-11 * end.heat_in_j)
    assert end.enthalpy_j == pytest.approx(stored_heat_j(end, wire), abs=1e-13 * wire.latent_heat_j)


# Grains that are all alike and turn from martensite to austenite with nothing between.
ALIKE = {
    "martensite_spread_k": 0.05,
    "martensite_spread_per_pa": 0.0,
    "martensite_barrier_per_pa": 0.0,
    "r_phase_temperature_k": 250.0,
    "r_phase_spread_k": 0.05,
}


@pytest.mark.parametrize("rate_pa_per_k", [8e6, load_alloy("flexinol").martensite_stress_rate_pa_per_k.value])
def test_a_blocked_wires_stress_rises_by_clausius_and_clapeyron_within_the_published_range(
    rate_pa_per_k: float,
) -> None:
    """Held at both ends and heated slowly: what transforms keeps the stress at which it just can.

    Real grains differ, and the width of the hysteresis changes with stress, so that a real wire's slope is another.
    """
    wire = constants(
        load=spring_load(1e6),
        bench_values={**SMOOTH, "pretension_n": 0.7},
        martensite_stress_rate_pa_per_k=rate_pa_per_k,
        **ALIKE,
    )
    states = run(resting_state(wire), wire, list(np.linspace(0.3, 3.4, 3000)))[0]
    assert max(state.contraction for state in states) * wire.leg_length_m < 5e-6, "the mount gives by microns"
    rising = [state for state in states if 0.82 < state.martensite_fraction < 0.97]
    stress, temperature = (np.array([getattr(at, name) for at in rising]) for name in ("stress_pa", "temperature_k"))
    slope = float(np.polyfit(temperature, stress, 1)[0])
    assert slope == pytest.approx(rate_pa_per_k, rel=0.01)
    printed = published_ranges().parameters["martensite_stress_rate_pa_per_k"]
    assert printed.low < slope < printed.high


def test_a_load_that_is_no_number_or_reaches_nowhere_is_refused() -> None:
    with pytest.raises(CallerError, match="must reach further"):
        with_table(1.0, nothing, nothing, reach_m=0.0)
    with pytest.raises(CallerError, match="not finite somewhere between 0 and 7 mm"):
        tabulated(1.0, lambda x: np.where(x > 1e-3, np.nan, 0.0))


@pytest.mark.parametrize("presliding_m", [1e-7, 1e-6, 1e-4])
def test_friction_of_the_load_is_what_was_asked_whatever_the_presliding_travel(presliding_m: float) -> None:
    wire = constants(load=LOADS["hardening"], bench_values={**SMOOTH, "guide_presliding_m": presliding_m})
    states = run(resting_state(wire), wire, CYCLE_V)[0]
    x = np.array([state.connector_contraction * wire.leg_length_m for state in states])
    friction = np.array([state.friction_n for state in states])
    top = int(x.argmax())
    turned_m = x[top] - 2.0 * presliding_m - 0.1e-3
    for part, sign in ((slice(0, top), 1.0), (slice(top, None), -1.0)):
        sliding = (x[part] > 0.5e-3) & (x[part] < turned_m)
        assert sliding.sum() > 50
        assert friction[part][sliding] == pytest.approx(sign * (0.02 + 20.0 * x[part][sliding]), rel=1e-6)


@pytest.mark.parametrize("stiffness_n_per_m", [1e3, 1e6, 1e7])
def test_a_wall_of_any_stiffness_is_met_without_a_jump_and_alike_by_long_and_short_steps(
    stiffness_n_per_m: float,
) -> None:
    """A step that a kink throws far out would come back far in: at 1e6 N/m it was 15.7 N instead of 5.2."""
    load = tabulated(386.2, hook(0.4e-3, stiffness_n_per_m))
    wire = constants_from(load_alloy("flexinol"), load_wire("finger-100um"), load_bench("finger"), load=load)
    largest = []
    for dt_s in (1e-3, 2e-4):
        state, force = resting_state(wire), []
        for sample in range(300):
            state, means = stepped(state, wire, 1.75 if 20 < sample < 200 else 0.3, dt_s, round(0.05 / dt_s))
            force.append(means.force_n)
        largest.append(max(force))
    assert largest[0] == pytest.approx(largest[1], rel=0.05)
