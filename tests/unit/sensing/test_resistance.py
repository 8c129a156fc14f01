from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.physics import wire_resistance, wire_resistance_from_current

anything = st.floats(allow_nan=True, allow_infinity=True)


@pytest.mark.parametrize(
    ("wire_v", "shunt_v", "reading"),
    [
        (2.0, 0.125, (16.0, True)),
        (16, 1, (16.0, True)),
        (0.0, 0.0, (0.0, False)),
        (1e-3, 9e-4, (0.0, False)),
        (-2.0, -0.125, (16.0, True)),
        (2.0, -0.125, (0.0, False)),
    ],
    ids=["two volts", "whole numbers", "no current", "too little current", "reversed", "swapped leads"],
)
def test_one_sample_is_a_plain_resistance_or_none(wire_v: float, shunt_v: float, reading: tuple[float, bool]) -> None:
    found = wire_resistance(wire_v, shunt_v, 1.0)
    assert found == reading
    assert (type(found.resistance_ohm), type(found.valid)) == (float, bool)


def test_several_wires_keep_their_shape_and_spoil_only_themselves() -> None:
    wire = np.array([[2.0, 2.0, 2.0], [2.0, math.nan, 2.0]])
    shunt = np.array([[0.125, 0.0, 0.25], [0.125, 0.125, math.inf]])
    reading = wire_resistance(wire, shunt, 1.0)
    assert reading.valid.tolist() == [[True, False, True], [True, False, False]]
    assert reading.resistance_ohm.tolist() == [[16.0, 0.0, 8.0], [16.0, 0.0, 0.0]]


def test_a_measured_current_gives_the_same_as_a_shunt() -> None:
    assert wire_resistance_from_current(2.0, 0.125) == (16.0, True)
    assert wire_resistance_from_current(np.array([2.0]), np.array([0.0])).valid.tolist() == [False]


@pytest.mark.parametrize(("shunt", "least"), [(0.0, 1e-3), (-1.0, 1e-3), (math.nan, 1e-3), (1.0, 0.0)])
def test_senseless_constants_are_the_callers_fault(shunt: float, least: float) -> None:
    with pytest.raises(CallerError, match="must be positive"):
        wire_resistance(1.0, 1.0, shunt, least)


def test_columns_of_different_lengths_are_refused() -> None:
    with pytest.raises(CallerError, match="same shape"):
        wire_resistance(np.ones(3), np.ones(4), 1.0)


@given(anything, anything, st.floats(1e-3, 1e3), st.floats(1e-6, 1.0))
def test_any_voltages_give_a_finite_value_without_a_warning(
    wire: float, shunt: float, shunt_ohm: float, least: float
) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        one = wire_resistance(wire, shunt, shunt_ohm, least)
        many = wire_resistance(np.array([wire]), np.array([shunt]), shunt_ohm, least)
    assert math.isfinite(one.resistance_ohm)
    assert one.valid == (one.resistance_ohm > 0.0)
    assert (many.resistance_ohm[0], many.valid[0]) == (one.resistance_ohm, one.valid)
