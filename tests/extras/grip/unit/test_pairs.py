"""Two wires that meet, held to one wire done by hand, to Newton's laws and to Kirchhoff's."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_makers import Array, alloy, bench, changed, constants, slow_sine_v, stored_heat_j, wire_100um

from grain_wire import Grip as GrainGrip
from grain_wire import Pair as GrainPair
from grain_wire import drive_pair as grain_wire_pair
from grain_wire import grain_wire
from musclewire.extras.grip._coupling import SEPARATE, GrippedObject, no_grip
from musclewire.extras.grip._pairs import OWN_SUPPLY, PARALLEL, SERIES, PairConnection, PairMeans, advance_pair
from musclewire.wire import (
    ConnectorLoad,
    WireConstants,
    WireState,
    constants_from,
    fixed_steps,
    resting_state,
    spring_load,
    with_pretension,
    with_table,
)

pytestmark = pytest.mark.slow

SMOOTH = {"guide_friction_n": 0.0}
ALONE = spring_load(0.0)
MS = fixed_steps(1e-3)
CYCLE_V = [slow_sine_v(t) for t in np.arange(0.05, 90.0, 0.1)]
States = tuple[WireState, WireState]
Both = tuple[WireConstants, WireConstants]

# A finger of round numbers: 6 mm of endpoint for 1 mm of tendon, a newton at the endpoint is 5 N at the tendon and
# takes 2 mm away; 1000 N/m along the tendon beside a pretensioner of 400 N/m.
RATIO, LEVER, GIVE_M_PER_N, ALONG_N_PER_M, BESIDE_N_PER_M = 6.0, 5.0, 2e-3, 1000.0, 400.0
FOAM_N_PER_M, CLEARANCE_M = 150.0, 3e-3
REACH_M, POINTS = 7e-3, 2001  # as many as a rig's finger has: the kernel of two wires is compiled for it once


def wire(load: ConnectorLoad = ALONE, pretension_n: float = 0.9, **bench_values: float) -> WireConstants:
    return constants(load=load, bench_values={**SMOOTH, "pretension_n": pretension_n, **bench_values})


def thick(load: ConnectorLoad = ALONE, pretension_n: float = 0.9) -> WireConstants:
    """Return a wire of twice the section, otherwise the same."""
    spool = changed(wire_100um(), diameter_m=100e-6 * 2**0.5)
    return constants_from(alloy(), spool, bench(**SMOOTH, pretension_n=pretension_n), load=load)


def at_rest(both: Both) -> States:
    return resting_state(both[0]), resting_state(both[1])


def course(
    both: Both,
    pair: PairConnection,
    voltages_v: list[float],
    grip: GrippedObject | None = None,
    *,
    dt_s: float = 1e-3,
    hold_s: float = 0.1,
) -> tuple[list[States], list[PairMeans]]:
    """Hold each voltage for a while; return states and means after each."""
    states, visited, means = at_rest(both), [], []
    for voltage in voltages_v:
        states, mean = advance_pair(states, both, pair, grip or no_grip(), voltage, hold_s, fixed_steps(dt_s))
        visited.append(states)
        means.append(mean)
    return visited, means


def pulls_n(state: WireState, of: WireConstants) -> float:
    return state.stress_pa * of.legs * of.area_m2


def moved_m(state: WireState, of: WireConstants) -> float:
    return state.contraction * of.leg_length_m


def finger_load(contact_n_per_m: float = 0.0, clearance_m: float = 0.0) -> ConnectorLoad:
    """Return finger and pretensioner, with an object in the endpoint's way."""

    def force_n(x: Array) -> Array:
        inside = np.maximum(RATIO * x - clearance_m, 0.0)
        return ALONG_N_PER_M * x + LEVER * contact_n_per_m * inside / (1.0 + contact_n_per_m * GIVE_M_PER_N)

    return with_table(BESIDE_N_PER_M, force_n, np.zeros_like, reach_m=REACH_M, points=POINTS)


def grip(stiffness_n_per_m: float = FOAM_N_PER_M, give_m_per_n: float = GIVE_M_PER_N) -> GrippedObject:
    x = np.linspace(0.0, REACH_M, POINTS)
    return GrippedObject(
        stiffness_n_per_m, CLEARANCE_M, float(x[1]), RATIO * x, give_m_per_n + 0.0 * x, LEVER + 0.0 * x
    )


class Case(NamedTuple):
    both: Both
    pair: PairConnection
    grip: GrippedObject


CASES = {
    "parallel": Case((wire(spring_load(800.0)), wire()), PairConnection(1.0, PARALLEL, 0.0, 1.0), no_grip()),
    "antagonist": Case((wire(spring_load(200.0)), wire()), PairConnection(-1.0, OWN_SUPPLY, 1.5, 1.0), no_grip()),
    "grip": Case((wire(finger_load()), wire(finger_load())), PairConnection(SEPARATE, SERIES, 0.0, 1.0), grip()),
}


