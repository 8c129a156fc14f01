"""A wire on a board or a card that trips and is opened again at once, many times, is heated no further than its limit.

The wire outlives the opening, as a real one does; its time is that of the clock.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

import pytest
from emulation.board import EmulatedBoard
from emulation.daq_bench import WiredRig, card_of
from emulation.daq_server import DaqServer
from tests.extras.board.contract.nidaq_rigs import wiring_of
from tests.extras.board.contract.serial_rigs import BOARD, COLD_K, built_firmware, mounted, require_board

from musclewire.controllers import Event, largest_power_w_per_v2, protection_table
from musclewire.extras.board import NiDaqConfiguration
from musclewire.rigs import DeviceConfiguration, GuardedRig, ProtectionTripError, open_rig

pytestmark = pytest.mark.emulated

LIMIT_K = 345.0
OPENINGS, MAX_OPENINGS = 6, 20


def heated_until_it_trips(rig: GuardedRig) -> bool:
    """Heat a wire until it trips; false if it was for a machine that is busy with other tests."""
    try:
        for _ in range(400):
            rig.exchange(rig.maximum_voltage_v)
    except ProtectionTripError as error:
        if error.event in (Event.SAMPLE_LATE, Event.COMMAND_MISSING):
            return False
        if error.event is not Event.OVER_TEMPERATURE:
            raise
        return True
    raise AssertionError("it has not tripped")


def hottest_allowed_k(rig: GuardedRig) -> float:
    """The limit, what the largest drive adds in one sample and ``sense_after_s``, and 5 K."""
    limits = rig.protection_limits
    rise_k_per_s = largest_power_w_per_v2(limits) * limits.maximum_voltage_v**2 / limits.heat_capacity_j_per_k
    return LIMIT_K + (rig.sample_period_s + protection_table().sense_after_s) * rise_k_per_s + 5.0


def open_again_and_again(configuration: DeviceConfiguration, hottest_k: Callable[[], float]) -> None:
    trips, openings = 0, 0
    while trips < OPENINGS and openings < MAX_OPENINGS:
        rig = open_rig(configuration.model_copy())  # a copied rig file is of the same device
        openings, trips = openings + 1, trips + heated_until_it_trips(rig)
        print(f"hottest so far: {hottest_k():.1f} K, allowed {hottest_allowed_k(rig):.1f} K")
        assert hottest_k() <= hottest_allowed_k(rig)
    assert trips == OPENINGS


def test_on_a_card() -> None:
    wiring = wiring_of("ni-usb-6001").model_dump()
    wiring["limits"] = {"maximum_temperature": LIMIT_K}
    card = card_of(NiDaqConfiguration.model_validate(wiring), paced=True)
    wired = card._terminals
    assert isinstance(wired, WiredRig)
    temperatures_k = [0.0]
    advance = wired.advance

    def noted(outputs_v: dict[str, float]) -> dict[str, float]:
        found = advance(outputs_v)
        temperatures_k[0] = max(temperatures_k[0], wired.device.wire_state.temperature_k)
        return found

    wired.advance = noted  # type: ignore[method-assign]
    server = DaqServer(card)
    try:
        configuration = NiDaqConfiguration.model_validate({**wiring, "grpc": server.address})
        open_again_and_again(configuration, lambda: temperatures_k[0])
    finally:
        server.close()


def test_a_board_whose_host_thinks_rests_and_goes_on(caplog: pytest.LogCaptureFixture) -> None:
    require_board()
    with (
        EmulatedBoard(board=BOARD, pace="clock", elf=built_firmware()) as board,
        open_rig(mounted(board.port_url), wire_temperature_k=COLD_K) as rig,
    ):
        for _ in range(5):
            rig.exchange(3.0)
        time.sleep(1.0)
        assert rig.drive_voltage_v <= rig.sense_voltage_v
        with caplog.at_level(logging.WARNING, logger="musclewire.rigs"):
            samples = [rig.exchange(3.0) for _ in range(5)]
        assert "nobody talked to the rig" in caplog.text
        assert samples[-1].drive_voltage_v == pytest.approx(3.0, abs=0.05)


def test_on_a_board() -> None:
    require_board()
    with EmulatedBoard(board=BOARD, pace="clock", elf=built_firmware()) as board:
        configuration = mounted(board.port_url, limits={"maximum_temperature": LIMIT_K})
        open_again_and_again(configuration, lambda: float(board.log()["temperature_k"].max()))
