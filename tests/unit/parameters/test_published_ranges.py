"""What is published for a wire's parameters, and what lies outside it."""

from __future__ import annotations

import re
import sys
from typing import Any

import pytest
from tests.places import CHECKOUT

from musclewire.errors import CallerError
from musclewire.parameters import PublishedRange, load_alloy, load_wire, published_ranges, read_published, validated
from musclewire.parameters._published_ranges import PublishedRanges

sys.path.insert(0, str(CHECKOUT / "docs/images"))

from parameter_page import former_counts, former_rows, outside, outside_as_a_spool, spool_ranges, spool_values

BRANCHES = ("heating", "cooling")
DENSITY = {"low": 6450.0, "high": 6500.0, "unit": "kg/m^3", "standing": "looked up", "source": "two data sheets"}


def of(name: str, **changed: Any) -> dict[str, Any]:
    return {"parameters": {name: DENSITY | changed}, "derived": {}}


@pytest.mark.parametrize(
    ("value", "beyond"), [(6450.0, 0.0), (6500.0, 0.0), (6500.0 * (1 + 1e-9), 0.0), (6510.0, 10.0), (6400.0, -50.0)]
)
def test_beyond_is_the_signed_distance_from_the_nearer_edge_and_rounding_lies_on_it(
    value: float, beyond: float
) -> None:
    assert PublishedRange.model_validate(DENSITY).excess(value) == pytest.approx(beyond, abs=0.0)


def test_a_widened_range_is_asked_for_what_it_was() -> None:
    found = PublishedRange.model_validate(DENSITY | {"former": (6460.0, 6470.0)})
    assert (found.excess(6455.0), found.before.excess(6455.0)) == (0.0, -5.0)
    assert PublishedRange.model_validate(DENSITY).before.excess(6455.0) == 0.0


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
    for branch in BRANCHES:
        assert slope.excess(1e6 * isobars[f"{branch}_slope_mpa_per_k"]) == 0.0
    held_out = isobars["held_out"]
    widths = [
        abs(row[2] - row[0]) for table in (isobars, held_out) for branch in BRANCHES for row in table[f"{branch}_degc"]
    ]
    width = published_ranges().derived["martensite_width_k"]
    # As recorded the narrowest is 26 K; the low end is that without the strain linear in temperature.
    assert width.high == pytest.approx(max(widths), abs=0.5)
    assert width.low < min(widths)
    gaps = [
        hot[1] - cold[1]
        for table in (isobars, held_out)
        for hot, cold in zip(table["heating_degc"], table["cooling_degc"], strict=True)
    ]
    hysteresis = published_ranges().derived["martensite_hysteresis_k"]
    assert hysteresis.low == pytest.approx(min(gaps), abs=0.05)
    assert hysteresis.excess(max(gaps)) == 0.0
    barrier = ranges["martensite_barrier_k"]
    assert (2.0 * barrier.low, 2.0 * barrier.high) == (hysteresis.low, hysteresis.high)
    assert (barrier.low, barrier.high) == (
        published_ranges().spools["martensite_barrier_k"].low,
        published_ranges().spools["martensite_barrier_k"].high,
    )


def test_what_lies_outside_says_why_in_its_note() -> None:
    alloy = load_alloy("flexinol")
    assert [name for name, item in outside(alloy).items() if not item.note] == []


def test_no_range_was_narrowed_and_each_that_was_widened_counts_both_ways() -> None:
    ranges = published_ranges()
    for found in (ranges.parameters | ranges.derived).values():
        assert found.low <= found.before.low <= found.before.high <= found.high


def test_a_value_between_the_former_and_the_new_end_is_outside_by_the_former_alone() -> None:
    alloy = load_alloy("flexinol")
    inside = alloy.with_values(martensite_barrier_k=10.0, r_phase_temperature_k=300.0)
    between = inside.with_values(martensite_barrier_k=9.6)
    assert [former_counts(one)[0] for one in (inside, between)] == [0, 1]
    assert "martensite_barrier_k" in [name for _, name, _, _ in former_rows(between)]
    assert "martensite_barrier_k" not in outside(between)


def test_one_figure_is_no_range_to_lie_in() -> None:
    alloy = load_alloy("flexinol")
    one = published_ranges().parameters["martensite_resistivity_per_k"]
    assert one.is_one_figure
    assert one.excess(alloy.martensite_resistivity_per_k.value) != 0.0
    assert "martensite_resistivity_per_k" not in outside(alloy)


def test_a_value_moved_out_of_its_range_is_found() -> None:
    wire = load_wire("paper-100um")
    moved = wire.with_values(convection_factor=2.0)
    assert "convection_factor" not in outside(wire)
    assert set(outside(moved)) == {"convection_factor"}


def test_a_spools_r_phase_has_both_shifts() -> None:
    wire = load_wire("paper-100um").with_values(
        temperature_shift_k=3.0, r_phase_shift_k=4.0, martensite_barrier_shift_k=0.0
    )
    assert spool_values(wire)["r_phase_temperature_shift_k"] == pytest.approx(7.0)
    assert "r_phase_temperature_shift_k" in outside_as_a_spool(wire)
    assert "temperature_shift_k" not in outside_as_a_spool(wire)


@pytest.mark.parametrize("name", ["paper-100um", "paper-125um", "paper-200um"])
def test_a_resistivity_is_measured_against_resistance_per_metre_and_diameter(name: str) -> None:
    wire = load_wire(name)
    nominal = wire.resistance_per_metre_ohm_per_m.value * wire.diameter_m.value**2 / (126.0 * 100e-6**2)
    assert spool_values(load_wire(name).with_values(resistivity_factor=nominal))[
        "resistivity_over_nominal"
    ] == pytest.approx(1.0)
    for factor, inside in ((1.02, True), (0.98, True), (1.04, False), (0.96, False)):
        moved = outside_as_a_spool(load_wire(name).with_values(resistivity_factor=nominal * factor))
        assert ("resistivity_over_nominal" not in moved) == inside


def test_the_isobars_sample_may_be_a_class_hotter_and_no_other_wire() -> None:
    shift = {"temperature_shift_k": 20.0, "r_phase_shift_k": 0.0}
    assert "temperature_shift_k" not in outside_as_a_spool(load_wire("isobar-sample").with_values(**shift))
    assert "temperature_shift_k" in outside_as_a_spool(load_wire("paper-100um").with_values(**shift))
    assert spool_ranges(load_wire("isobar-sample"))["temperature_shift_k"].source != ""


@pytest.mark.parametrize(
    ("spools_of", "said"),
    [
        ({"isobar-sampel": {"temperature_shift_k": DENSITY}}, "did you mean"),
        ({"isobar-sample": {"temperature_shift": DENSITY}}, "nothing that spools differ in"),
    ],
)
def test_an_unknown_spool_or_difference_is_named(spools_of: dict[str, Any], said: str) -> None:
    whole = of("density_kg_per_m3") | {"spools": {"temperature_shift_k": DENSITY}, "spools_of": spools_of}
    with pytest.raises(CallerError, match=said):
        validated(PublishedRanges, whole, "published ranges")
