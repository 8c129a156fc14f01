"""The Flexinol catalogue: what can be checked of its numbers, their standing, and the wires made from them."""

from __future__ import annotations

import math

import pytest

from musclewire.parameters import (
    CatalogueRow,
    catalogue_names,
    catalogue_row,
    load_alloy,
    load_catalogue,
    load_wire,
    names,
)
from musclewire.physics import convection_coefficient_w_per_m2_k

ROWS = load_catalogue().row
SOUND = [row for row in ROWS if row.pull_force_g.status != "suspect"]
AIR_K = 295.15


def by_name(row: CatalogueRow) -> str:
    return row.name


def test_it_has_the_twelve_sizes_from_0_025_to_0_51_mm() -> None:
    assert [row.diameter_in for row in ROWS] == [
        0.001, 0.0015, 0.002, 0.003, 0.004, 0.005, 0.006, 0.008, 0.01, 0.012, 0.015, 0.02
    ]  # fmt: skip
    assert len(catalogue_names()) == 24


@pytest.mark.parametrize("row", ROWS, ids=by_name)
def test_the_metric_size_rounds_the_inch_size(row: CatalogueRow) -> None:
    assert row.diameter_mm == pytest.approx(25.4 * row.diameter_in, rel=0.025)
    assert float(row.name) == row.diameter_mm


@pytest.mark.parametrize("row", SOUND, ids=by_name)
def test_the_forces_are_172_and_69_mpa_on_the_inch_diameter(row: CatalogueRow) -> None:
    """The vendor's 25 and 10 thousand psi; grams are printed to two digits for the thin wires."""
    assert row.pull_force_n / row.area_m2 == pytest.approx(25e3 * 6894.76, rel=0.015)
    assert row.cooling_force_n / row.area_m2 == pytest.approx(10e3 * 6894.76, rel=0.025)


def test_only_the_0_38_mm_row_is_suspect_and_it_is_off_by_an_eighth() -> None:
    suspects = [row for row in ROWS if any(cell.status == "suspect" for _, cell in row.cells())]
    assert [row.name for row in suspects] == ["0.38"]
    assert suspects[0].pull_force_n / suspects[0].area_m2 == pytest.approx(194e6, rel=0.01)


def test_a_corroborated_cell_says_where_and_no_other_claims_a_source() -> None:
    cells = [cell for row in ROWS for _, cell in row.cells()]
    assert len(cells) == 72
    assert all(bool(cell.source) == cell.corroborated for cell in cells)
    assert not any("consistency" in cell.source for cell in cells)


def test_thicker_wires_pull_more_take_more_current_resist_less_and_cool_more_slowly() -> None:
    for name, grows in (("resistance_ohm_per_m", False), ("pull_force_g", True), ("cooling_force_g", True),
                        ("current_ma", True), ("cooling_lt_s", True), ("cooling_ht_s", True)):  # fmt: skip
        values = [getattr(row, name).value for row in ROWS]
        assert values == sorted(values, reverse=not grows), name
    assert all(row.cooling_ht_s.value < row.cooling_lt_s.value for row in ROWS)


def test_the_classes_differ_by_one_amount_of_temperature_and_nothing_that_matters_cold() -> None:
    """LT 68/78/52/42 against HT 88/98/72/62 C: 20 K."""
    for row in ROWS:
        low, high = (load_wire(f"flexinol-{row.name}-{kind}").values() for kind in ("lt", "ht"))
        assert high["temperature_shift_k"] - low["temperature_shift_k"] == pytest.approx(20.0)
        assert high["temperature_shift_k"] == load_wire("isobar-sample").temperature_shift_k.value
        for same in ("diameter_m", "resistivity_factor", "maximum_force_n", "convection_factor"):
            assert low[same] == high[same]


@pytest.mark.parametrize("name", catalogue_names())
def test_a_wire_says_of_each_number_how_far_it_can_be_trusted(name: str) -> None:
    wire, row = load_wire(name), catalogue_row(name)
    assert wire.name == name
    assert wire.diameter_m.value == pytest.approx(25.4e-3 * row.diameter_in)
    assert wire.resistance_per_metre_ohm_per_m.note.startswith(row.resistance_ohm_per_m.status)
    assert wire.maximum_force_n.value > 2.5 * row.pull_force_n
    cold_ohm = 0.14 * row.resistance_ohm_per_m.value + 1.0
    assert wire.maximum_voltage_v.value > row.current_a * cold_ohm
    assert load_alloy(wire.alloy)


@pytest.mark.parametrize("row", ROWS, ids=by_name)
def test_the_holding_currents_are_the_heat_balance_they_claim(row: CatalogueRow) -> None:
    """As hot as 3.2 V through 1 ohm holds the paper's 15.15 ohm (Table 2) on 14 cm of 0.1 mm, and 20 K hotter."""

    def given_off(diameter_m: float, wall_k: float) -> float:
        return convection_coefficient_w_per_m2_k(wall_k, AIR_K, diameter_m) * diameter_m * (wall_k - AIR_K)

    paper_w_per_m = (3.2 / 16.15) ** 2 * 15.15 / 0.14
    paper_wall_k = 398.15
    hot_ohm_per_m = 0.866 * row.resistance_ohm_per_m.value
    for holding_ma, hotter_k in ((row.holding_lt_ma, 0.0), (row.holding_ht_ma, 20.0)):
        share = given_off(row.diameter_m, paper_wall_k + hotter_k) / given_off(100e-6, paper_wall_k)
        assert 1e-3 * holding_ma == pytest.approx(math.sqrt(paper_w_per_m * share / hot_ohm_per_m), rel=0.01)


def test_catalogue_wires_are_among_the_names_after_the_files() -> None:
    assert names("wire")[-24:] == catalogue_names()
    assert "paper-100um" in names("wire")
