"""A wire that tripped and is opened again is as warm as it was: by a device's identity, in the user's state folder."""

from __future__ import annotations

import pytest
from tests.unit.rigs.ideal_wire import LIMITS, IdealWire

from musclewire.controllers import Event
from musclewire.rigs._guarded import GuardedRig, ProtectionTripError

DRIVE_V = 5.0


def heated_until_it_trips(device: IdealWire) -> GuardedRig:
    rig = GuardedRig(device)
    try:
        for _ in range(1000):
            rig.exchange(DRIVE_V)
    except ProtectionTripError as error:
        if error.event is not Event.OVER_TEMPERATURE:
            raise
        return rig
    raise AssertionError("it has not tripped")


def test_tripping_and_opening_again_heats_a_wire_no_further_than_its_limit() -> None:
    device = IdealWire(identity="board 7")
    for _ in range(6):
        heated_until_it_trips(device)
    rise_k = 0.05 * DRIVE_V**2 / 17.0 / LIMITS.heat_capacity_j_per_k
    assert device.hottest_k <= LIMITS.maximum_temperature_k + rise_k + 5.0


def test_another_device_and_one_without_an_identity_begin_cold() -> None:
    heated_until_it_trips(IdealWire(identity="board 7"))
    for other in (IdealWire(identity="board 8"), IdealWire()):
        rig = GuardedRig(other)
        assert rig.protection.temperature_k == LIMITS.ambient_temperature_k
        rig.close()


def test_a_wire_that_was_closed_warm_counts_as_warm_and_one_that_cooled_as_cold() -> None:
    # Of nearly the smallest resistance that it can have: of another one the estimate is on the safe side.
    device = IdealWire(identity="board 7", resistance_ohm=12.2)
    rig = GuardedRig(device)
    for _ in range(100):
        rig.exchange(3.0)
    rig.close()
    again = GuardedRig(device)
    assert again.protection.temperature_k == pytest.approx(device.temperature_k, abs=15.0)
    again.close()
