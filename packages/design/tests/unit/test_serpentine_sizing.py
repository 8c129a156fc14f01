"""Backwards: what is wanted becomes a part that can be made, or one line says which limit binds and by how much."""

from __future__ import annotations

from functools import cache

import pytest
from musclewire_design._serpentine.analysis import PretensionerDesign, PretensionerDuty, analyse
from musclewire_design._serpentine.closed_form import stiffness_n_per_m
from musclewire_design._serpentine.geometry import AvailableRoom, SerpentineGeometry
from musclewire_design._serpentine.sizing import PretensionerRequest, design_pretensioner

from musclewire.errors import CallerError
from musclewire.parameters import load_material

PAPER = AvailableRoom(24.6e-3, 27.6e-3, 10e-3)
# Lan and Fan 2010, sections 4.1 and 4.3: pretensioner and finger, pretension; a leg of 35 mm contracts by 3 %.
STIFFNESS, FINGER, PRETENSION, STROKE = 386.2, 1084.4, 0.71, 1.05e-3


def request(
    stiffness: float = STIFFNESS,
    material: str = "pom",
    envelope: AvailableRoom = PAPER,
    process: str | None = None,
    duty: PretensionerDuty | None = None,
) -> PretensionerRequest:
    usual = PretensionerDuty(PRETENSION, STROKE, None, FINGER)
    return PretensionerRequest(stiffness, duty or usual, load_material(material), envelope, process)


@cache
def papers() -> PretensionerDesign:
    return design_pretensioner(request())


def test_the_papers_pretensioner_is_found_within_a_percent_and_inside_its_envelope() -> None:
    found = papers()
    assert found.stiffness_n_per_m == pytest.approx(STIFFNESS, rel=0.01)
    sizes = (found.geometry.across_m, found.geometry.along_m, found.geometry.depth_m)
    assert all(size <= room + 1e-9 for size, room in zip(sizes, PAPER, strict=True))
    assert found.holds, [check for check in found.checks if not check.ok]


def test_it_gives_the_pretension_and_the_stroke_below_the_allowed_stress() -> None:
    found = papers()
    assert found.travel_m == pytest.approx(PRETENSION / found.stiffness_n_per_m + STROKE)
    assert found.curve.safe_travel_m > found.travel_m
    assert found.stress_pa is not None
    assert found.stress_pa < found.material.allowable_stress_pa.value
    assert found.curve.force_at(found.curve.safe_travel_m - STROKE) > PRETENSION


def test_a_thinner_strip_is_as_much_softer_as_the_closed_form_says() -> None:
    found = papers()
    thinner, modulus = found.geometry.with_(thickness_m=0.8 * found.geometry.thickness_m), 2.6e9
    ratio = stiffness_n_per_m(thinner, modulus) / stiffness_n_per_m(found.geometry, modulus)
    assert found.stiffness_at(thinner.thickness_m) == pytest.approx(ratio * found.stiffness_n_per_m, rel=0.03)


@pytest.mark.parametrize(
    "material", [pytest.param("pla", marks=pytest.mark.full), pytest.param("spring-steel", marks=pytest.mark.slow)]
)
def test_other_materials_give_other_parts_of_the_same_stiffness(material: str) -> None:
    found = design_pretensioner(request(material=material))
    assert found.stiffness_n_per_m == pytest.approx(STIFFNESS, rel=0.01)
    assert found.holds
    assert found.geometry.thickness_m >= found.material.minimum_thickness_by(None)


def test_weighed_by_its_length() -> None:
    geometry = papers().geometry
    around = 4 * 2 * geometry.half_length_m + 4 * geometry.pitch_m
    strip = around * geometry.thickness_m * geometry.depth_m * 1410.0
    assert papers().mass_kg == pytest.approx(strip, rel=0.15)


IMPOSSIBLE = {
    "far too stiff": (
        request(1e6, duty=PretensionerDuty(PRETENSION, STROKE)),
        ("stiffness out of reach", "N/m less than the 1e+06 N/m requested"),
    ),
    "far too soft": (
        request(0.01, duty=PretensionerDuty(0.001)),
        ("too thin to make", "mm below the 1 mm that 'laser-cut' makes"),
    ),
    "too much travel": (
        request(duty=PretensionerDuty(PRETENSION, travel_m=32e-3)),
        ("too much stress", "at a travel of 32.00 mm", "MPa above the 32.5 MPa", "yield 65 MPa"),
    ),
    "too narrow": (request(envelope=AvailableRoom(5e-3, 27.6e-3, 10e-3)), ("12.00 mm across the wire, 7.00 mm more",)),
    "stiffer than the finger": (
        request(duty=PretensionerDuty(PRETENSION, STROKE, None, 300.0)),
        ("no softer than the finger of 300.0 N/m", "86.2 N/m too stiff", "56 % of the contraction force"),
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_what_cannot_be_is_one_line_with_the_limit_and_by_how_much(name: str) -> None:
    asked, words = IMPOSSIBLE[name]
    with pytest.raises(CallerError) as caught:
        design_pretensioner(asked)
    message = str(caught.value)
    for word in words:
        assert word in message


def test_a_given_serpentine_that_breaks_a_rule_says_which() -> None:
    stiff = SerpentineGeometry.with_corner_fraction(2, 6e-3, 4e-3, 1.5e-3, 10e-3)
    found = analyse(stiff, load_material("pom"), None, PretensionerDuty(PRETENSION, STROKE, None, FINGER), PAPER)
    assert not found.holds
    assert "softer than the finger" in [check.name for check in found.checks if not check.ok]


@pytest.mark.slow
def test_a_travel_beyond_what_the_strip_stretches_to_is_said() -> None:
    small = SerpentineGeometry.with_corner_fraction(2, 6e-3, 3e-3, 0.8e-3, 5e-3)
    with pytest.raises(CallerError, match=r"a travel of 60\.00 mm is too far: .* MPa above the permanent limit of pom"):
        analyse(small, load_material("pom"), None, PretensionerDuty(travel_m=60e-3))


@pytest.mark.slow
def test_gentler_corners_are_tried_where_the_usual_ones_have_too_much_stress() -> None:
    """8 mm of travel are too far with an inner radius of a quarter of the thickness, and not with half of it."""
    found = design_pretensioner(request(duty=PretensionerDuty(PRETENSION, travel_m=8e-3)))
    assert found.holds
    assert found.geometry.corner_radius_m > 0.4 * found.geometry.thickness_m
