"""The fronts at constant stress: what every walk must keep. `benchmarks/kernel_walks.py` has them beside grains."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_makers import (
    ALL_AUSTENITE,
    ALLOYS,
    Fronts,
    constants,
    fractions,
    fronts_at,
    walk,
)

from musclewire.wire._constants import WireConstants

WIRES = {kind: constants(kind) for kind in ALLOYS}
KINDS = st.sampled_from(sorted(ALLOYS))
STRESSES_PA = st.floats(20e6, 250e6)
EIGHTHS_OF_A_KELVIN = st.integers(295 * 8, 410 * 8)
HOT_K, COLD_K = 430.0, 290.0


def assert_shares(fronts: Fronts, wire: WireConstants) -> None:
    martensite, r_phase = fractions(wire, fronts)
    assert fronts.austenite <= fronts.martensite, "the fronts may meet and never cross"
    # A cubic may miss by some units of the last place, 2.2e-16.
    assert martensite >= -1e-15
    assert r_phase >= -1e-15
    assert martensite + r_phase <= 1.0 + 1e-15


@settings(derandomize=True, deadline=None, max_examples=60)
@given(
    kind=KINDS,
    seed=st.integers(0, 2**32 - 1),
    path=st.lists(st.tuples(st.floats(200.0, 600.0), st.floats(0.0, 800e6)), min_size=1, max_size=30),
)
def test_shares_stay_shares_whatever_the_state_and_the_walk(
    kind: str, seed: int, path: list[tuple[float, float]]
) -> None:
    """From any two fronts, by jumps of any size in temperature and stress."""
    wire = WIRES[kind]
    fronts = Fronts(*np.sort(np.random.default_rng(seed).normal(0.0, 3.0, 2)).tolist())
    for temperature, stress in path:
        fronts = fronts_at(wire, temperature, stress, fronts)
        assert_shares(fronts, wire)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(kind=KINDS, stress_pa=STRESSES_PA, start=EIGHTHS_OF_A_KELVIN, end=EIGHTHS_OF_A_KELVIN)
def test_cooling_adds_martensite_and_heating_takes_it(kind: str, stress_pa: float, start: int, end: int) -> None:
    wire = WIRES[kind]
    before = walk(wire, ALL_AUSTENITE, stress_pa, HOT_K, 320.0, start / 8)[-1]
    after = walk(wire, before, stress_pa, start / 8, end / 8)[-1]
    # Both fronts go one way, so every grain does.
    if end < start:
        assert after.martensite <= before.martensite
        assert after.austenite <= before.austenite
    else:
        assert after.martensite >= before.martensite
        assert after.austenite >= before.austenite


@pytest.mark.parametrize("kind", sorted(ALLOYS))
@pytest.mark.parametrize("stress_pa", [0.0, 120e6])
def test_all_is_martensite_far_below_and_austenite_far_above(kind: str, stress_pa: float) -> None:
    """Far is where the last grain of the longest tail has changed: below 0 K, were the equations to hold there."""
    wire = WIRES[kind]
    cold = fronts_at(wire, -500.0, stress_pa)
    assert fractions(wire, cold) == (1.0, 0.0)
    assert fractions(wire, fronts_at(wire, 1500.0, stress_pa, cold)) == (0.0, 0.0)


@settings(derandomize=True, deadline=None, max_examples=30)
@given(kind=KINDS, stress_pa=STRESSES_PA, turn=EIGHTHS_OF_A_KELVIN)
def test_looking_again_changes_nothing(kind: str, stress_pa: float, turn: int) -> None:
    """At the temperature where the fronts stand already nothing is due in either direction."""
    wire = WIRES[kind]
    for start in (HOT_K, COLD_K):
        fronts = walk(wire, ALL_AUSTENITE, stress_pa, HOT_K, start, turn / 8)[-1]
        assert fronts_at(wire, turn / 8, stress_pa, fronts) == fronts