@pytest.mark.parametrize("name", sorted(CASES))
def test_the_states_given_are_left_as_they_were(name: str) -> None:
    both, pair, between = CASES[name]
    states = course(both, pair, CYCLE_V[:300], between)[0][-1]
    before = [{name: np.copy(item) for name, item in state.values().items()} for state in states]
    advance_pair(states, both, pair, between, 3.0, 2.0, MS)
    for state, old in zip(states, before, strict=True):
        for field, item in state.values().items():
            assert np.array_equal(item, old[field]), field


@pytest.mark.parametrize("name", sorted(CASES))
def test_a_run_cut_in_two_is_the_run_in_one_to_the_bit(name: str) -> None:
    both, pair, between = CASES[name]
    whole = halves = at_rest(both)
    for voltage in CYCLE_V[::3]:
        whole, _ = advance_pair(whole, both, pair, between, voltage, 0.2, MS)
        halves, _ = advance_pair(halves, both, pair, between, voltage, 0.077, MS)
        halves, _ = advance_pair(halves, both, pair, between, voltage, 0.123, MS)
    for one, same in zip(whole, halves, strict=True):
        # The clock alone is a sum of other numbers.
        clocks = {"time_s": 0.0}
        assert one.time_s == pytest.approx(same.time_s, rel=1e-12)
        assert one.replace(**clocks).row.tobytes() == same.replace(**clocks).row.tobytes()


@pytest.mark.parametrize("hot_first", [False, True])
def test_a_cold_wire_beside_a_hot_one_goes_slack_and_the_other_carries_all(hot_first: bool) -> None:
    """Each on a supply of its own, one left cold: the connector follows the wire that pulls."""
    both = (wire(spring_load(300.0), 0.3), wire(ALONE, 0.3))
    own_v, other_v = (3.2, 0.0) if hot_first else (0.0, 3.2)
    visited, means = course(both, PairConnection(1.0, OWN_SUPPLY, other_v, 1.0), [own_v] * 80)
    hot, cold = (0, 1) if hot_first else (1, 0)
    end, mean = visited[-1], means[-1]
    assert end[cold].stress_pa == 0.0
    assert mean.displacement_m > 1e-3
    assert mean.displacement_m == mean.second_displacement_m
    assert mean.displacement_m == pytest.approx(moved_m(end[hot], both[hot]), rel=1e-6)
    assert pulls_n(end[hot], both[hot]) == pytest.approx(0.6 + 300.0 * mean.displacement_m, rel=1e-6)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(
    name=st.sampled_from(sorted(CASES)),
    pretensions_n=st.tuples(st.floats(0.2, 2.5), st.floats(0.2, 2.5)),
    partner_v=st.floats(0.0, 3.0),
    history=st.lists(st.tuples(st.floats(0.0, 3.2), st.integers(1, 1500)), min_size=1, max_size=8),
)
def test_every_history_keeps_shares_energy_and_no_wire_pushes(
    name: str, pretensions_n: tuple[float, float], partner_v: float, history: list[tuple[float, int]]
) -> None:
    given_wires, pair, between = CASES[name]
    both = (with_pretension(given_wires[0], pretensions_n[0]), with_pretension(given_wires[1], pretensions_n[1]))
    pair = pair._replace(second_voltage_v=partner_v)
    states = start = at_rest(both)
    taken = 0
    for voltage, steps in history:
        taken += steps
        states, means = advance_pair(states, both, pair, between, voltage, 1e-3 * steps, MS)
        assert all(np.isfinite(means))
        assert means.grip_n >= 0.0
        for state, first, of in zip(states, start, both, strict=True):
            assert state.stress_pa >= 0.0
            assert state.unsolved_steps == 0.0
            assert (state.front_austenite <= state.front_martensite).all()
            assert min(state.martensite_fraction, state.r_phase_fraction) >= -1e-12
            assert state.martensite_fraction + state.r_phase_fraction <= 1.0 + 1e-12
            kept = state.heat_in_j - state.heat_out_j - state.carried_heat_j
            # Each step adds its heat to the enthalpy, and may lose half of the enthalpy's last digit.
            rounding_j = 0.5 * taken * np.spacing(abs(state.enthalpy_j)) + 1e-12 * state.heat_in_j
            assert state.enthalpy_j - first.enthalpy_j == pytest.approx(kept, rel=0.0, abs=rounding_j)
            assert state.enthalpy_j == pytest.approx(stored_heat_j(state, of), abs=1e-12 * of.latent_heat_j)


def test_antagonists_that_rub_cool_from_a_rest_without_a_jump() -> None:
    """After a long rest a hot wire is switched off: stress falls with temperature, in every millisecond a little."""
    both = (wire(spring_load(400.0), guide_friction_n=0.1), wire())
    pair = PairConnection(-1.0, OWN_SUPPLY, 0.0, 1.0)
    states = course(both, pair, [3.0] * 90)[0][-1]
    stresses = [states[0].stress_pa]
    for _ in range(1500):
        states, _ = advance_pair(states, both, pair, no_grip(), 0.3, 1e-3, MS)
        stresses.append(states[0].stress_pa)
    assert stresses[0] > 1.5e8
    assert stresses[-1] < 0.5 * stresses[0]
    assert np.abs(np.diff(stresses)).max() < 0.05 * stresses[0]


