"""Dimensions that cannot be a finger's, and what a drawing has of one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from musclewire_design._finger.chain import finger_chain, place
from musclewire_design._finger.curve import column_gap_m
from musclewire_design._finger.drawing import finger_drawing
from musclewire_design._finger.geometry import FingerGeometry
from musclewire_design._finger.shape import finger_shape
from musclewire_design._finger.statics import equilibria
from packages.design.tests.unit.finger.fingers import CURVED, PLAIN

from musclewire.errors import CallerError
from musclewire.parameters import Parameter


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"youngs_modulus_pa": math.nan}, "youngs_modulus_pa is nan"),
        ({"columns": 2.5}, "1 to 40 columns, not 2.5"),
        ({"tendon_offset_m": 0.05e-3}, "inside the beam"),
    ],
)
def test_what_is_no_finger_is_refused_by_name(changes: dict[str, float], said: str) -> None:
    with pytest.raises(CallerError, match=said):
        PLAIN.with_(**changes)


def test_a_file_without_a_dimension_or_in_another_unit_is_refused() -> None:
    item = Parameter(value=1.0, unit="mm", kind="assumed", source="a guess")
    with pytest.raises(CallerError, match=r"finger mine: geometry.overall_length_m has the unit 'mm'"):
        FingerGeometry.from_parameters({"overall_length_m": item}, "finger mine")
    with pytest.raises(CallerError, match=r"overall_length_m is missing; did you mean 'overall_lenght_m'"):
        FingerGeometry.from_parameters({"overall_lenght_m": item}, "finger mine")


@pytest.mark.parametrize("finger", [PLAIN, CURVED])
def test_the_picture_is_of_the_shape_that_was_solved(finger: FingerGeometry) -> None:
    chain = finger_chain(finger)
    at = equilibria(chain, finger.stiffness_n_m2, np.linspace(0.0, 1e-3, 9))[-1]
    shape = finger_shape(finger, at.angles_rad)
    assert shape.endpoint[:2] == pytest.approx(at.placed.endpoint_m, abs=1e-12)
    path = np.linalg.norm(np.diff(shape.tendon(), axis=0), axis=1)
    assert path[::2] == pytest.approx(at.placed.chord_lengths_m, abs=1e-12)
    assert path[1::2] == pytest.approx(np.full(4, finger.column_width_m))


def test_a_drawing_has_the_area_of_its_parts() -> None:
    parts = PLAIN.flexible_length_m * PLAIN.beam_thickness_m
    parts += 4 * PLAIN.column_width_m * (PLAIN.column_height_m + 0.5 * PLAIN.beam_thickness_m)
    parts += PLAIN.plate_length_m * PLAIN.plate_thickness_m
    block = 8e-3 * (5e-3 + PLAIN.column_height_m) - 2 * 0.25 * math.pi * 2.2e-3**2
    assert finger_drawing(PLAIN).area_m2 == pytest.approx(parts + block, rel=1e-6)
    assert finger_drawing(CURVED).area_m2 == pytest.approx(parts + block, rel=1e-3)
    assert "5.00 mm deep" in finger_drawing(PLAIN).note


def test_columns_close_their_gap_by_their_height_times_the_bend() -> None:
    chain = finger_chain(PLAIN)
    bent = equilibria(chain, PLAIN.stiffness_n_m2, np.linspace(0.0, 0.5e-3, 5))
    turn = np.diff(bent[-1].angles_rad[[7, 15, 23, 31]], prepend=0.0).max()
    expected = PLAIN.segment_length_m - PLAIN.column_height_m * turn
    assert column_gap_m(PLAIN, bent[-1]) == pytest.approx(expected, rel=0.01)
    assert column_gap_m(PLAIN, bent[0]) == pytest.approx(PLAIN.segment_length_m)
    assert place(chain, chain.resting_angles_rad).endpoint_m == pytest.approx([0.010, 0.0])
