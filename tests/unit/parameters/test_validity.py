"""What an alloy's data cover is stated in its file, checked, kept in wire files, and judged by one function."""

from __future__ import annotations

import tomllib
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from musclewire.parameters import (
    Alloy,
    ReachedConditions,
    ValidityLimits,
    beyond_validity,
    catalogue_row,
    load_alloy,
    load_wire,
    section_m2,
    validity_of,
    wire_file_text,
)

FLEXINOL = load_alloy("flexinol")
LIMITS = validity_of(FLEXINOL)


def test_the_vendors_stress_is_the_catalogues_pull_force() -> None:
    row = catalogue_row("flexinol-0.10-lt")
    force_n = LIMITS.working_stress_pa * pi / 4.0 * row.diameter_m**2
    assert force_n == pytest.approx(row.pull_force_g.value * 9.80665e-3, rel=0.01)


def test_a_wire_within_all_limits_has_no_warning() -> None:
    assert beyond_validity(LIMITS, ReachedConditions(60e6, 150e6, 380.0, section_m2(1e-4, 2.0))) == ()
    assert beyond_validity(ValidityLimits(), ReachedConditions(1.0, 1e9, 2000.0)) == ()


def test_each_limit_is_named_with_its_number_and_force() -> None:
    (low,) = beyond_validity(LIMITS, ReachedConditions(cold_stress_pa=20e6, section_m2=1e-8))
    assert "20 MPa (0.20 N)" in low
    assert "45 MPa (0.45 N)" in low
    vendor, data = beyond_validity(LIMITS, ReachedConditions(largest_stress_pa=300e6))
    assert "vendor's 172 MPa" in vendor
    assert "220 MPa that the alloy's data cover" in data
    (data,) = beyond_validity(LIMITS, ReachedConditions(temperature_k=443.15))
    assert "170 C, above the 140 C" in data
    (annealed,) = beyond_validity(LIMITS, ReachedConditions(temperature_k=490.0))
    assert "above the 200 C" in annealed


@given(st.floats(0.0, 1e9), st.floats(0.0, 1e9), st.floats(200.0, 2000.0))
def test_more_stress_and_heat_never_warn_less(stress_pa: float, more_pa: float, kelvin: float) -> None:
    less = beyond_validity(LIMITS, ReachedConditions(100e6, stress_pa, kelvin))
    more = beyond_validity(LIMITS, ReachedConditions(100e6, stress_pa + more_pa, kelvin + 1.0))
    assert len(more) >= len(less)


def test_a_recording_states_the_limits_as_the_alloy_does() -> None:
    assert ValidityLimits.stated_in({**LIMITS.facts(), "wire": "x"}) == LIMITS


def test_a_wire_file_keeps_the_range() -> None:
    text = wire_file_text("w", "", load_wire("paper-100um"), FLEXINOL, {})
    read = tomllib.loads(text)["alloy"]
    assert Alloy.model_validate({"name": "w", "description": "", **read}).validity == FLEXINOL.validity


@pytest.mark.parametrize(
    ("key", "entry", "value", "message"),
    [
        ("stress", "low", 1e9, "below high"),
        ("stress", "unit", "MPa", "must be given in 'Pa'"),
        ("annealing_temperature", "value", 200.0, "above the temperatures covered"),
    ],
)
def test_a_wrong_range_is_refused(key: str, entry: str, value: object, message: str) -> None:
    data = FLEXINOL.model_dump()
    data["validity"][key][entry] = value
    with pytest.raises(ValidationError, match=message):
        Alloy.model_validate(data)
