"""A few steps of two wires that meet, from the middle of their transformation: Newton's, Kirchhoff's and energy's laws.

Short enough for plain Python, as ``test_single_steps.py``; whole cycles are in ``test_pairs.py``.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from test_pairs import (
    ALONG_N_PER_M,
    BESIDE_N_PER_M,
    CLEARANCE_M,
    FOAM_N_PER_M,
    GIVE_M_PER_N,
    LEVER,
    RATIO,
    Case,
    finger_load,
    grip,
    moved_m,
    pulls_n,
    thick,
    wire,
)
from wire_makers import stored_heat_j

from musclewire.extras.grip._coupling import SEPARATE, no_grip
from musclewire.extras.grip._pairs import OWN_SUPPLY, PARALLEL, SERIES, PairConnection, PairMeans, advance_pair
from musclewire.wire import StepControl, WireState, advance, fixed_steps, resting_state, spring_load

TEN_MS = fixed_steps(0.01)
RUB_N = 0.2
UNLIKE = {
    "parallel": Case((wire(spring_load(800.0)), thick()), PairConnection(1.0, PARALLEL, 0.0, 1.0), no_grip()),
    "antagonists": Case(
        (wire(spring_load(200.0), guide_friction_n=RUB_N), thick()),
        PairConnection(-1.0, OWN_SUPPLY, 1.2, 1.5),
        no_grip(),
    ),
    "grip": Case((wire(finger_load()), thick(finger_load(), 1.1)), PairConnection(SEPARATE, SERIES, 0.0, 1.0), grip()),
}
DRIVE_V = {"parallel": 4.5, "antagonists": 3.2, "grip": 5.5}
HEATED_S = {"parallel": 0.5, "antagonists": 0.5, "grip": 1.0}
names = pytest.mark.parametrize("name", sorted(UNLIKE))
ways = pytest.mark.parametrize("heated", [True, False], ids=["heated", "cooled"])


@cache
def in_the_middle(name: str) -> tuple[WireState, WireState]:
    """Return both wires on their way, with martensite and austenite in the first one."""
    both, pair, between = UNLIKE[name]
    states = resting_state(both[0]), resting_state(both[1])
    states, _ = advance_pair(states, both, pair, between, DRIVE_V[name], HEATED_S[name], TEN_MS)
    assert 0.05 < states[0].martensite_fraction < 0.9
    return states


def after(
    name: str, heated: bool, duration_s: float, stepping: StepControl
) -> tuple[tuple[WireState, WireState], PairMeans]:
    """Return both wires and the means some time later, heated on or left to cool."""
    both, pair, between = UNLIKE[name]
    return advance_pair(
        in_the_middle(name), both, pair, between, DRIVE_V[name] if heated else 0.4, duration_s, stepping
    )


def currents_a(name: str, states: tuple[WireState, WireState], drive_v: float) -> tuple[np.ndarray, float, float]:
    """Return both wires' currents, the voltage across the terminals and the current through the shunt, by Kirchhoff."""
    both, pair, _ = UNLIKE[name]
    ohm = np.array([state.resistance_ohm for state in states])
    series_ohm = both[0].series_resistance_ohm
    if pair.feed == SERIES:
        current = drive_v / (ohm.sum() + series_ohm)
        return np.array([current, current]), current * ohm.sum(), current
    if pair.feed == PARALLEL:
        matrix = [[ohm[0] + series_ohm, series_ohm], [series_ohm, ohm[1] + series_ohm]]
        found = np.linalg.solve(matrix, [drive_v, drive_v])
        return found, found[0] * ohm[0], found.sum()
    own = drive_v / (ohm[0] + series_ohm)
    return np.array([own, pair.second_voltage_v / (ohm[1] + pair.second_series_ohm)]), own * ohm[0], own


