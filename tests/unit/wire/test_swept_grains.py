"""The reference of tests/grain_wire looks only at grains between a threshold before and after; that must miss none."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grain_wire import GrainWire, grain_wire
from grain_wire.switching import cool, follow, forces_at, heat, remember
from musclewire.parameters import load_alloy, load_bench, load_wire


@cache
def shipped(**changes: float) -> GrainWire:
    """Make a wire when a test first asks for it: that compiles, which no other test should wait for."""
    alloy = {**load_alloy("flexinol").values(), **changes}
    return grain_wire(alloy, load_wire("paper-100um").values(), load_bench("paper").values())


# The alloy that ships; one in which f_M - f_R spreads the other way, or turns over as the load grows; one whose grains
# a load pulls apart; and one with no spread of the R-phase at all.
KINDS: dict[str, dict[str, float]] = {
    "shipped": {},
    "preference reversed": {"martensite_spread_k": 1.0, "r_phase_spread_k": 40.0},
    "early grains": {"early_fraction": 0.2, "early_width": 4.0},
    "pulled apart by load": {"martensite_spread_per_pa": 3e-8},
    "preference turns over": {
        "martensite_spread_k": 1.0,
        "martensite_spread_per_pa": 2e-8,
        "r_phase_spread_k": 20.0,
        "r_phase_entropy_ratio": 0.2,
    },
    "R-phase all at once": {"r_phase_spread_k": 0.0},
}
CLIMATES = st.lists(st.tuples(st.floats(290.0, 400.0), st.floats(0.0, 4e8)), min_size=2, max_size=40)


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=60)
@given(climates=CLIMATES)
def test_swept_grains_end_as_if_all_had_been_looked_at(kind: str, climates: list[tuple[float, float]]) -> None:
    wire = shipped(**KINDS[kind])
    constants = wire.constants[0]
    swept, whole = wire.copy().grains, wire.copy().grains
    grains = swept.middle.size
    hot = forces_at(constants, 500.0, 0.0, 1.0)
    for each in (swept, whole):  # a state goes with the forces it has followed
        each.martensite[:] = 0.0
        each.r_phase[:] = 0.0
        cool(constants, hot, each, 0, grains)
        remember(each, hot)
    for temperature_k, stress_pa in climates:
        forces = forces_at(constants, temperature_k, stress_pa, 1.0)
        before = swept.martensite.sum(), swept.r_phase.sum()
        changes = follow(swept, constants, temperature_k, stress_pa, 1.0)
        cool(constants, forces, whole, 0, grains)
        heat(constants, forces, whole, 0, grains)
        assert np.abs(swept.martensite - whole.martensite).max() < 1e-12
        assert np.abs(swept.r_phase - whole.r_phase).max() < 1e-12
        after = swept.martensite.sum(), swept.r_phase.sum()
        assert changes == pytest.approx((after[0] - before[0], after[1] - before[1]), abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=40)
@given(stress_pa=st.floats(0.0, 4e8), coldest_k=st.floats(280.0, 400.0))
def test_cooling_in_one_look_ends_where_cooling_bit_by_bit_does(kind: str, stress_pa: float, coldest_k: float) -> None:
    slowly, at_once = shipped(**KINDS[kind]).copy(), shipped(**KINDS[kind]).copy()
    slowly.cool(600.0, stress_pa)
    slowly.walk(np.linspace(600.0, coldest_k, 200), stress_pa)
    at_once.cool(coldest_k, stress_pa)
    assert np.abs(at_once.grains.martensite - slowly.grains.martensite).max() < 1e-9
    assert np.abs(at_once.grains.r_phase - slowly.grains.r_phase).max() < 1e-9
