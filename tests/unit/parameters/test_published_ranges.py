"""What is published for a wire's parameters, and what lies outside it."""

from __future__ import annotations

import re
from typing import Any

import pytest

from musclewire.errors import CallerError
from musclewire.parameters import load_alloy, load_wire
from musclewire.parameters.library import read_published
from musclewire.parameters.published_ranges import PublishedRange, PublishedRanges, outside, published_ranges
from musclewire.parameters.validation import validated

DENSITY = {"low": 6450.0, "high": 6500.0, "unit": "kg/m^3", "standing": "looked up", "source": "two data sheets"}


def of(name: str, **changed: Any) -> dict[str, Any]:
    return {"parameters": {name: DENSITY | changed}, "derived": {}}


@pytest.mark.parametrize(
    ("value", "beyond"), [(6450.0, 0.0), (6480.0, 0.0), (6500.0, 0.0), (6510.0, 10.0), (6400.0, -50.0)]
)
def test_beyond_is_the_signed_distance_from_the_nearer_edge(value: float, beyond: float) -> None:
    assert PublishedRange.model_validate(DENSITY).beyond(value) == pytest.approx(beyond)


def test_what_differs_in_rounding_lies_on_the_edge() -> None:
    assert PublishedRange.model_validate(DENSITY).beyond(6500.0 * (1.0 + 1e-9)) == 0.0


@pytest.mark.parametrize(
    ("name", "changed", "said"),
    [
        ("densty_kg_per_m3", {}, "did you mean"),
        ("density_kg_per_m3", {"unit": "g/cm^3"}, "it must be given in 'kg/m^3'"),
        ("density_kg_per_m3", {"low": 7000.0}, "low 7000 is above high 6500"),
        ("density_kg_per_m3", {"standing": "hearsay"}, "looked up"),
    ],
)
def test_a_mistake_in_the_file_is_named(name: str, changed: dict[str, Any], said: str) -> None:
    with pytest.raises(CallerError, match=re.escape(said)):
        validated(PublishedRanges, of(name, **changed), "published ranges")


def test_the_ranges_that_ship_are_those_of_actuator_wire() -> None:
    ranges = published_ranges().parameters
    isobars = read_published("flexinol_isobars")
    slope = ranges["martensite_stress_rate_pa_per_k"]
    for branch in ("heating", "cooling"):
        assert slope.beyond(1e6 * isobars[f"{branch}_slope_mpa_per_k"]) == 0.0
    widths = [abs(row[2] - row[0]) for branch in ("heating", "cooling") for row in isobars[f"{branch}_degc"]]
    width = published_ranges().derived["martensite_width_k"]
    assert (width.low, width.high) == pytest.approx((min(widths), max(widths)), abs=0.5)
    gaps = [hot[1] - cold[1] for hot, cold in zip(isobars["heating_degc"], isobars["cooling_degc"], strict=True)]
    hysteresis = published_ranges().derived["martensite_hysteresis_k"]
    assert (hysteresis.low, hysteresis.high) == pytest.approx((min(gaps), max(gaps)), abs=0.05)


def test_what_lies_outside_says_why_in_its_note() -> None:
    alloy = load_alloy("flexinol")
    assert [name for name, item in outside(alloy).items() if not item.note] == []


def test_one_figure_is_no_range_to_lie_in() -> None:
    alloy = load_alloy("flexinol")
    one = published_ranges().parameters["martensite_resistivity_per_k"]
    assert one.is_one_figure
    assert one.beyond(alloy.martensite_resistivity_per_k.value) != 0.0
    assert "martensite_resistivity_per_k" not in outside(alloy)


def test_a_value_moved_out_of_its_range_is_found() -> None:
    wire = load_wire("paper-100um")
    moved = wire.model_copy(update={"convection_factor": wire.convection_factor.model_copy(update={"value": 2.0})})
    assert "convection_factor" not in outside(wire)
    assert set(outside(moved)) == {"convection_factor"}