def test_slack_antagonists_without_pretension_come_tight_where_one_pulls() -> None:
    both = (wire(pretension_n=0.0), wire(pretension_n=0.0))
    visited, means = course(both, PairConnection(-1.0, OWN_SUPPLY, 0.0, 1.0), [3.0] * 60)
    assert means[-1].displacement_m > 1e-4
    first, second = visited[-1]
    assert pulls_n(first, both[0]) == pytest.approx(pulls_n(second, both[1]), abs=1e-6)
    assert first.stress_pa > 1e7


STIFF = {
    "antagonist on a wall": Case(
        (wire(spring_load(1e6)), wire()), PairConnection(-1.0, OWN_SUPPLY, 2.5, 1.0), no_grip()
    ),
    "strong antagonist": Case(
        (wire(spring_load(100.0)), thick()), PairConnection(-1.0, OWN_SUPPLY, 2.8, 1.0), no_grip()
    ),
    "steel between fingers": Case(
        (wire(finger_load()), thick(finger_load())), PairConnection(SEPARATE, OWN_SUPPLY, 2.6, 1.0), grip(1e7, 0.0)
    ),
    "steel between soft fingers": Case(
        (wire(finger_load()), wire(finger_load())), PairConnection(SEPARATE, SERIES, 0.0, 1.0), grip(1e7)
    ),
}


@pytest.mark.parametrize("name", sorted(STIFF))
def test_what_is_stiff_leaves_no_step_unsolved(name: str) -> None:
    """Jumps of the drive in steps of 20 ms, which overshoot into contact; finer ones end at the same place."""
    both, pair, between = STIFF[name]
    volts = list(np.repeat((0.3, 4.0, 0.3, 6.0, 2.0), 15) * (2.0 if pair.feed == SERIES else 1.0))
    coarse, means = course(both, pair, volts, between, dt_s=20e-3)
    fine, _ = course(both, pair, volts, between, dt_s=1e-3)
    assert [state.unsolved_steps for state in (*coarse[-1], *fine[-1])] == [0.0] * 4
    for state, same in zip(coarse[-1], fine[-1], strict=True):
        assert state.temperature_k == pytest.approx(same.temperature_k, abs=0.05)
    if pair.direction == SEPARATE:
        assert max(mean.grip_n for mean in means) > 0.2, "the fingers must have held it"


RUBBING = Case(
    (wire(spring_load(400.0), guide_friction_n=0.3), wire()), PairConnection(-1.0, OWN_SUPPLY, 0.0, 1.0), no_grip()
)


@pytest.mark.parametrize("dt_s", [1e-3, 10e-3])
def test_the_guides_friction_of_a_pair_shows_in_full_in_its_balance_of_force(dt_s: float) -> None:
    """Which is met in each step; a connector that slides feels all of the friction, against its motion."""
    both, pair, between = RUBBING
    visited, _ = course(both, pair, CYCLE_V, between, dt_s=dt_s)
    places = np.array([first.connector_contraction for first, _ in visited]) * both[0].leg_length_m
    rubbed = []
    for sample, (first, second) in enumerate(visited):
        beyond = pulls_n(first, both[0]) - pulls_n(second, both[1]) - 400.0 * places[sample]
        assert beyond == pytest.approx(first.friction_n, abs=1e-7)
        moves = np.diff(places[max(sample - 30, 0) : sample + 1])
        if abs(moves.sum()) > 2.0 * both[0].friction_presliding_m and (np.sign(moves) == np.sign(moves[0])).all():
            rubbed.append(first.friction_n * np.sign(moves[0]))
    assert len(rubbed) > 20
    assert rubbed == pytest.approx([0.3] * len(rubbed), abs=1e-12)


@pytest.mark.parametrize("name", sorted(CASES))
def test_the_grains_of_the_reference_stepped_finely_agree(name: str) -> None:
    """``tests/grain_wire``: other numerics, of first order in time and with many grains."""
    both, pair, between = CASES[name]
    loads = {"parallel": (800.0, 0.0), "antagonist": (200.0, 0.0)}
    attached = [spring_load(k) for k in loads[name]] if name in loads else [finger_load(), finger_load()]
    around = bench(**SMOOTH, pretension_n=0.9).values()
    grains = [grain_wire(alloy().values(), wire_100um().values(), around, load=load, grains=1280) for load in attached]
    factor = 2.0 if pair.feed == SERIES else 1.0
    volts = factor * np.repeat((0.5, 3.0, 0.3), (10, 40, 60))
    found = grain_wire_pair(*grains, GrainPair(*pair), GrainGrip(*between), volts, 1e-4, 400).T
    states, seen = at_rest(both), []
    for voltage in volts:
        states, means = advance_pair(states, both, pair, between, voltage, 0.04, fixed_steps(2e-3))
        seen.append(means)
    far = np.abs(found - np.array(seen)).max(axis=0)
    assert (far[:2] < 1e-6).all(), far  # V
    assert (far[[2, 4]] < 2e-7).all(), far  # m
    assert (far[[3, 5, 6]] < 1e-3).all(), far  # N
