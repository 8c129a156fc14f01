"""Rig files of boards and cards that come with musclewire, and what is refused of one."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from firmware.build import mounted_wire
from tests.places import CHECKOUT, included_rig_file

from musclewire.errors import CallerError
from musclewire.extras.board import NiDaqConfiguration, SerialConfiguration, load_parts
from musclewire.parameters import validated
from musclewire.rigs import open_rig, read_rig_file, rig_configuration

# The Arduino's rig file says what its firmware is built with: one board, described twice, once.

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


# The rig file of a board that comes with musclewire, and what is refused of one.


def test_air_in_degrees_without_a_unit_is_refused_because_it_would_let_the_wire_grow_too_hot(tmp_path: Path) -> None:
    board, path = included_rig_file("serial-board").read_text("utf-8"), tmp_path / "my_rig.toml"
    path.write_text("ambient_temperature = 22\n" + board, "utf-8")
    with pytest.raises(CallerError, match=r"ambient_temperature: must be 223.15 K or more, not 22"):
        read_rig_file(path)
    path.write_text('ambient_temperature = "22 degC"\n' + board, "utf-8")
    assert read_rig_file(path).ambient_temperature == 295.15  # type: ignore[union-attr]


def test_the_clock_of_a_board_cannot_be_made_faster() -> None:
    with pytest.raises(CallerError, match="is not simulated, its clock runs as it does"):
        open_rig("serial-board", clock_speed=10.0)


# What a nidaq rig file may say, and what is said of a wrong one.

NAMES = ("ni-pci-6229", "ni-usb-6001")


def content(name: str = "ni-usb-6001") -> dict[str, Any]:
    """Return a shipped rig file's content, to be changed."""
    configuration = rig_configuration(name)[0]
    assert isinstance(configuration, NiDaqConfiguration)
    return configuration.model_dump()


def refused(data: dict[str, Any]) -> str:
    with pytest.raises(CallerError) as caught:
        validated(NiDaqConfiguration, data, "rig file bench.toml")
    return str(caught.value)


@pytest.mark.parametrize("name", NAMES)
def test_the_rig_files_that_come_along_are_right(name: str) -> None:
    data = content(name)
    configuration = validated(NiDaqConfiguration, data, name)
    assert configuration.layout().period == 50
    assert list(configuration.inputs.wired()) == ["wire_voltage", "shunt_voltage", "displacement", "force"]


def test_quantities_take_units() -> None:
    data = content()
    data["reading_rate"], data["inputs"]["displacement"]["scale"] = "2 kHz", "2.5 mm/V"
    data["inputs"]["force"]["scale"] = "500 mN/V"
    data["readings"] = 80
    configuration = validated(NiDaqConfiguration, data, "rig")
    assert configuration.reading_rate == 2000.0
    assert configuration.inputs.displacement is not None
    assert configuration.inputs.displacement.rule.quantity(2.0) == pytest.approx(5e-3)
    assert configuration.inputs.force is not None
    assert configuration.inputs.force.rule.quantity(2.0) == pytest.approx(1.0)


def test_instruments_may_be_left_out() -> None:
    data = content()
    data["inputs"] = {name: data["inputs"][name] for name in ("wire_voltage", "shunt_voltage")}
    assert list(validated(NiDaqConfiguration, data, "rig").inputs.wired()) == ["wire_voltage", "shunt_voltage"]


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({"reading": 40}, "did you mean 'readings'?"),
        ({"readings": 50}, "no time to decide"),
        ({"output": {"channel": "ao0", "range": "2 V"}}, "outside its range of 2 V"),
        ({"output": {"channel": "ao0", "gain": 0.1}}, "needs 44 V at ao0"),
        ({"output": {"channel": "Dev1/ao0"}}, "output.channel"),
        ({"sense_voltage": "4 V"}, "must rise in this order"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(changed: dict[str, Any], expected: str) -> None:
    assert expected in refused({**content(), **changed})


@pytest.mark.parametrize(
    ("name", "key", "value", "expected"),
    [
        ("wire_voltage", "gain", 0.0, "inputs.wire_voltage.gain"),
        ("displacement", "scale", 0.0, "inputs.displacement"),
        ("shunt_voltage", "channel", "ai0", "the channel ai0 is named for two inputs"),
        ("wire_voltage", "terminals", "RSE", "did you mean 'terminal'?"),
    ],
)
def test_a_wrong_input_is_named(name: str, key: str, value: object, expected: str) -> None:
    data = content()
    data["inputs"][name][key] = value
    assert expected in refused(data)
