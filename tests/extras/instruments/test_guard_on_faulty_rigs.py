"""The guard around a faulty rig: what it holds, and what it says of a device that is gone or an output that stays."""

from __future__ import annotations

import pytest

from musclewire.controllers import Event, State
from musclewire.errors import RigError
from musclewire.rigs import GuardedRig, ProtectionTripError, RigConfiguration, open_rig


def faulty(**fault: object) -> RigConfiguration:
    return RigConfiguration.model_validate({"fault": [fault]})


def hold(rig: GuardedRig, voltage_v: float, samples: int) -> None:
    for _ in range(samples):
        rig.exchange(voltage_v)


def test_what_was_held_before_a_rig_was_made_safe_is_not_put_out_again_after_it() -> None:
    with open_rig(faulty(kind="reading_not_finite", at=1.0, lasts=0.08)) as rig:
        while rig.protection.state is not State.HOLD:
            rig.exchange(rig.drive_amplitude_v)
        rig.make_safe()
        assert rig.exchange(0.0).drive_voltage_v == pytest.approx(rig.sense_voltage_v, abs=1e-3)
        hold(rig, 0.0, 2)
        assert rig.exchange(0.0).drive_voltage_v == 0.0


def test_what_is_missing_goes_on_counting_through_a_pause() -> None:
    with open_rig(faulty(kind="reading_not_finite", at=1.0)) as rig:
        while rig.protection.state is not State.HOLD:
            rig.exchange(rig.drive_amplitude_v)
        for _ in range(3):
            rig.make_safe()
            rig.exchange(rig.drive_amplitude_v)
        rig.make_safe()
        with pytest.raises(ProtectionTripError) as caught:
            rig.exchange(rig.drive_amplitude_v)
        assert caught.value.event is Event.READING_NOT_FINITE
        assert (rig.drive_voltage_v, rig.protection.state) == (0.0, State.TRIPPED)


def test_nobody_says_that_a_lost_device_is_off() -> None:
    rig = open_rig(faulty(kind="device_lost", at=0.5))
    with pytest.raises(ProtectionTripError) as caught:
        hold(rig, rig.sense_voltage_v, 20)
    assert caught.value.event is Event.DEVICE_LOST
    assert "nothing confirms" in str(caught.value)
    assert not rig.off_confirmed


def test_a_run_that_ends_on_a_device_that_is_gone_says_so() -> None:
    rig = open_rig(faulty(kind="device_lost", at=0.09))
    hold(rig, rig.sense_voltage_v, 2)
    with pytest.raises(RigError, match="nothing confirms it"), rig:
        pass
    assert not rig.off_confirmed
    assert rig.protection.state is State.OFF


def test_an_output_that_is_stuck_is_not_called_off() -> None:
    rig = open_rig(faulty(kind="output_stuck", at=0.5))
    with pytest.raises(ProtectionTripError, match="CUT THE POWER") as caught:
        hold(rig, rig.sense_voltage_v, 20)
    assert caught.value.event is Event.OUTPUT_STUCK
    with pytest.raises(RigError):  # for good
        rig.exchange(0.0)


def test_a_trip_says_how_warm_the_wire_is_estimated_to_be() -> None:
    with open_rig(faulty(kind="wire_open", at=1.0)) as rig:
        with pytest.raises(ProtectionTripError) as tripped:
            hold(rig, rig.drive_amplitude_v, 100)
        degc = rig.protection.temperature_k - 273.15
        assert 20.0 < degc < 200.0
        assert f"estimated {degc:.0f} C" in str(tripped.value)
        assert (tripped.value.event, rig.drive_voltage_v) == (Event.WIRE_OPEN, 0.0)
