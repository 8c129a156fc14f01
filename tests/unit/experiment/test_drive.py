"""A supply or a held current through a wire: the policy holds what it should, and the numbers add up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from fake_rig import FakeRig
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import CallerError, RigError
from musclewire.experiment._drive import HeldCurrent, drive_wire
from musclewire.experiment._supply_sizing import SupplyRequest, drive_numbers, plan_supply, size_supply
from musclewire.identify import run_catalogue_test
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.rigs import open_rig
from musclewire.signals import Drive, RawSample, Recording


def test_a_held_current_is_held_on_a_rig_that_is_no_simulation() -> None:
    with FakeRig() as rig:
        run = drive_wire(rig, current_a=0.12, on_s=2.0, duration_s=4.0)
    on = (run["time_s"] > 0.11) & (run["time_s"] < 2.04)
    assert run["shunt_voltage_v"][on] == pytest.approx(0.12, rel=0.03)  # 1 ohm
    assert run["drive_voltage_v"][on].max() > 1.0
    assert np.all(run["drive_voltage_v"][run["time_s"] > 2.06] == rig.sense_voltage_v)
    assert "wire_temperature_k" not in run
    assert rig.safe_calls >= 1


@settings(max_examples=10, deadline=None)
@given(st.floats(0.05, 0.25), st.integers(0, 1000))
def test_a_held_current_is_held_on_the_simulated_rig(current_a: float, seed: int) -> None:
    with open_rig(wire="flexinol-0.10-lt", bench="dead-weight", seed=seed, maximum_voltage_v=8.0) as rig:
        run = drive_wire(rig, current_a=current_a, on_s=0.5, duration_s=0.6)
    current = run["shunt_voltage_v"] / 1.0
    assert current[2:51] == pytest.approx(current_a, rel=0.02)


def test_a_supply_is_switched_on_for_as_long_as_asked_and_the_recording_says_so() -> None:
    with open_rig(wire="flexinol-0.10-lt", bench="dead-weight") as rig:
        run = drive_wire(rig, supply_v=3.0, on_s=0.5, duration_s=1.0)
    assert np.count_nonzero(run["drive_voltage_v"] > 2.9) == 50
    assert run["drive_voltage_v"][0] < 0.5
    assert (run.metadata["supply_v"], run.metadata["on_s"]) == (3.0, 0.5)
    assert run["wire_temperature_k"].max() > run["wire_temperature_k"][0] + 10.0


def test_the_voltage_never_leaves_its_limits() -> None:
    policy = HeldCurrent(10.0, 0.3, 3.6, 1.0, 0.05, 1.0)
    decision = policy.after(RawSample(0.05, 0.3, 0.28, 0.016), 0.05)
    assert decision.command == Drive(3.6)
    policy = HeldCurrent(0.001, 0.3, 3.6, 1.0, 0.05, 1.0)
    assert policy.after(RawSample(0.05, 0.3, 0.28, 0.016), 0.05).command == Drive(0.3)


def test_a_sample_without_current_keeps_the_drive_and_five_end_the_run() -> None:
    policy = HeldCurrent(0.1, 0.3, 3.6, 1.0, 0.05, 10.0)
    no_current = RawSample(0.05, 1.7, 1.7, 0.0)
    for _ in range(4):
        assert policy.after(no_current, 0.05).command == Drive(1.7)
    with pytest.raises(RigError, match="no current"):
        policy.after(no_current, 0.05)


def test_a_broken_wire_ends_with_the_rig_at_its_sense_voltage() -> None:
    with FakeRig(dropouts=range(10, 1000)) as rig, pytest.raises(RigError, match="clamps"):
        drive_wire(rig, current_a=0.12, on_s=2.0, duration_s=4.0)
    assert rig.safe_calls >= 1


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"on_s": 1.0, "duration_s": 2.0}, "supply voltage or a current"),
        ({"on_s": 1.0, "duration_s": 2.0, "supply_v": 99.0}, "maximum"),
        ({"on_s": 1.0, "duration_s": 2.0, "supply_v": 0.1}, "sense voltage"),
        ({"on_s": 1.0, "duration_s": 2.0, "current_a": -1.0}, "above 0"),
        ({"on_s": 3.0, "duration_s": 2.0, "supply_v": 3.0}, "before the end"),
    ],
)
def test_a_drive_that_cannot_be_is_refused_before_anything_is_heated(wrong: dict[str, float], words: str) -> None:
    with FakeRig() as rig:
        with pytest.raises(CallerError, match=words):
            drive_wire(rig, **wrong)  # type: ignore[arg-type]
        assert rig.samples == 0


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
