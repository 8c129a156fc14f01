"""A supply or a held current through a wire: the policy holds what it should."""

from __future__ import annotations

import numpy as np
import pytest
from fake_rig import FakeRig
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.errors import CallerError, RigError
from musclewire.experiment import drive_wire
from musclewire.rigs import open_rig


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
