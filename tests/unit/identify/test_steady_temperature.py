"""A wire settles where it gives off what it gets."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.identify._steady_temperature import steady_temperature_k
from musclewire.parameters import load_wire
from musclewire.physics import convection_coefficient_w_per_m2_k


@given(st.floats(305.0, 900.0))
def test_a_wire_settles_where_it_gives_off_what_it_gets(wall_k: float) -> None:
    wire = load_wire("flexinol-0.20-ht")
    given_off = convection_coefficient_w_per_m2_k(wall_k, 295.15, wire.diameter_m.value) * wire.convection_factor.value
    power = given_off * math.pi * wire.diameter_m.value * (wall_k - 295.15)
    assert steady_temperature_k(power, wire, 295.15) == pytest.approx(wall_k, abs=1e-3)
