"""A serpentine by four independent ways: a formula on paper, integrals, beam elements, plane stress."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from musclewire_design._frame import chain_stiffness_n_per_m
from musclewire_design._serpentine.closed_form import (
    corner_stress_factor,
    guided_factor,
    nominal_stress_pa,
    rounded_stiffness_n_per_m,
    stiffness_n_per_m,
)
from musclewire_design._serpentine.geometry import CentreLineArc, CentreLineStraight, SerpentineGeometry
from musclewire_design._serpentine.strip import MESHES, ForceCurve, force_curve, linear_answer

from musclewire.errors import CallerError
from musclewire.parameters import load_material

MODULUS = 2.6e9
POM = load_material("pom")


def serpentine(
    beams: int = 6, half: float = 11e-3, pitch: float = 4e-3, thickness: float = 0.4e-3
) -> SerpentineGeometry:
    return SerpentineGeometry.with_corner_fraction(beams, half, pitch, thickness, 10e-3)


def frame(geometry: SerpentineGeometry, *, guided: bool = False) -> float:
    joints = np.array(geometry.vertices_m())
    area = geometry.depth_m * geometry.thickness_m
    return chain_stiffness_n_per_m(joints, MODULUS * geometry.second_moment_m4, MODULUS * area, guided=guided)


shapes = st.builds(
    serpentine,
    st.integers(1, 10),
    st.floats(8e-3, 15e-3),
    st.floats(2e-3, 6e-3),
    st.floats(0.1e-3, 0.6e-3),
)


def test_the_formula_gives_the_worked_example() -> None:
    """b = 10 mm, a = 11 mm, p = 4 mm, N = 6, E = 2.6 GPa, t = 1.14 mm: 390 N/m by hand (EI = 3.21e-3 N m2)."""
    geometry = serpentine(thickness=1.14e-3)
    by_hand = 3 * 2.6e9 * (10e-3 * 1.14e-3**3 / 12) / (6 * 11e-3**2 * (2 * 11e-3 + 3 * 4e-3))
    assert stiffness_n_per_m(geometry, MODULUS) == pytest.approx(by_hand, rel=1e-12)
    assert by_hand == pytest.approx(390.1, abs=0.1)
    assert nominal_stress_pa(geometry, 1.0) == pytest.approx(6 * 11e-3 / (10e-3 * 1.14e-3**2), rel=1e-12)


@given(shapes)
def test_beam_elements_agree_with_the_formula(geometry: SerpentineGeometry) -> None:
    assert frame(geometry) == pytest.approx(stiffness_n_per_m(geometry, MODULUS), rel=5e-3)


@given(shapes)
def test_beam_elements_agree_with_the_closed_form_of_a_guided_end(geometry: SerpentineGeometry) -> None:
    factor = guided_factor(geometry)
    assert frame(geometry, guided=True) == pytest.approx(factor * stiffness_n_per_m(geometry, MODULUS), rel=1e-2)
    assert factor >= 1.0 - 1e-9


@pytest.mark.parametrize(
    ("beams", "half", "pitch", "thickness"),
    [(2, 10e-3, 5e-3, 0.5e-3), (4, 8e-3, 4e-3, 0.4e-3), (6, 11e-3, 4e-3, 0.4e-3), (3, 9e-3, 3e-3, 0.2e-3)],
)
def test_plane_stress_agrees_with_the_formula_for_thin_strips(
    beams: int, half: float, pitch: float, thickness: float
) -> None:
    geometry = serpentine(beams, half, pitch, thickness)
    assert thickness <= 0.1 * pitch
    found = linear_answer(geometry, POM).stiffness_n_per_m
    assert found == pytest.approx(stiffness_n_per_m(geometry, MODULUS), rel=0.03)
    assert found == pytest.approx(rounded_stiffness_n_per_m(geometry, MODULUS, 0.35), rel=5e-3)


@pytest.mark.parametrize("thickness_over_pitch", [0.1, 0.2, 0.3])
@pytest.mark.parametrize("radius", [0.25, 0.5])
def test_beyond_thin_the_rounded_corners_explain_the_difference(thickness_over_pitch: float, radius: float) -> None:
    thickness = thickness_over_pitch * 4e-3
    geometry = serpentine(4, thickness=thickness).with_(corner_radius_m=radius * thickness)
    found = linear_answer(geometry, POM).stiffness_n_per_m
    assert found == pytest.approx(rounded_stiffness_n_per_m(geometry, MODULUS, 0.35), rel=0.015)
    assert found > stiffness_n_per_m(geometry, MODULUS)


def test_meshes_converge_to_half_a_percent() -> None:
    geometry = SerpentineGeometry(4, 11.72e-3, 3.26e-3, 1.01e-3, 10e-3, 0.25e-3)
    found = [linear_answer(geometry, POM, across).stiffness_n_per_m for across in MESHES]
    steps = np.abs(np.diff(found))
    assert (np.diff(steps) < 0.0).all()
    assert found[-2] == pytest.approx(found[-1], rel=1e-3)
    assert linear_answer(geometry, POM, 8).stiffness_n_per_m == pytest.approx(found[-1], rel=5e-3)


def test_the_stress_at_a_rounded_corner_is_that_of_a_curved_beam() -> None:
    geometry = serpentine(4, thickness=0.8e-3).with_(corner_radius_m=0.4e-3)
    found = linear_answer(geometry, POM).stress_pa_per_n
    assert found == pytest.approx(corner_stress_factor(geometry) * nominal_stress_pa(geometry, 1.0), rel=0.05)


def test_a_curved_beams_factor_is_the_textbooks() -> None:
    """Rectangle, r_c/t = 1: 1.52 at the inner edge (Timoshenko 1955); none for a hardly curved beam."""
    assert corner_stress_factor(serpentine().with_(corner_radius_m=0.2e-3)) == pytest.approx(1.52, abs=0.01)
    gentle = serpentine(pitch=40e-3, half=60e-3).with_(corner_radius_m=19e-3)
    assert corner_stress_factor(gentle) == pytest.approx(1.0, abs=0.01)
    assert math.isinf(corner_stress_factor(serpentine().with_(corner_radius_m=0.0)))


@cache
def short_curve() -> ForceCurve:
    return force_curve(serpentine(2, 8e-3, 3e-3, 0.8e-3), POM, 1e-3, 2)


def test_small_travel_of_the_curve_is_the_linear_answer() -> None:
    found = short_curve()
    linear = linear_answer(serpentine(2, 8e-3, 3e-3, 0.8e-3), POM, 2)
    assert found.force_n[1] / found.travel_m[1] == pytest.approx(linear.stiffness_n_per_m, rel=0.03)
    assert found.stress_pa[1] / found.force_n[1] == pytest.approx(linear.stress_pa_per_n, rel=0.03)
    assert (np.diff(found.travel_m) > 0.0).all()
    assert (np.diff(found.force_n) > 0.0).all()


def test_at_the_safe_travel_the_stress_is_what_is_allowed() -> None:
    found = short_curve()
    assert found.stress_at(found.safe_travel_m) == pytest.approx(POM.allowable_stress_pa.value, rel=1e-3)
    assert math.isnan(found.stress_at(1.0))


@given(shapes)
def test_the_centre_line_goes_on_without_a_break_and_turns_as_often_to_both_sides(geometry: SerpentineGeometry) -> None:
    place, turned = (0.0, geometry.fittings.pad_height_m), 0.0
    for piece in geometry.centre_line():
        if isinstance(piece, CentreLineStraight):
            assert math.dist(place, piece.start_m) < 1e-12
            place = piece.end_m
        else:
            end = piece.start_rad + piece.turn_rad
            assert math.dist(place, on(piece, piece.start_rad)) < 1e-12
            place, turned = on(piece, end), turned + piece.turn_rad
    assert math.dist(place, (0.0, geometry.connector_m)) < 1e-12
    assert turned == pytest.approx(0.0, abs=1e-9)


def on(arc: CentreLineArc, angle: float) -> tuple[float, float]:
    x, y = arc.centre_m
    return x + arc.radius_m * math.cos(angle), y + arc.radius_m * math.sin(angle)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"thickness_m": 0.0}, "thickness is 0 mm: it must be above 0"),
        ({"corner_radius_m": 5e-3}, "corner radius of 5 mm does not fit between beams 3.6 mm apart"),
    ],
)
def test_what_is_no_serpentine_is_said_in_one_line(changes: dict[str, float], words: str) -> None:
    with pytest.raises(CallerError) as caught:
        serpentine().with_(**changes)
    assert words in str(caught.value)
