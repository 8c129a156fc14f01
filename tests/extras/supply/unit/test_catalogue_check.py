"""The vendor's test of a wire, simulated: against hand calculation, refinement and what must hold for any wire."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import musclewire.extras.supply._catalogue_check as check
from musclewire.extras.supply._catalogue_check import (
    compare_catalogue,
    dead_weight_bench,
    judged_within,
    run_catalogue_test,
    time_below,
)
from musclewire.parameters import CatalogueCell, load_alloy, load_bench, load_wire

ALLOY, BENCH = load_alloy("flexinol"), load_bench("dead-weight")
WIRE = load_wire("flexinol-0.15-lt")


def test_the_weight_pulls_with_the_stress_asked_for() -> None:
    weighted = dead_weight_bench(load_bench("paper"), 254e-6, 172e6).values()
    assert weighted["pretension_n"] == pytest.approx(172e6 * math.pi / 4 * 254e-6**2)
    assert (weighted["legs"], weighted["spring_stiffness_n_per_m"], weighted["guide_friction_n"]) == (1.0, 0.0, 0.0)


def test_an_inert_wire_warms_as_the_heat_balance_says() -> None:
    """No latent heat, hardly any convection: T = T_a + I^2 R t / (m c), within what resistance changes by."""
    inert = ALLOY.with_values(latent_heat_j_per_kg=0.0)
    lonely = WIRE.with_values(convection_factor=1e-6)
    run = run_catalogue_test(inert, lonely, BENCH, 0.2)
    values = ALLOY.values()
    mass = values["density_kg_per_m3"] * math.pi / 4 * WIRE.diameter_m.value**2 * 0.14
    assert run.temperature_k - 295.15 == pytest.approx(
        run.energy_j / (mass * values["specific_heat_j_per_kg_k"]), rel=1e-6
    )
    assert run.energy_j == pytest.approx(0.2**2 * WIRE.resistance_per_metre_ohm_per_m.value * 0.14, rel=0.06)


def test_the_result_does_not_depend_on_the_step(monkeypatch: pytest.MonkeyPatch) -> None:
    coarse = run_catalogue_test(ALLOY, WIRE, BENCH, 0.41)
    monkeypatch.setattr(check, "STEP_FRACTION", 0.002)
    fine = run_catalogue_test(ALLOY, WIRE, BENCH, 0.41)
    assert coarse.contraction_fraction == pytest.approx(fine.contraction_fraction, abs=0.01)
    assert coarse.cooling_s == pytest.approx(fine.cooling_s, rel=0.01)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.05, 0.45), st.floats(1.05, 1.4))
def test_more_current_never_contracts_less_nor_more_than_the_stroke(current_a: float, factor: float) -> None:
    less, more = (run_catalogue_test(ALLOY, WIRE, BENCH, amperes) for amperes in (current_a, factor * current_a))
    # Warm martensite expands a little before it contracts.
    assert -0.01 <= less.contraction_fraction <= 1.0 + 1e-3
    assert more.temperature_k > less.temperature_k
    # Once all of it is austenite, a hotter wire only expands.
    assert more.contraction_fraction >= less.contraction_fraction - 0.02


def test_the_length_does_not_matter() -> None:
    longer = BENCH.with_values(wire_length_m=0.7)
    here, there = (run_catalogue_test(ALLOY, WIRE, bench, 0.41) for bench in (BENCH, longer))
    assert there.contraction_fraction == pytest.approx(here.contraction_fraction, rel=1e-6)
    assert there.cooling_s == pytest.approx(here.cooling_s, rel=1e-6)


def test_a_cold_wire_has_no_cooling_time() -> None:
    run = run_catalogue_test(ALLOY, WIRE, BENCH, 0.01)
    assert run.cooling_s is None
    assert run.contraction_fraction == pytest.approx(0.0, abs=1e-3)


def test_a_crossing_lies_between_the_steps_around_it() -> None:
    assert time_below(np.array([0.03, 0.01]), 0.5, 0.04, 0.02) == pytest.approx(0.75)
    assert time_below(np.array([0.01]), 0.5, 0.03, 0.02) == pytest.approx(0.25)
    assert time_below(np.array([0.03, 0.025]), 0.5, 0.04, 0.02) is None
    assert time_below(np.array([0.01]), 0.5, 0.015, 0.02) is None


CORROBORATED = CatalogueCell(value=1.0, status="corroborated", source="somebody")
UNVERIFIED = CatalogueCell(value=1.0, status="unverified")


def test_only_corroborated_cells_that_count_are_judged() -> None:
    assert judged_within(0.5, 0.8, 1.0, CORROBORATED, True, 0.0).ok is False
    assert judged_within(0.9, 0.8, 1.0, CORROBORATED, True, 0.0).ok is True
    assert judged_within(None, 0.8, 1.0, CORROBORATED, True, 0.0).ok is False
    assert judged_within(0.5, 0.8, 1.0, UNVERIFIED, True, 0.0).ok is None
    assert judged_within(0.5, 0.8, 1.0, CORROBORATED, False, 0.0).ok is None


def test_the_judged_cells_are_those_of_the_bar() -> None:
    compared = compare_catalogue()
    assert {one.wire for one in compared if one.cooling.ok is not None} == {
        f"flexinol-{size}-lt" for size in ("0.076", "0.10", "0.13", "0.15", "0.20", "0.25")
    }
    assert {one.wire for one in compared if one.contraction.ok is not None} == {
        f"flexinol-{size}-lt" for size in ("0.20", "0.31")
    }
