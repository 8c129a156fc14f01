"""The Arduino's rig file says what its firmware is built with: one board, described twice, once."""

from __future__ import annotations

import re
import tomllib

import pytest
from tests.places import CHECKOUT

from musclewire.extras.board._parts import load_parts
from musclewire.extras.board._serial.configuration import SerialConfiguration
from musclewire.rigs import rig_configuration

FOLDER = CHECKOUT / "firmware" / "boards" / "arduino-uno"
CLOCK_HZ = 16e6


@pytest.fixture
def board() -> dict[str, float | bool]:
    return tomllib.loads((FOLDER / "board.toml").read_text("utf-8"))


@pytest.fixture
def rig() -> SerialConfiguration:
    configuration, _ = rig_configuration("arduino-uno")
    assert isinstance(configuration, SerialConfiguration)
    return configuration


def test_its_channels_and_shunt_are_the_boards(rig: SerialConfiguration, board: dict[str, float | bool]) -> None:
    assert rig.wire_range == pytest.approx(board["converter_range_v"] / board["divider_share"])
    assert rig.shunt_range == pytest.approx(board["converter_range_v"] / board["shunt_gain"])
    assert rig.shunt == board["shunt_resistance_ohm"]
    assert rig.readings_noisy is board["readings_noisy"]


def test_it_asks_for_no_more_than_the_board_puts_out(rig: SerialConfiguration, board: dict[str, float | bool]) -> None:
    assert rig.maximum_voltage <= board["output_range_v"]


def test_its_sample_period_is_the_boards_control_period(
    rig: SerialConfiguration, board: dict[str, float | bool]
) -> None:
    assert rig.sample_period == board["control_period_s"]
    assert (rig.sample_period / board["tick_period_s"]) % 1 == pytest.approx(0.0)


def test_its_baud_rate_is_what_the_firmware_divides_the_clock_to(rig: SerialConfiguration) -> None:
    source = (FOLDER / "board.c").read_text("utf-8")
    found = re.search(r"#define BAUD_DIVIDER (\d+)u", source)
    assert found is not None
    doubled = "U2X0" in source
    assert rig.baud == CLOCK_HZ / ((8 if doubled else 16) * (int(found[1]) + 1))


def test_the_board_is_wired_as_its_firmware_reads_it() -> None:
    file = CHECKOUT / "firmware/boards/arduino-uno/board.toml"
    board, values = tomllib.loads(file.read_text("utf-8")), load_parts("board").values()
    assert board["shunt_resistance_ohm"] == float(values["RS"].split()[0])
    assert values["U2"] == "INA180A1"
    assert (board["shunt_gain"], board["divider_share"]) == (20.0, 1.0)
    assert 1e3 * board["converter_range_v"] / board["shunt_gain"] == 250.0
