"""Loads that are no straight line: what the wire pulls must be what it feels, at every moment and to what accuracy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from wire_makers import Array, constants, run, slow_sine_v, stepped

from musclewire.errors import CallerError
from musclewire.parameters import load_alloy, load_bench, load_wire, published_ranges
from musclewire.wire._building import constants_from, resting_state
from musclewire.wire._constants import WireConstants
from musclewire.wire._loads import ConnectorLoad, spring_load, with_table
from musclewire.wire._state import WireState
from musclewire.wire._step import NO_PUSH, load_at

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


def load_n(load: ConnectorLoad, displacement_m: float) -> float:
    """Return what a load asks beyond the pretension, from its table by NumPy."""
    at = load.step_m * np.arange(load.force_n.size)
    return load.stiffness_n_per_m * displacement_m + float(np.interp(displacement_m, at, load.force_n))


def missing_n(state: WireState, wire: WireConstants, load: ConnectorLoad, friction_n: float) -> float:
    """Return F_T - F_p - k x - table(x) - friction, of numbers that the state shows."""
    pulled_n = state.stress_pa * wire.legs * wire.area_m2
    return pulled_n - wire.pretension_n - load_n(load, state.contraction * wire.leg_length_m) - friction_n


def balanced_stress_pa(state: WireState, wire: WireConstants, load: ConnectorLoad, friction_n: float) -> float:
    """Solve strain and balance, both written out, for the stress of one leg."""
    x_m, x_r = state.martensite_fraction, state.r_phase_fraction

    def excess_pa(stress: float) -> float:
        reoriented = wire.strain_saturated + (wire.strain_at_no_stress - wire.strain_saturated) * np.exp(
            -stress / wire.strain_stress_scale_pa
        )
        elastic = stress * ((1 - x_m) / wire.austenite_modulus_pa + x_m / wire.martensite_modulus_pa)
        alpha = x_m * wire.martensite_expansion_per_k + (1 - x_m) * wire.austenite_expansion_per_k
        strain = reoriented * x_m + wire.r_phase_strain * x_r + elastic + alpha * (state.temperature_k - 293.15)
        x = (wire.cold_strain - strain) / (1 + wire.cold_strain) * wire.leg_length_m
        return stress - (wire.pretension_n + load_n(load, x) + friction_n) / (wire.legs * wire.area_m2)

    return float(brentq(excess_pa, 0.0, 5e9, xtol=1e-3))


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


def test_a_table_that_is_a_straight_line_goes_the_way_of_a_spring_through_a_cycle() -> None:
    """A hanging load differs in one thing: it does not push a wire that thermal expansion makes longer."""
    spring, line = constants(load=spring_load(588.6)), constants(load=tabulated(0.0, lambda x: 588.6 * x))
    ours, theirs = (run(resting_state(wire), wire, CYCLE_V)[0] for wire in (line, spring))
    far = [abs(one.contraction - other.contraction) for one, other in zip(ours, theirs, strict=True)]
    assert max(state.contraction for state in theirs) > 0.03
    assert max(far) < 1e-4
    assert float(np.median(far)) < 1e-9


def test_a_weight_is_one_force_whatever_the_wire_does() -> None:
    wire = constants(load=spring_load(0.0), bench_values={**SMOOTH, "pretension_n": 1.4})
    states, means = run(resting_state(wire), wire, CYCLE_V)
    assert max(state.contraction for state in states) > 0.03
    assert [state.stress_pa for state in states] == pytest.approx([0.7 / wire.area_m2] * len(states), rel=1e-12)
    assert [mean.force_n for mean in means] == pytest.approx([1.4] * len(means), rel=1e-12)


@pytest.mark.parametrize("name", sorted(LOADS))
def test_after_every_step_wire_and_load_are_in_balance(name: str) -> None:
    """Against the balance solved anew by bisection: 1e-8 of the stress, on a kink 1e-6."""
    wire, load = WIRES[name], LOADS[name]
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
    transformed = end.martensite_fraction + wire.r_phase_entropy_ratio * end.r_phase_fraction
    held = wire.heat_capacity_j_per_k * (end.temperature_k - 293.15) - wire.latent_heat_j * transformed
    assert end.enthalpy_j == pytest.approx(held, abs=1e-13 * wire.latent_heat_j)


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


def test_a_slack_tendon_adds_its_stiffness_where_it_becomes_tight() -> None:
    slack_m, before, after = 0.7e-3, 400.0, 1900.0
    wire = constants(load=LOADS["slack"], bench_values=SMOOTH)
    means = run(resting_state(wire), wire, CYCLE_V)[1]
    x, force = np.array([mean.displacement_m for mean in means]), np.array([mean.force_n for mean in means])
    for inside, slope in (((x > 0.05e-3) & (x < slack_m - 1e-5), before), (x > slack_m + 1e-5, after)):
        assert inside.sum() > 20
        assert float(np.polyfit(x[inside], force[inside], 1)[0]) == pytest.approx(slope, rel=1e-4)
    tight = x > slack_m
    assert force[tight] == pytest.approx(
        wire.pretension_n + before * x[tight] + 1500.0 * (x[tight] - slack_m), abs=1e-3
    )


def test_sliding_friction_of_the_load_separates_pulling_from_easing_by_twice_itself() -> None:
    """Friction 0.05 N and 40 N/m of it: the force at one displacement, going up and coming down."""
    load = tabulated(588.6, nothing, lambda x: 0.05 + 40.0 * x)
    wire = constants(load=load, bench_values=SMOOTH)
    states = run(resting_state(wire), wire, CYCLE_V * 2)[0][len(CYCLE_V) :]
    x = np.array([state.contraction * wire.leg_length_m for state in states])
    force = np.array([state.stress_pa * wire.legs * wire.area_m2 for state in states])
    top = int(x.argmax())
    places = np.linspace(0.6e-3, x.max() - 0.3e-3, 9)
    pulling = np.interp(places, x[:top], force[:top])
    easing = np.interp(places, x[:top:-1], force[:top:-1])
    assert pulling - easing == pytest.approx(2.0 * (0.05 + 40.0 * places), rel=0.01)


def test_before_its_table_a_load_keeps_its_force_and_behind_it_the_last_slope() -> None:
    load = with_table(0.0, lambda x: 0.5 + 100.0 * x + 1e5 * x**2, lambda x: 0.1 + x, reach_m=1e-3, points=11)
    wire = constants(load=load, bench_values=SMOOTH)
    derived, _, tables = wire.step_arrays()

    def at(displacement_m: float) -> tuple[float, float, float]:
        """Return force [N], stiffness [N/m] and limit of friction [N] where nothing has moved, so that nothing rubs."""
        contraction = displacement_m / wire.leg_length_m
        point = load_at(derived[0], tables[0], contraction, (contraction, 0.0), NO_PUSH)
        assert point.friction_n == 0.0
        elastic_n_per_m = point.limit_n / wire.friction_presliding_m
        return (
            point.force_n - wire.pretension_n,
            point.per_contraction_n / wire.leg_length_m - elastic_n_per_m,
            point.limit_n,
        )

    force, slope, _ = at(-1e-3)
    assert force == pytest.approx(0.5)
    assert slope == pytest.approx(0.0, abs=1e-6)
    force, slope, _ = at(2e-3)
    last = (load.force_n[-1] - load.force_n[-2]) / 1e-4
    assert slope == pytest.approx(last)
    assert force == pytest.approx(load.force_n[-1] + last * 1e-3)
    for x, friction in ((-1e-3, 0.1), (0.5e-3, 0.1005), (5e-3, 0.101)):
        assert at(x)[2] == pytest.approx(friction)


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
