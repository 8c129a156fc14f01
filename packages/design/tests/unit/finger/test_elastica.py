"""The chain's statics against what is printed and what has a closed form: elastica, pure moment, straight chords."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from musclewire_design._finger.chain import cantilever_chain
from musclewire_design._finger.closed_forms import (
    chord_travel_m,
    end_loaded_cantilever,
)
from musclewire_design._finger.statics import loaded_cantilever

from musclewire.errors import CallerError

# Mattiasson 1981, Int. J. Numer. Meth. Engng 17, 145, doi 10.1002/nme.1620170113: load, deflection, shortening, slope.
MATTIASSON = [
    (0.1, 0.03330, 0.00067, 0.04995),
    (0.5, 0.16214, 0.01592, 0.24453),
    (1.0, 0.30172, 0.05643, 0.46135),
    (2.0, 0.49346, 0.16064, 0.78175),
    (5.0, 0.71379, 0.38763, 1.21537),
    (10.0, 0.81061, 0.55500, 1.43029),
]


@pytest.mark.parametrize("row", MATTIASSON)
def test_the_elliptic_integrals_give_the_printed_table(row: tuple[float, ...]) -> None:
    assert end_loaded_cantilever(row[0]) == pytest.approx(row[1:], abs=6e-6)


@pytest.mark.parametrize("row", MATTIASSON)
def test_the_chain_gives_the_printed_table_within_half_a_percent(row: tuple[float, ...]) -> None:
    length, stiffness = 0.005, 5e-6
    force = row[0] * stiffness / length**2
    bent = loaded_cantilever(cantilever_chain(length, 32), stiffness, force)
    assert bent.endpoint_displacement_m / length == pytest.approx(row[1], rel=0.005)
    assert 1.0 - bent.placed.endpoint_m[0] / length == pytest.approx(row[2], rel=0.005, abs=6e-6)
    assert bent.angles_rad[-1] == pytest.approx(row[3], rel=0.005)


def test_twice_as_many_elements_leave_a_quarter_of_the_error() -> None:
    exact = end_loaded_cantilever(5.0).deflection
    errors = [
        abs(loaded_cantilever(cantilever_chain(1.0, n), 1.0, 5.0).endpoint_displacement_m - exact) for n in (8, 16, 32)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("load", [0.0, math.nan])
def test_a_load_that_is_none_is_refused(load: float) -> None:
    with pytest.raises(CallerError, match="above 0"):
        end_loaded_cantilever(load)


@given(st.floats(0.05, 2.5), st.integers(1, 8), st.floats(0.1, 0.5))
def test_chords_are_as_long_as_their_ends_are_apart(angle: float, chords: int, offset: float) -> None:
    # The guides of an arc of length 1, set off towards its centre.
    radius = 1.0 / angle
    at = np.linspace(0.0, angle, chords + 1)
    guides = np.column_stack([(radius - offset) * np.sin(at), (radius - offset) * np.cos(at)])
    length = np.linalg.norm(np.diff(guides, axis=0), axis=1).sum() * math.copysign(1.0, radius - offset)
    assert chord_travel_m(angle, offset, 1.0, chords) == pytest.approx(1.0 - length, abs=1e-12)
