"""A step looks only at the grains between a threshold before and after; that must miss none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from musclewire.wire.switching import cool_swept, driving_forces_at, heat_swept, switch_grains

from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire.building import constants_from, cooled_wire
from musclewire.wire.state import WireConstants


def shipped(**changes: float) -> WireConstants:
    constants = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
    return constants.replace(**changes)


# The alloy that ships; one in which f_M - f_R spreads the other way, or turns over as the load grows; one whose grains
# a load pulls apart; and one with no spread of the R-phase at all.
KINDS = {
    "shipped": shipped(),
    "preference reversed": shipped(martensite_spread_k=1.0, r_phase_spread_k=40.0),
    "pulled apart by load": shipped(martensite_spread_per_pa=3e-8),
    "preference turns over": shipped(
        martensite_spread_k=1.0, martensite_spread_per_pa=2e-8, r_phase_spread_k=20.0, r_phase_entropy_ratio=0.2
    ),
    "R-phase all at once": shipped(r_phase_spread_k=0.0),
}
CLIMATES = st.lists(st.tuples(st.floats(290.0, 400.0), st.floats(0.0, 4e8)), min_size=2, max_size=40)


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=60)
@given(climates=CLIMATES)
def test_swept_grains_end_as_if_all_had_been_looked_at(kind: str, climates: list[tuple[float, float]]) -> None:
    constants = KINDS[kind]
    grains = constants.grain_middle.shape[0]
    followed = driving_forces_at(constants.record, 500.0, 0.0, 1.0)
    swept, whole = (np.zeros(grains), np.zeros(grains)), (np.zeros(grains), np.zeros(grains))
    for grain_pair in (swept, whole):  # a state goes with the forces it has followed
        cool_swept(constants.record, followed, 0, grains, *grain_pair)
    for temperature_k, stress_pa in climates:
        forces = driving_forces_at(constants.record, temperature_k, stress_pa, 1.0)
        before = swept[0].sum(), swept[1].sum()
        changes = switch_grains(constants.record, forces, followed, *swept)
        cool_swept(constants.record, forces, 0, grains, *whole)
        heat_swept(constants.record, forces, 0, grains, *whole)
        followed = forces
        assert np.abs(swept[0] - whole[0]).max() < 1e-12
        assert np.abs(swept[1] - whole[1]).max() < 1e-12
        assert changes == pytest.approx((swept[0].sum() - before[0], swept[1].sum() - before[1]), abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=40)
@given(stress_pa=st.floats(0.0, 4e8), coldest_k=st.floats(280.0, 400.0))
def test_cooling_in_one_look_ends_where_cooling_bit_by_bit_does(kind: str, stress_pa: float, coldest_k: float) -> None:
    constants = KINDS[kind]
    grains = constants.grain_middle.shape[0]
    martensite, r_phase = np.zeros(grains), np.zeros(grains)
    for temperature_k in np.linspace(600.0, coldest_k, 200):
        forces = driving_forces_at(constants.record, float(temperature_k), stress_pa, 1.0)
        cool_swept(constants.record, forces, 0, grains, martensite, r_phase)
    at_once = cooled_wire(constants, stress_pa, coldest_k)
    assert np.abs(at_once.grain_martensite - martensite).max() < 1e-9
    assert np.abs(at_once.grain_r_phase - r_phase).max() < 1e-9
