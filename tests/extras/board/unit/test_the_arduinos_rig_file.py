"""The Arduino's rig file says what its firmware is built with: one board, described twice, once."""

from __future__ import annotations

import re
import tomllib

import pytest
from firmware.build import mounted_wire
from tests.places import CHECKOUT

from musclewire.extras.board import SerialConfiguration, load_parts
from musclewire.rigs import rig_configuration

FOLDER = CHECKOUT / "firmware" / "boards" / "arduino-uno"
CLOCK_HZ = 16e6


def test_it_has_the_boards_channels_ranges_and_times_and_the_default_firmwares_shunt() -> None:
    board = tomllib.loads((FOLDER / "circuit.toml").read_text("utf-8"))
    rig = rig_configuration("arduino-uno")[0]
    assert isinstance(rig, SerialConfiguration)
    assert rig.wire_range == pytest.approx(board["converter_range_v"] / board["divider_share"])
    assert rig.shunt_range == pytest.approx(board["converter_range_v"] / board["shunt_gain"])
    assert rig.shunt == mounted_wire("paper-100um").shunt
    assert rig.readings_noisy is board["readings_noisy"]
    assert rig.maximum_voltage <= board["output_range_v"]
    assert rig.sample_period == board["control_period_s"]
    assert (rig.sample_period / board["tick_period_s"]) % 1 == pytest.approx(0.0)


def test_its_baud_rate_is_what_the_firmware_divides_the_clock_to() -> None:
    source = (FOLDER / "board.c").read_text("utf-8")
    found = re.search(r"#define BAUD_DIVIDER (\d+)u", source)
    assert found is not None
    rig = rig_configuration("arduino-uno")[0]
    assert isinstance(rig, SerialConfiguration)
    assert rig.baud == CLOCK_HZ / ((8 if "U2X0" in source else 16) * (int(found[1]) + 1))


def test_the_board_is_wired_as_its_firmware_reads_it() -> None:
    board, values = tomllib.loads((FOLDER / "circuit.toml").read_text("utf-8")), load_parts("board").values()
    assert mounted_wire("paper-100um").shunt == float(values["RS"].split()[0])
    assert values["U2"] == "INA180A1"
    assert (board["shunt_gain"], board["divider_share"]) == (20.0, 1.0)
    assert 1e3 * board["converter_range_v"] / board["shunt_gain"] == 250.0
