"""A loop of a laboratory shows how fast its wire is, as well as it can, whoever built the wire."""

from __future__ import annotations

import pytest
from tests.labs.loops import LOOPS, SHUNT_OHM, loop

import musclewire as mw

# Heat capacity over heat loss of their wires by mass and correlation: the loss at the warmest, which it is below at the
# middle. What a rig of such a wire states (limit_heat_capacity_j_per_k over limit_heat_loss_w_per_k).
TIME_CONSTANT_S = {"grains": 0.794, "grains_under_a_weight": 1.699, "segments": 0.794}
DIAMETER_M = {"grains": 100e-6, "grains_under_a_weight": 150e-6, "segments": 100e-6}
FACTOR = 1.15


@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize("name", LOOPS)
def test_the_time_constant_is_within_its_deviation(name: str, known: bool) -> None:
    columns = {one: loop(name)[one] for one in ("time_s", "wire_voltage_v", "shunt_voltage_v", "displacement_m")}
    facts = {"shunt_resistance_ohm": SHUNT_OHM} | ({"wire_diameter_m": DIAMETER_M[name]} if known else {})
    wire = mw.fit(mw.Recording(columns, facts), quantity="displacement").wire_model
    assert wire is not None
    found = wire.time_constant_s
    assert abs(found.value - TIME_CONSTANT_S[name] / FACTOR) < 2.0 * found.std
    assert found.std < 0.75 * found.value
