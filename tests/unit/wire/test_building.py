from __future__ import annotations

import math

import pytest
from wire_makers import alloy, bench, constants, wire_100um

from musclewire.errors import CallerError
from musclewire.wire import constants_from, resting_state, total_strain, with_pretension


def test_the_constants_are_the_geometry_of_the_wire() -> None:
    wire = constants()
    volume = math.pi / 4 * 100e-6**2 * 0.14
    assert wire.area_m2 == pytest.approx(math.pi / 4 * 100e-6**2)
    assert wire.surface_m2 == pytest.approx(math.pi * 100e-6 * 0.14)
    assert wire.heat_capacity_j_per_k == pytest.approx(volume * 6450 * 500.0)
    assert wire.latent_heat_j == pytest.approx(volume * 6450 * 20e3)
    assert wire.leg_length_m == pytest.approx(0.07)


@pytest.mark.parametrize("pretension_n", [0.0, 0.71, 1.9, 4.0])
def test_contraction_counts_from_the_cold_wire_at_its_pretension(pretension_n: float) -> None:
    wire = with_pretension(constants(), pretension_n)
    state = resting_state(wire)
    strain = total_strain(
        wire.derived.record, state.stress_pa, state.martensite_fraction, state.r_phase_fraction, state.temperature_k
    )
    assert strain == pytest.approx(wire.cold_strain, abs=1e-15)
    assert state.stress_pa == pytest.approx(pretension_n / 2 / wire.area_m2)
    # The cold wire is as long as the bench says; austenite at 20 C, which strain counts from, is shorter.
    assert wire.austenite_length_m * (1 + wire.cold_strain) == pytest.approx(wire.wire_length_m)


def test_only_a_new_wire_has_shakedown_before_it() -> None:
    settled, new = constants(), constants(new_wire=True)
    assert settled.shakedown_strain == settled.shakedown_barrier == settled.shakedown_resistivity == 0.0
    assert new.shakedown_strain > 0.0


@pytest.mark.parametrize("pretension_n", [-0.1, math.nan, math.inf])
def test_a_wire_cannot_be_pushed_nor_pulled_with_no_number(pretension_n: float) -> None:
    with pytest.raises(CallerError, match="pretension"):
        with_pretension(constants(), pretension_n)


@pytest.mark.parametrize(
    ("name", "value"),
    [("wire_length_m", 0.0), ("legs", 0.0), ("guide_friction_n", -0.1), ("guide_presliding_m", 0.0)],
)
def test_a_bench_that_cannot_be_is_the_callers_error(name: str, value: float) -> None:
    with pytest.raises(CallerError, match=f"{name} is .*: it must be|above 0"):
        constants_from(alloy(), wire_100um(), bench(**{name: value}))


@pytest.mark.parametrize(
    "wrong",
    [
        {"r_phase_spread_k": 60.0},
        {"r_phase_spread_k": 0.0},
        {"martensite_spread_k": 1.0, "martensite_spread_per_pa": 1e-7},
        {"martensite_spread_per_pa": -2e-8},
    ],
)
def test_an_r_phase_that_spreads_more_than_martensite_is_refused_with_what_to_do(wrong: dict[str, float]) -> None:
    """Two fronts describe the phases only while all three spreads are positive, at any stress."""
    with pytest.raises(CallerError, match="raise martensite_spread_k or lower r_phase_spread_k"):
        constants(**wrong)
