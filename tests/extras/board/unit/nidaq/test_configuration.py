"""What a nidaq rig file may say, and what is said of a wrong one."""

from __future__ import annotations

from typing import Any

import pytest

from musclewire.errors import CallerError
from musclewire.extras.board import NiDaqConfiguration
from musclewire.parameters import validated
from musclewire.rigs import rig_configuration

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
