"""The memory of the fronts, as the Preisach literature defines it: wiping-out and congruency.

Mayergoyz 1986, doi 10.1103/PhysRevLett.56.1518: an operator is a Preisach operator if and only if it has both. Closed
nested loops and an excursion from cold are in test_fronts_along_temperature_walks.py; here whole histories of turning
points, at constant stress and at constant temperature. `python benchmarks/hysteresis_memory.py` prints the largest
departures over thousands of histories.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hysteresis_memory import HOT_K, WIRES, along, minor_loop, remembered
from wire_makers import Array, fronts_along, fronts_at

KINDS = st.sampled_from(sorted(WIRES))
STRESSES_PA = st.floats(20e6, 250e6)
TEMPERATURES_K = st.floats(295.0, 410.0)
LOADS_PA = st.floats(0.0, 400e6)
# Of what is remembered not a bit differs; differences of fractions along two loops are off by their last place.
ROUNDING = 1e-12


@pytest.mark.parametrize(
    ("turns", "left"),
    [
        ([9, 1, 5], [9, 1, 5]),
        ([9, 5, 3, 1], [9, 1]),  # the same way on
        ([9, 1, 5, 3, 4], [9, 1, 5, 3, 4]),  # ever smaller loops: all of them matter
        ([9, 1, 5, 3, 6], [9, 1, 6]),  # beyond 5: the loop from 5 to 3 is gone
        ([9, 1, 5, 3, 4, 2], [9, 1, 5, 2]),
        ([9, 1, 5, 3, 5], [9, 1, 5]),  # closed
        ([9, 4, 6, 1], [9, 1]),
        ([9, 4, 9], [9, 4, 9]),  # the start is a state of its own: nothing wipes out what left it
    ],
)
def test_a_larger_excursion_wipes_out_the_smaller_ones_before_it(turns: list[float], left: list[float]) -> None:
    assert remembered(turns) == left


@settings(max_examples=150)
@given(kind=KINDS, stress_pa=STRESSES_PA, turns=st.lists(TEMPERATURES_K, min_size=2, max_size=14))
def test_at_constant_stress_only_the_dominant_turning_points_are_remembered(
    kind: str, stress_pa: float, turns: list[float]
) -> None:
    history = [HOT_K, *turns]
    whole = along(WIRES[kind], stress_pa, history)[:, -1]
    assert np.array_equal(whole, along(WIRES[kind], stress_pa, remembered(history))[:, -1])


def fronts_after_loads(kind: str, temperature_k: float, loads_pa: list[float]) -> Array:
    """Return both fronts, cooled without load and then taken through loads, (2,)."""
    wire = WIRES[kind]
    return fronts_along(wire, temperature_k, loads_pa, fronts_at(wire, temperature_k, 0.0))[:2, -1]


@settings(max_examples=150)
@given(kind=KINDS, temperature_k=st.floats(300.0, 390.0), turns=st.lists(LOADS_PA, min_size=2, max_size=14))
def test_at_constant_temperature_only_the_dominant_loads_are_remembered(
    kind: str, temperature_k: float, turns: list[float]
) -> None:
    whole = fronts_after_loads(kind, temperature_k, turns)
    left = fronts_after_loads(kind, temperature_k, remembered([0.0, *turns])[1:])
    assert np.array_equal(whole, left)


@settings(max_examples=80)
@given(kind=KINDS, stress_pa=STRESSES_PA, turns=st.lists(TEMPERATURES_K, min_size=1, max_size=6), seed=st.integers(0))
def test_what_is_remembered_depends_on_turning_points_and_not_on_the_steps_between(
    kind: str, stress_pa: float, turns: list[float], seed: int
) -> None:
    """Rate independence: in one jump from turn to turn as in any number of steps of any size."""
    random = np.random.default_rng(seed)
    stepped, before = [HOT_K], HOT_K
    for turn in turns:
        stepped += [*(before + (turn - before) * np.sort(random.random(random.integers(0, 30)))), turn]
        before = turn
    jumped = along(WIRES[kind], stress_pa, [HOT_K, *turns])[:, -1]
    assert np.array_equal(along(WIRES[kind], stress_pa, stepped)[:, -1], jumped)


@settings(max_examples=150)
@given(
    stress_pa=STRESSES_PA,
    ends_k=st.tuples(TEMPERATURES_K, TEMPERATURES_K),
    one=st.lists(TEMPERATURES_K, min_size=1, max_size=6),
    other=st.lists(TEMPERATURES_K, min_size=1, max_size=6),
)
def test_with_two_phases_minor_loops_between_the_same_temperatures_are_congruent(
    stress_pa: float, ends_k: tuple[float, float], one: list[float], other: list[float]
) -> None:
    """The fraction of martensite, that is; strain is no sum of relays, as expansion and stiffness differ by phase."""
    low_k, high_k = sorted(ends_k)
    assume(high_k > low_k)
    loops = [minor_loop(WIRES["two phases"], stress_pa, history, low_k, high_k) for history in (one, other)]
    assert np.abs(loops[0][0] - loops[1][0]).max() <= ROUNDING
    assert abs(loops[0][0][-1]) <= ROUNDING, "the loop must close"
    assert np.abs(loops[0][2] - loops[1][2]).max() < 1e-4


def test_with_two_phases_a_loop_narrower_than_the_hysteresis_moves_nothing() -> None:
    """All grains have the same width of hysteresis, 2 h: a play. A loop must be wider before any grain goes round."""
    wire, stress_pa = WIRES["two phases"], 100e6
    width_k = 2.0 * (wire.martensite_barrier_k + wire.martensite_barrier_per_pa * stress_pa)
    history, low_k = (345.0,), 335.0
    narrow = minor_loop(wire, stress_pa, history, low_k, low_k + 0.99 * width_k)
    wide = minor_loop(wire, stress_pa, history, low_k, low_k + 1.5 * width_k)
    assert np.abs(narrow[0]).max() <= ROUNDING
    assert np.abs(wide[0]).max() > 0.1


def test_with_r_phase_minor_loops_close_but_are_not_congruent() -> None:
    """No defect: a grain of three phases is no relay, and the theorem does not hold for it.

    Between the same two temperatures R-phase comes and goes only in grains that history did not leave as martensite.
    """
    wire, stress_pa, low_k, high_k = WIRES["broad"], 50e6, 338.0, 352.0
    from_hot = minor_loop(wire, stress_pa, (HOT_K,), low_k, high_k)
    from_cold = minor_loop(wire, stress_pa, (295.0,), low_k, high_k)
    for loop in (from_hot, from_cold):
        assert np.abs(loop[:, -1]).max() <= ROUNDING
    assert np.ptp(from_hot[1]) > np.ptp(from_cold[1]) + 0.1
