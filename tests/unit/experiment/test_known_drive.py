"""A drive that is known beforehand, in compiled code: the recording and the rig are those of the loop in Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from musclewire.errors import NumericsError, RigError
from musclewire.experiment import characterize, drive_wire
from musclewire.rigs import GuardedRig, HasStage, HasTrueState, RigConfiguration, ability, open_rig
from musclewire.signals import Recording

DRAUGHTY = {"draught": 0.1, "ambient_swing": 2.0}
# What only one of both ways to take samples states.
HOW_TAKEN = ("compiled_loop", "not_compiled", "start_time")


def seen(_row: object) -> None:
    """A callback that sees every sample: with it the loop in Python runs."""


def assert_same(compiled: Recording, in_python: Recording) -> None:
    """Assert that two recordings have the same numbers, to the bit, and state the same but for how they were taken."""
    assert compiled.names == in_python.names
    for name in compiled.names:
        np.testing.assert_array_equal(compiled[name], in_python[name], err_msg=name, strict=True)
    one, other = (
        {key: value for key, value in run.metadata.items() if not key.startswith("compute_") and key not in HOW_TAKEN}
        for run in (compiled, in_python)
    )
    assert one == other


def assert_same_rigs(one: GuardedRig, other: GuardedRig) -> None:
    """Assert that two rigs are in the same state, and that what they do next is the same."""
    assert one.protection == other.protection
    assert one.drive_voltage_v == other.drive_voltage_v
    assert one.metadata() == other.metadata()
    for _ in range(3):
        assert one.exchange(1.7) == other.exchange(1.7)
    states = [ability(rig, HasTrueState).wire_state.numbers for rig in (one, other)]
    np.testing.assert_array_equal(*states)


def both(run: Callable[..., Recording], rigs: tuple[GuardedRig, GuardedRig]) -> str:
    """Assert that a run is the same in compiled code and in Python; return why it was not compiled."""
    compiled, in_python = run(rigs[0]), run(rigs[1], on_sample=seen)
    assert_same(compiled, in_python)
    assert "compiled_loop" not in in_python.metadata
    assert compiled.metadata.get("compiled_loop", False) != ("not_compiled" in compiled.metadata)
    return str(compiled.metadata.get("not_compiled", ""))


def two_rigs(name: Any, **settings: Any) -> tuple[GuardedRig, GuardedRig]:
    """Open the same rig twice."""
    return open_rig(name, **settings), open_rig(name, **settings)


def short_sine(rig: GuardedRig, **options: Any) -> Recording:
    return characterize(rig, period_s=12.0, cycles=2, **options)


@pytest.mark.parametrize(
    "rig",
    [
        RigConfiguration(wire="paper-100um"),
        RigConfiguration(wire="paper-100um", new_wire=True),
        RigConfiguration(wire="paper-100um", surroundings=DRAUGHTY),
        RigConfiguration(wire="paper-100um", settings={"sample_period_s": 0.005, "time_step_s": 0.001}),
        "finger",
    ],
    ids=["simulated", "new wire", "moving air", "fast samples, fixed steps", "finger"],
)
def test_runs_one_after_another_and_the_rig_after_them_are_those_of_the_loop_in_python(rig: Any) -> None:
    rigs = two_rigs(rig, seed=5)
    assert both(short_sine, rigs) == ""
    assert both(lambda rig, **options: drive_wire(rig, on_s=2.0, duration_s=5.0, supply_v=1.9, **options), rigs) == ""
    for rig in rigs:
        ability(rig, HasStage).set_pretension(0.9)
    assert both(short_sine, rigs) == ""
    assert_same_rigs(*rigs)


def trips(rig: GuardedRig, **options: Any) -> RigError:
    with pytest.raises(RigError) as caught:
        short_sine(rig, **options)
    assert not rig.drive_voltage_v
    return caught.value


def test_a_trip_on_the_way_is_that_of_the_loop_in_python_and_the_recording_says_what_stopped_the_compiled_run() -> None:
    limits = {"maximum_temperature": 330.0}
    compiled, in_python = (
        trips(rig, **options)
        for rig, options in zip(
            two_rigs(RigConfiguration(wire="paper-100um", limits=limits)), ({}, {"on_sample": seen}), strict=True
        )
    )
    assert str(compiled) == str(in_python)
    assert_same(compiled.recording, in_python.recording)
    assert compiled.recording.metadata["not_compiled"].startswith("reading not sound at sample ")


def test_steps_that_do_not_resolve_the_wire_end_as_in_python() -> None:
    messages = []
    for rig, options in zip(
        two_rigs("simulated", sample_period_s=2.0, time_step_s=2.0), ({}, {"on_sample": seen}), strict=True
    ):
        with pytest.raises((NumericsError, RigError)) as caught:
            drive_wire(rig, on_s=30.0, duration_s=60.0, supply_v=rig.maximum_voltage_v, **options)
        messages.append(str(caught.value))
    assert messages[0] == messages[1]
