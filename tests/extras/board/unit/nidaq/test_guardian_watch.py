"""How long a host may be silent: the watch has no clock, so hours of silence are tested in no time."""

from __future__ import annotations

import pytest

from musclewire.extras.board._nidaq.driver import OutputSettings
from musclewire.extras.board._nidaq.guardian import LOOK_S, GuardianOrders, SilenceWatch

OUTPUT = OutputSettings("Dev1", "127.0.0.1:1", "ao0", 10.0, None)
ORDERS = GuardianOrders(OUTPUT, 1.0, 0.0, 0.3, sense_after_s=0.1, trip_after_s=0.25)


def heard(drive_v: float) -> SilenceWatch:
    watch = SilenceWatch(ORDERS)
    watch.note(100.0, drive_v)
    return watch


def test_a_driven_wire_goes_to_the_sense_voltage_and_then_off() -> None:
    watch = heard(2.0)
    assert watch.due(100.099) is None
    assert watch.due(100.101) == 0.3
    assert watch.due(100.2) is None
    assert watch.due(100.251) == 0.0
    assert watch.tripped_after_s == pytest.approx(0.251)


def test_it_is_off_as_soon_as_the_silence_is_as_long_as_was_ordered() -> None:
    watch = heard(2.0)
    assert watch.due(100.0 + ORDERS.trip_after_s) == 0.0


def test_a_sign_of_life_renews_the_time() -> None:
    watch = heard(2.0)
    for step in range(1, 100):
        watch.note(100.0 + 0.09 * step)
        assert watch.due(100.0 + 0.09 * step + 0.05) is None


def test_a_command_after_the_sense_voltage_drives_again_and_a_sign_of_life_does_not() -> None:
    watch = heard(2.0)
    assert watch.due(100.15) == 0.3
    watch.note(100.16)
    assert watch.watching
    watch.note(100.17, 2.0)
    assert watch.due(100.2) is None


def test_every_stall_leads_to_the_sense_voltage_and_not_only_the_first() -> None:
    watch = heard(2.0)
    assert [watch.due(100.15), watch.due(100.2)] == [0.3, None]
    watch.note(100.21, 2.0)
    assert [watch.due(100.3), watch.due(100.32), watch.due(100.4)] == [None, 0.3, None]
    assert watch.due(100.47) == 0.0


@pytest.mark.parametrize("drive_v", [0.0, 0.1, 0.3])
def test_at_the_sense_voltage_and_below_silence_harms_nothing(drive_v: float) -> None:
    watch = heard(drive_v)
    assert watch.due(1e6) is None
    assert watch.left_s(1e6) == LOOK_S


def test_a_very_long_silence_goes_off_at_once_and_stays_so() -> None:
    watch = heard(2.0)
    assert watch.due(200.0) == 0.0
    assert watch.due(201.0) is None
    assert not watch.watching


def test_the_wait_ends_when_something_is_due() -> None:
    watch = heard(2.0)
    assert watch.left_s(100.0) == pytest.approx(LOOK_S)
    assert watch.left_s(100.09) == pytest.approx(0.01)
    assert watch.left_s(100.5) == 0.0