@pytest.mark.slow
@names
@ways
def test_one_step_of_a_pair_keeps_energy_and_its_means_are_those_of_both_ends(name: str, heated: bool) -> None:
    both, _, _ = UNLIKE[name]
    before = in_the_middle(name)
    now, means = after(name, heated, 0.01, TEN_MS)
    drive_v = DRIVE_V[name] if heated else 0.4
    ends = [currents_a(name, states, drive_v) for states in (before, now)]
    assert means.wire_voltage_v == pytest.approx(np.mean([volts for _, volts, _ in ends]), rel=1e-9)
    through = np.mean([current for _, _, current in ends])
    assert means.shunt_voltage_v == pytest.approx(both[0].shunt_resistance_ohm * through, rel=1e-9)
    for place, (was, state, of) in enumerate(zip(before, now, both, strict=True)):
        power_w = [
            end[0][place] ** 2 * pair_state.resistance_ohm for end, pair_state in zip(ends, (was, state), strict=True)
        ]
        assert state.heat_in_j - was.heat_in_j == pytest.approx(0.01 * np.mean(power_w), rel=1e-9)
        gained_j = state.enthalpy_j + state.carried_heat_j - was.enthalpy_j - was.carried_heat_j
        net_j = (state.heat_in_j - was.heat_in_j) - (state.heat_out_j - was.heat_out_j)
        assert gained_j == pytest.approx(net_j, abs=1e-13)
        assert state.enthalpy_j == pytest.approx(stored_heat_j(state, of), abs=1e-12)
        assert state.unsolved_steps == 0.0
    forces = [np.mean([pulls_n(pair[place], both[place]) for pair in (before, now)]) for place in (0, 1)]
    assert (means.force_n, means.second_force_n) == pytest.approx(tuple(forces), rel=1e-9)


@ways
def test_wires_on_one_connector_balance_its_load(heated: bool) -> None:
    for name, sign, stiffness in (("parallel", 1.0, 800.0), ("antagonists", -1.0, 200.0)):
        both, pair, _ = UNLIKE[name]
        (first, second), means = after(name, heated, 0.05, TEN_MS)
        x_m = moved_m(first, both[0])
        assert moved_m(second, both[1]) == pytest.approx(sign * x_m, abs=1e-9)
        assert means.second_displacement_m == pytest.approx(sign * means.displacement_m, rel=1e-12)
        pretension_n = both[0].pretension_n + sign * both[1].pretension_n
        load_n = pretension_n + stiffness * x_m + first.friction_n
        assert pulls_n(first, both[0]) + sign * pulls_n(second, both[1]) == pytest.approx(load_n, abs=1e-7)
        assert pair.direction == sign
        assert (second.friction_n, abs(first.friction_n) <= RUB_N) == (0.0, True)


@ways
def test_two_unlike_fingers_are_pushed_alike_by_what_they_hold(heated: bool) -> None:
    both, _, _ = UNLIKE["grip"]
    states, means = after("grip", heated, 0.05, TEN_MS)
    pushes = []
    for state, of in zip(states, both, strict=True):
        x_m = moved_m(state, of)
        pushes.append(
            (pulls_n(state, of) - of.pretension_n - BESIDE_N_PER_M * x_m - ALONG_N_PER_M * max(x_m, 0.0)) / LEVER
        )
    closed_m = RATIO * sum(moved_m(state, of) for state, of in zip(states, both, strict=True)) - CLEARANCE_M
    assert closed_m > 1e-4, "the fingers must hold it"
    soft = FOAM_N_PER_M / (1.0 + 2.0 * FOAM_N_PER_M * GIVE_M_PER_N)
    assert pushes == pytest.approx([soft * closed_m] * 2, abs=1e-6)
    assert means.grip_n == pytest.approx(pushes[0], rel=0.05)


def numbers(states: tuple[WireState, WireState]) -> np.ndarray:
    """Return temperature [K], contraction in per mille and resistance [ohm] of both."""
    return np.array([(one.temperature_k, 1e3 * one.contraction, one.resistance_ohm) for one in states]).reshape(-1)


