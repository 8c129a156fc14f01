"""Where a cooling curve begins: a wire that was heated slowly, and rests."""

from __future__ import annotations

import numpy as np
import pytest
from wire_makers import constants, driven, stored_heat_j

from musclewire.errors import CallerError
from musclewire.wire import heated_state, isobaric_path

AMBIENT_K = 295.15


@pytest.mark.parametrize("temperature_k", [330.0, 365.0, 372.0, 380.0])
def test_heating_by_a_slow_current_comes_to_the_same(temperature_k: float) -> None:
    wire = constants()
    drive = np.linspace(0.5, 3.3, 40_000)
    path, _ = driven(wire, drive, 0.01, 1)
    there = int(np.argmax(path.temperature_k >= temperature_k))
    assert there > 0
    state = heated_state(wire, temperature_k)
    assert state.martensite_fraction == pytest.approx(path.martensite_fraction[there], abs=3e-3)
    assert state.contraction == pytest.approx(path.displacement_m[there] / wire.leg_length_m, abs=2e-4)
    assert state.stress_pa == pytest.approx(path.stress_pa[there], rel=2e-3)


def test_under_a_dead_weight_it_is_the_heating_branch_of_an_isobar() -> None:
    wire = constants(bench_values={"spring_stiffness_n_per_m": 0.0, "guide_friction_n": 0.0})
    stress_pa = wire.pretension_n / (wire.legs * wire.area_m2)
    kelvin = np.linspace(AMBIENT_K, 400.0, 1200)
    branch = isobaric_path(wire, stress_pa, kelvin)
    for place in (300, 700, 900, 1199):
        state = heated_state(wire, float(kelvin[place]))
        assert state.stress_pa == pytest.approx(stress_pa)
        assert state.martensite_fraction == pytest.approx(branch.martensite_fraction[place], abs=1e-9)


def test_far_above_the_transformation_there_is_austenite_only() -> None:
    """The longest tail of the grains ends 270 K above the middle one."""
    state = heated_state(constants(), 700.0)
    assert state.martensite_fraction == pytest.approx(0.0, abs=1e-9)
    assert state.temperature_k == 700.0


def test_enthalpy_belongs_to_temperature_and_phases() -> None:
    wire = constants()
    state = heated_state(wire, 370.0)
    assert state.enthalpy_j == pytest.approx(stored_heat_j(state, wire))


def test_left_to_the_air_it_cools_and_comes_back_to_where_it_began() -> None:
    wire = constants()
    path, end = driven(wire, np.zeros(3000), 1e-3, 10, state=heated_state(wire, 420.0))
    assert np.all(np.diff(path.temperature_k) <= 1e-9)
    assert end.temperature_k == pytest.approx(AMBIENT_K, abs=0.05)
    # Friction holds the wire a little short of its cold length.
    assert end.contraction == pytest.approx(0.0, abs=5e-4)


@pytest.mark.parametrize("temperature_k", [295.15, 290.0, float("nan")])
def test_a_heated_wire_is_above_the_air(temperature_k: float) -> None:
    with pytest.raises(CallerError, match="must be above the 22"):
        heated_state(constants(), temperature_k)
