"""A run beyond its alloy's data, the vendor's stress or annealing says so: in its warnings and in its metadata."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from musclewire import characterize, open_rig
from musclewire.identify import extrapolation_warnings, reached_in
from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.signals import Recording

SECTION_M2 = pi / 4.0 * 1e-8


def run_of(power_w: float = 0.0, **columns: np.ndarray) -> Recording:
    """Return a recording of a wire of 0.1 mm in two legs, heated by a constant power for a minute."""
    rows = 1200
    electrical = {"wire_voltage_v": np.full(rows, power_w), "shunt_voltage_v": np.full(rows, 1.0)}
    stated = {
        "wire_diameter_m": 1e-4, "wire_length_m": 0.14, "leg_length_m": 0.07, "sample_period_s": 0.05,
        "shunt_resistance_ohm": 1.0, "limit_heat_capacity_j_per_k": 4e-3, "limit_heat_loss_w_per_k": 5e-3,
        "limit_ambient_temperature_k": 295.0, "working_stress_pa": 172e6, "covered_stress_low_pa": 45e6,
        "covered_temperature_high_k": 413.15, "annealing_temperature_k": 473.15, "pretension_n": 1.0,
    }  # fmt: skip
    return Recording({"time_s": 0.05 * np.arange(rows), **electrical, **columns}, stated)


def test_the_temperature_is_that_of_the_heat_balance() -> None:
    # A wire at 100 C loses what the protection takes it to lose, a hotter one more by the correlation.
    at_100 = run_of(5e-3 * (373.15 - 295.0))
    assert reached_in(at_100).temperature_k == pytest.approx(373.15, abs=0.3)
    hot_k = reached_in(run_of(1.1)).temperature_k
    assert hot_k is not None
    hot, reference = (convection_coefficient_w_per_m2_k(wall_k, 295.0, 1e-4) for wall_k in (hot_k, 373.15))
    assert hot / reference * 5e-3 * (hot_k - 295.0) == pytest.approx(1.1, rel=3e-3)
    (text,) = extrapolation_warnings(run_of(1.1))
    assert f"reaches {hot_k - 273.15:.0f} C, above the 200 C" in text
    undefined = run_of(1.0).with_metadata(wire_diameter_m=None)
    assert reached_in(undefined).temperature_k == pytest.approx(295.0 + 1.0 / 5e-3, rel=1e-6)
    measured = run_of(1.0, wire_temperature_k=np.full(1200, 350.0))
    assert reached_in(measured).temperature_k == 350.0


def test_stress_is_force_over_the_sections_of_both_legs() -> None:
    force = np.linspace(1.0, 3.0, 1200)
    reached = reached_in(run_of(force_n=force))
    assert reached.cold_stress_pa == pytest.approx(1.0 / (2 * SECTION_M2), rel=0.02)
    assert reached.largest_stress_pa == pytest.approx(3.0 / (2 * SECTION_M2), rel=0.02)
    # Without a load cell the pretension is known, and no more.
    assert reached_in(run_of()).largest_stress_pa == pytest.approx(1.0 / (2 * SECTION_M2))


def test_a_run_states_its_extrapolation_in_its_metadata() -> None:
    with open_rig("simulated", pretension_n=0.3) as rig:
        recording = characterize(rig, cycles=1, period_s=30.0)
    (text,) = extrapolation_warnings(recording)
    assert "below the 45 MPa" in text
    assert recording.metadata["extrapolation"] == text


def test_the_temperature_by_the_power_is_that_of_the_simulated_wire_where_it_is_hottest() -> None:
    hottest_k = 0.0
    with open_rig("simulated", wire="flexinol-0.15-lt", pretension_n=2.9) as rig:

        def on_sample(_row: object) -> None:
            nonlocal hottest_k
            hottest_k = max(hottest_k, rig.device.wire_state.temperature_k)  # type: ignore[attr-defined]  # a simulation

        loop = characterize(rig, cycles=1, on_sample=on_sample)
    assert reached_in(loop).temperature_k == pytest.approx(hottest_k, abs=2.0)
    assert extrapolation_warnings(loop) == ()
