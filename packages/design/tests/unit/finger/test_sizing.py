"""From requirements to a finger's dimensions, and the limits that are named if there are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from musclewire_design._finger.chain import finger_chain
from musclewire_design._finger.curve import beam_stress_pa, column_gap_m, travel_for_endpoint_m
from musclewire_design._finger.sizing import FingerRequest, design_finger, finger_stiffness_n_per_m

from musclewire.errors import CallerError
from musclewire.parameters import load_material

POM = load_material("pom")
PAPER = FingerRequest(
    stiffness_n_per_m=1084.4,
    endpoint_m=6e-3,
    travel_m=1.05e-3,
    overall_length_m=0.010,
    plate_length_m=0.005,
    columns=4,
    column_width_m=0.3e-3,
    inward_angle_rad=0.14,
    depth_m=5e-3,
    max_depth_m=10e-3,
    min_thickness_m=0.1e-3,
)


ASKED = st.tuples(st.floats(600.0, 2500.0), st.floats(4.5e-3, 6.2e-3), st.floats(0.9e-3, 1.3e-3), st.integers(2, 6))


@settings(max_examples=4)
@given(ASKED)
def test_a_sized_finger_does_what_was_asked(asked: tuple[float, float, float, int]) -> None:
    size_a_finger(*asked)


@pytest.mark.full
@settings(max_examples=40)
@given(ASKED)
def test_40_sized_fingers_do_what_was_asked(asked: tuple[float, float, float, int]) -> None:
    size_a_finger(*asked)


def size_a_finger(stiffness: float, endpoint: float, travel: float, columns: int) -> None:
    request = replace(PAPER, stiffness_n_per_m=stiffness, endpoint_m=endpoint, travel_m=travel, columns=columns)
    finger = design_finger(request, POM)
    chain = finger_chain(finger)
    at = travel_for_endpoint_m(chain, finger.stiffness_n_m2, endpoint, travel)
    assert finger_stiffness_n_per_m(finger) == pytest.approx(stiffness, rel=0.01)
    assert 0.9 * travel < at.travel_m <= 0.96 * travel
    assert beam_stress_pa(finger, at).max() <= POM.yield_stress_pa.value
    assert column_gap_m(finger, at) > 0.0
    lengths = [value for name, value in finger.values().items() if name.endswith("_m")]
    assert np.array(lengths) / 1e-5 == pytest.approx(np.round(np.array(lengths) / 1e-5), abs=1e-6)


def test_a_stiffer_finger_is_thicker_and_one_with_more_travel_has_its_tendon_further_out() -> None:
    first = design_finger(PAPER, POM)
    stiffer = design_finger(replace(PAPER, stiffness_n_per_m=2000.0), POM)
    further = design_finger(replace(PAPER, travel_m=1.3e-3), POM)
    assert stiffer.beam_thickness_m > first.beam_thickness_m
    assert stiffer.tendon_offset_m == first.tendon_offset_m
    assert further.tendon_offset_m > 1.2 * first.tendon_offset_m


def test_a_finger_far_longer_than_its_endpoint_moves_is_still_sized() -> None:
    # The even arc for so small an angle once fell between two points of a grid, and the search had no bracket.
    finger = design_finger(replace(PAPER, overall_length_m=0.1), POM)
    assert finger_stiffness_n_per_m(finger) == pytest.approx(1084.4, rel=0.01)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"endpoint_m": 9e-3}, r"gives at most 7\.\d\d mm at any curl, 1\d\.\d % too little"),
        ({"stiffness_n_per_m": 5000.0}, r"would bear 6\d\.\d MPa .* \d % above the 65 MPa at which pom yields"),
        ({"stiffness_n_per_m": 20.0}, r"two tendon legs require 2 mm, \d\.\d times that"),
        ({"max_depth_m": 2e-3, "min_thickness_m": 0.22e-3}, r"\d\.\d\d mm more than the available room"),
        ({"travel_m": 1e-9}, r"a travel of 1e-06 mm bends no such finger: .* more travel"),
    ],
)
def test_the_limit_that_binds_is_named_and_by_how_much(changes: dict[str, float], said: str) -> None:
    with pytest.raises(CallerError, match=said):
        design_finger(replace(PAPER, **changes), POM)  # type: ignore[arg-type]
