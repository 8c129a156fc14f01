"""A wire that tripped and is opened again is as warm as it was: by a device's identity, in the user's state folder."""

from __future__ import annotations

import math

import pytest
from tests.unit.rigs.ideal_wire import LIMITS, IdealWire

from musclewire.controllers import Event
from musclewire.rigs._guarded import GuardedRig, ProtectionTripError, remembered_by
from musclewire.rigs._remembered_temperature import Moment

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


class Machine:
    """The start of a machine whose time a test sets; a wire in memory does not cool while nobody exchanges."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now: Moment | None = Moment("first start", 4000.0, 0.0)
        monkeypatch.setattr("musclewire.rigs._remembered_temperature.this_moment", lambda _boot=None: self.now)


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    return Machine(monkeypatch)


RISE_K = 0.05 * DRIVE_V**2 / 17.0 / LIMITS.heat_capacity_j_per_k
HIGHEST_K = LIMITS.maximum_temperature_k + RISE_K + 5.0
NOWS = {
    "same": lambda _: Moment("first start", 4000.0, 0.0),
    "another start each time": lambda number: Moment(f"start {number}", 4000.0, 0.0),
    "a sleep each time": lambda number: Moment("first start", 4000.0, 3600.0 * number),
    "no start": lambda _: None,
}


@pytest.mark.parametrize("identity", ["board 7", None])
@pytest.mark.parametrize("which", NOWS)
def test_tripping_and_opening_again_heats_a_wire_no_further_than_its_limit(
    which: str, identity: str | None, machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever clocks and starts say, also a device that says nothing of itself; the time of day is not asked."""
    device = IdealWire(identity=identity, is_new=False)
    days = iter(range(10**9))
    monkeypatch.setattr("time.time", lambda: 86400.0 * next(days))
    for number in range(6):
        machine.now = NOWS[which](number)
        heated_until_it_trips(device)
    assert device.hottest_k <= HIGHEST_K


def test_a_device_without_an_identity_is_known_by_its_rig_file_else_by_its_class_and_it_is_said(
    machine: Machine, caplog: pytest.LogCaptureFixture
) -> None:
    device = IdealWire(is_new=False)
    assert remembered_by(device, "rig file /a.toml") == "rig file /a.toml"
    assert remembered_by(device, None) == f"class {IdealWire.__module__}.IdealWire"
    assert remembered_by(IdealWire(identity="board 7"), "rig file /a.toml") == "board 7"
    assert remembered_by(IdealWire(), "rig file /a.toml") is None
    machine.now = None
    GuardedRig(device).close()
    assert "for want of an identity of its own it is known again by class" in caplog.text
    assert "rests at its sense voltage for" in caplog.text


def test_a_wire_of_unknown_temperature_rests_before_it_is_heated_and_0_v_needs_no_rest(machine: Machine) -> None:
    machine.now = None
    device = IdealWire(identity="board 7")
    device.temperature_k = 520.0
    with GuardedRig(device) as rig:
        rest = math.ceil(5.0 * LIMITS.heat_capacity_j_per_k / LIMITS.heat_loss_w_per_k / 0.05)
        rig.exchange(0.0)
        assert device.samples == 1
        assert rig.exchange(3.0).drive_voltage_v == 3.0
        assert device.samples == 1 + rest + 1
        rig.exchange(3.0)
        assert device.samples == 1 + rest + 2
    assert device.hottest_k <= 520.0


def test_another_device_and_one_whose_wire_is_new_begin_cold(machine: Machine) -> None:
    assert machine.now is not None
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
