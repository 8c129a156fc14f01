"""The supply of a wire: the simulated drive agrees with the fast test, and its numbers add up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from musclewire.errors import RecordingError
from musclewire.extras.supply._catalogue_check import run_catalogue_test
from musclewire.extras.supply._sizing import SupplyRequest, drive_numbers, plan_supply, size_supply
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.signals import MetadataValue, Recording


@pytest.mark.parametrize("name", ["flexinol-0.050-lt", "flexinol-0.10-ht", "flexinol-0.25-lt"])
def test_the_rig_and_the_fast_test_agree(name: str) -> None:
    """The same second at the catalogue's current, sample by sample with instruments and in one compiled call."""
    answer = size_supply(SupplyRequest(name))
    fast = run_catalogue_test(
        load_alloy("flexinol"), load_wire(name), load_bench("dead-weight"), answer.plan.row.current_a
    )
    assert answer.numbers.contraction == pytest.approx(fast.contraction, abs=0.01 * fast.stroke)
    assert answer.numbers.cooling_s == pytest.approx(fast.cooling_s, rel=0.02, abs=0.02)
    assert answer.numbers.temperature_peak_k == pytest.approx(fast.temperature_k, abs=1.0)
    assert answer.numbers.energy_j == pytest.approx(fast.energy_j, rel=0.01)


def test_the_wire_gets_no_more_energy_than_the_supply_gives() -> None:
    answer = size_supply(SupplyRequest("flexinol-0.15-lt", supply_v=3.0))
    run = answer.recording
    given_j = float(np.sum(run["drive_voltage_v"] * run["shunt_voltage_v"]) / answer.plan.shunt_ohm * 0.01)
    assert 0.9 * given_j < answer.numbers.energy_j < given_j


def test_the_supply_named_for_one_second_does_it_in_one_second() -> None:
    """The current is named for a source that holds it; a plain supply of that voltage gives a little more."""
    for name in ("flexinol-0.076-ht", "flexinol-0.20-lt"):
        first = size_supply(SupplyRequest(name))
        again = size_supply(
            SupplyRequest(name, supply_v=first.supply_needed_v, shunt_ohm=first.shunt.resistance_ohm, on_s=1.2)
        )
        assert again.numbers.contracted_s is not None
        assert 0.6 < again.numbers.contracted_s < 1.02


def test_half_the_load_of_a_spring_gives_half_the_cold_stress() -> None:
    plan = plan_supply(SupplyRequest("flexinol-0.10-lt", stress_pa=86e6, spring_n_per_m=100.0))
    assert plan.load_n == pytest.approx(86e6 * math.pi / 4 * (101.6e-6) ** 2)
    assert plan.configuration.settings["spring_stiffness_n_per_m"] == 100.0


def test_the_numbers_of_a_drive_known_by_heart() -> None:
    """Ten samples of 0.1 s, on during the second to sixth: 2 A through 3 ohm; it creeps back by 1 % a sample."""
    time_s = 0.1 * np.arange(1, 11)
    on = (time_s > 0.11) & (time_s < 0.61)
    run = Recording(
        {
            "time_s": time_s,
            "drive_voltage_v": np.where(on, 8.0, 0.1),
            "wire_voltage_v": np.where(on, 6.0, 0.0),
            "shunt_voltage_v": np.where(on, 2.0, 0.0),
            "displacement_m": 0.1 * np.array([0.0, 0.01, 0.02, 0.03, 0.04, 0.04, 0.03, 0.02, 0.01, 0.0]),
            "wire_temperature_k": 300.0 + 50.0 * on,
        },
        {"sample_period_s": 0.1, "leg_length_m": 0.1, "shunt_resistance_ohm": 1.0},
    )
    numbers = drive_numbers(run, 0.5, 0.04)
    assert numbers.contraction == pytest.approx(0.04)
    assert numbers.contracted_s == pytest.approx(0.4)
    assert numbers.cooling_s == pytest.approx(0.4)
    assert numbers.current_mean_a == pytest.approx(2.0)
    assert numbers.energy_j == pytest.approx(6.0)
    assert numbers.power_end_w == pytest.approx(12.0)
    assert numbers.temperature_peak_k == 350.0
    assert not numbers.melted


@pytest.mark.parametrize("missing", ["sample_period_s", "leg_length_m", "shunt_resistance_ohm"])
def test_a_fact_that_the_numbers_need_is_asked_for(missing: str) -> None:
    time_s = 0.05 * np.arange(1, 41)
    columns = ("drive_voltage_v", "wire_voltage_v", "shunt_voltage_v", "displacement_m", "wire_temperature_k")
    facts: dict[str, MetadataValue] = {"sample_period_s": 0.05, "leg_length_m": 0.07, "shunt_resistance_ohm": 1.0}
    run = Recording(
        {"time_s": time_s, **dict.fromkeys(columns, np.ones(40))},
        {name: value for name, value in facts.items() if name != missing},
    )
    with pytest.raises(RecordingError, match=missing):
        drive_numbers(run, 1.0, 0.03)
