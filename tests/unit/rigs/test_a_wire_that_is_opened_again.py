"""A wire that tripped and is opened again is as warm as it was: by a device's identity, in the user's state folder."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from tests.unit.rigs.ideal_wire import LIMITS, IdealWire

from musclewire.controllers import Event
from musclewire.errors import CallerError
from musclewire.rigs import GuardedRig, ProtectionTripError, open_rig
from musclewire.rigs._guarded import remembered_by
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


def test_a_wire_of_unknown_temperature_rests_before_it_is_heated(machine: Machine) -> None:
    machine.now = None
    device = IdealWire(identity="board 7")
    device.temperature_k = 520.0
    with GuardedRig(device) as rig:
        rest = math.ceil(5.0 * LIMITS.heat_capacity_j_per_k / LIMITS.heat_loss_w_per_k / 0.05)
        for drive_v in (0.0, rig.sense_voltage_v):  # so it rests, too
            assert rig.exchange(drive_v).drive_voltage_v == drive_v
        assert device.samples == 2
        assert rig.exchange(3.0).drive_voltage_v == 3.0
        assert device.samples == rest + 1
        rig.exchange(3.0)
        assert device.samples == rest + 2


def test_a_run_rests_before_its_time_begins(machine: Machine) -> None:
    machine.now = None
    device = IdealWire(identity="board 7")
    with GuardedRig(device) as rig:
        rig.rest()
        rest = device.samples
        rig.rest()
        rig.exchange(3.0)
    assert rest == math.ceil(5.0 * LIMITS.heat_capacity_j_per_k / LIMITS.heat_loss_w_per_k / 0.05)
    assert device.samples == rest + 1
    assert device.hottest_k <= 520.0


def test_one_whose_wire_is_new_begins_as_it_states_and_takes_no_statement() -> None:
    rig = GuardedRig(IdealWire())
    assert rig.protection.temperature_k == LIMITS.ambient_temperature_k
    rig.close()
    with pytest.raises(CallerError, match="new at each opening: leave out wire_temperature_k"):
        GuardedRig(IdealWire(), wire_temperature_k=300.0)


@pytest.mark.parametrize("wrong_k", [22.0, -1.0, math.nan, math.inf, 1600.0])
def test_a_stated_temperature_is_one_of_a_wire(wrong_k: float) -> None:
    with pytest.raises(CallerError, match=r"wire_temperature_k is .* K: give kelvins"):
        open_rig("simulated", wire_temperature_k=wrong_k)


def test_who_knows_how_warm_the_wire_is_needs_no_rest(caplog: pytest.LogCaptureFixture) -> None:
    device = IdealWire(is_new=False)
    with GuardedRig(device, wire_temperature_k=310.0) as rig:
        assert rig.protection.temperature_k == 310.0
        rig.exchange(3.0)
    assert device.samples == 1
    assert "it counts as 37 C, as stated" in caplog.text


class Bench:
    """One wire between two ways to know it, in the true time of its samples; it cools while nobody exchanges."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
        self.true_s, self.folder, self.monkeypatch = 0.0, folder, monkeypatch
        self.temperature_k = self.hottest_k = LIMITS.ambient_temperature_k
        moment = Moment("first start", 0.0, 0.0)
        kept = "musclewire.rigs._remembered_temperature"
        monkeypatch.setattr(f"{kept}.this_moment", lambda _boot=None: moment._replace(awake_s=self.now_s))
        self.device: IdealWire | None = None

    @property
    def now_s(self) -> float:
        return self.true_s + (0.0 if self.device is None else self.device.true_s)

    def heat_until_it_trips(self, known: str) -> None:
        """Open the wire as a user, at a port, of a rig file, and heat it until it trips."""
        user, port, rig_file = known.split("|")
        self.monkeypatch.setenv("MUSCLEWIRE_STATE_HOME", str(self.folder / user))
        self.device = device = IdealWire(identity=port or None, is_new=False, resistance_ohm=12.2)
        device.temperature_k = self.temperature_k
        rig = GuardedRig(device, rig_file or None)
        for _ in range(1000):
            try:
                rig.exchange(DRIVE_V)
            except ProtectionTripError:
                break
        self.temperature_k, self.hottest_k = device.temperature_k, max(self.hottest_k, device.hottest_k)
        self.true_s, self.device = self.now_s, None


WAYS = {
    "users": ("one|board 7|", "other|board 7|"),
    "ports": ("one|/dev/ttyUSB0|", "one|/dev/ttyUSB1|"),
    "rig files of an own device": ("one||rig file /a.toml", "one||rig file /b.toml"),
    "an own device with and without a rig file": ("one||rig file /a.toml", "one||"),
    "one and the same": ("one|board 7|", "one|board 7|"),
}


@pytest.mark.parametrize("order", ["ababab", "aababb", "abbaab"])
@pytest.mark.parametrize("ways", WAYS)
def test_whoever_opens_a_wire_that_others_have_heated_heats_it_no_further_than_its_limit(
    ways: str, order: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    bench = Bench(monkeypatch, tmp_path)
    for who in order:
        bench.heat_until_it_trips(WAYS[ways]["ab".index(who)])
    assert 455.0 < bench.hottest_k <= HIGHEST_K


def test_a_wire_that_was_closed_warm_counts_as_warm_and_one_that_cooled_as_cold() -> None:
    # Of nearly the smallest resistance that it can have: of another one the estimate is on the safe side.
    device = IdealWire(identity="board 7", resistance_ohm=12.2)
    rig = GuardedRig(device, wire_temperature_k=LIMITS.ambient_temperature_k)
    for _ in range(100):
        rig.exchange(3.0)
    rig.close()
    again = GuardedRig(device)
    assert again.protection.temperature_k == pytest.approx(device.temperature_k, abs=15.0)
    again.close()