@names
@ways
def test_half_the_step_of_a_pair_leaves_a_quarter_of_the_error(name: str, heated: bool) -> None:
    finest = numbers(after(name, heated, 0.08, fixed_steps(5e-4))[0])
    coarse, fine = (np.abs(numbers(after(name, heated, 0.08, fixed_steps(step))[0]) - finest) for step in (0.02, 0.005))
    assert np.linalg.norm(fine) < 0.25 * np.linalg.norm(coarse) + 1e-4
    assert (fine < [0.05, 0.02, 5e-3] * 2).all(), fine


@names
@ways
def test_chosen_steps_of_a_pair_keep_their_tolerance(name: str, heated: bool) -> None:
    finest = numbers(after(name, heated, 0.08, fixed_steps(5e-4))[0])
    tight = StepControl(temperature_k=5e-5, resistance=1e3, strain=1e3)
    found, _ = after(name, heated, 0.08, tight)
    assert np.abs(numbers(found) - finest)[::3].max() < 5e-3
    loose, _ = after(name, heated, 0.08, StepControl(temperature_k=1e3, resistance=1e3, strain=1e3))
    assert sum(one.evaluations for one in found) > sum(one.evaluations for one in loose)
    for changed in ({"resistance": 1e-6}, {"strain": 3e-7}):
        stepping = StepControl(**{"temperature_k": 1e3, "resistance": 1e3, "strain": 1e3, **changed})
        finer, _ = after(name, heated, 0.08, stepping)
        assert sum(one.evaluations for one in finer) > sum(one.evaluations for one in loose)
        assert np.linalg.norm(numbers(finer) - finest) < np.linalg.norm(numbers(loose) - finest) + 1e-4


def test_a_pair_that_shares_nothing_steps_like_two_single_wires_to_the_bit() -> None:
    both = (wire(spring_load(588.6)), thick(spring_load(300.0)))
    states = alone = (resting_state(both[0]), resting_state(both[1]))
    for own_v, other_v in ((3.5, 4.5), (3.5, 0.5), (0.3, 4.5)):
        pair = PairConnection(SEPARATE, OWN_SUPPLY, other_v, both[1].series_resistance_ohm)
        for stepping in (TEN_MS, StepControl()):
            states, means = advance_pair(states, both, pair, no_grip(), own_v, 0.2, stepping)
            if stepping is TEN_MS:
                first, mean = advance(alone[0], both[0], own_v, 0.2, stepping)
                second, other = advance(alone[1], both[1], other_v, 0.2, stepping)
                for together, single in zip(states, (first, second), strict=True):
                    assert together.row.tobytes() == single.row.tobytes()
                assert (means.displacement_m, means.force_n) == pytest.approx((mean.displacement_m, mean.force_n))
                partner = (means.second_displacement_m, means.second_force_n)
                assert partner == pytest.approx((other.displacement_m, other.force_n))
        alone = states


def test_equal_wires_on_one_connector_share_pretension_and_spring() -> None:
    both = (wire(spring_load(800.0)), wire())
    half = wire(spring_load(400.0), shunt_resistance_ohm=2.0)
    states, single = (resting_state(both[0]), resting_state(both[1])), resting_state(half)
    for drive_v in (4.0, 4.0, 4.0, 0.3):
        states, means = advance_pair(
            states, both, PairConnection(1.0, PARALLEL, 0.0, 1.0), no_grip(), drive_v, 0.15, fixed_steps(5e-3)
        )
        single, mean = advance(single, half, drive_v, 0.15, fixed_steps(5e-3))
        assert states[0].temperature_k == pytest.approx(single.temperature_k, abs=0.02)
        assert states[0].contraction == pytest.approx(states[1].contraction, abs=1e-9)
        assert states[0].contraction == pytest.approx(single.contraction, abs=2e-5)
        assert means.force_n + means.second_force_n == pytest.approx(2.0 * mean.force_n, rel=1e-3)
