"""A run beyond its alloy's data, the vendor's stress or annealing says so: in its warnings and in its metadata."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from musclewire import characterize, open_rig, pretension_sweep
from musclewire.experiment._extrapolation import extrapolation_metadata, extrapolation_warnings, reached_in
from musclewire.experiment._pretension import default_pretensions_n
from musclewire.rigs import RigConfiguration
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
    assert reached_in(run_of(0.5)).temperature_k == pytest.approx(295.0 + 0.5 / 5e-3, rel=1e-6)
    (text,) = extrapolation_warnings(run_of(1.0))
    assert "reaches 222 C, above the 200 C" in text
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
    assert extrapolation_metadata(run_of()) == {}


def test_no_pretension_above_the_vendors_limit_is_tried_or_recommended() -> None:
    straight = RigConfiguration(wire="flexinol-0.10-lt", legs=1.0, wire_length=0.14, bench="paper")
    with open_rig(straight) as rig:
        forces = default_pretensions_n(rig)
        largest_n = 172e6 * pi / 4.0 * rig.metadata()["wire_diameter_m"] ** 2
        assert 1.38 < max(forces) <= largest_n < 1.40
        sweep = pretension_sweep(rig, [0.9, 3.09], cycles=1, period_s=30.0)
    assert sweep.largest_n == pytest.approx(largest_n)
    assert sweep.best.pretension_n == 0.9
    assert any("best, 0.9 N: the wire pulls with up to" in text and "vendor's" in text for text in sweep.warnings)
