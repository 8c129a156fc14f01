"""What no wire of the catalogue has or survives is refused, with what is wrong and how to confirm it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from musclewire.errors import CallerError
from musclewire.parameters import load_catalogue, load_wire, validated
from musclewire.rigs import (
    MountedWire,
    RigConfiguration,
    StatedCircuit,
    beyond_catalogue,
    confirmed_beyond,
    open_rig,
    read_rig_file,
    refuse_beyond_catalogue,
    shipped_rig_files,
)

MOUNTED = {"wire": "paper-100um", "wire_length": "14 cm", "shunt": "1 ohm", "sense_voltage": "0.1 V"}
BEYOND = [
    ({"wire_length": 60}, "wire_length 60 m is outside 0.002 to 10 m"),
    ({"wire_length": "60 m"}, "wire_length 60 m"),
    ({"wire_length": "1.5 mm"}, r"wire_length 0\.0015 m"),
    ({"maximum_voltage": "60 V"}, "maximum_voltage 60 V"),
    ({"limits": {"maximum_temperature": 5000.0}}, "maximum_temperature_k 5000 K is outside 0 to 573 K"),
    ({"limits": {"maximum_current": "1000 A"}}, "maximum_current_a 1000 A"),
    ({"limits": {"maximum_power": "5 kW"}}, "maximum_power_w 5000 W"),
    ({"limits": {"resistance_low": "1 mohm"}}, r"resistance_low_ohm 0\.001 ohm"),
    ({"limits": {"resistance_high": "1 Gohm"}}, r"resistance_high_ohm 1e\+09 ohm"),
]


@pytest.mark.parametrize(("keys", "words"), BEYOND)
def test_it_is_refused_on_every_kind_of_rig_and_taken_when_confirmed(keys: dict[str, Any], words: str) -> None:
    way_out = "if it is meant so, give beyond_catalogue=True, or write beyond_catalogue = true in the rig file"
    with pytest.raises(CallerError, match=words) as refused:
        open_rig(RigConfiguration(**keys))
    assert way_out in str(refused.value)
    with pytest.raises(CallerError, match=words) as refused:
        validated(MountedWire, {**MOUNTED, **keys}, "rig file bench.toml")
    assert str(refused.value).startswith("rig file bench.toml")
    assert way_out in str(refused.value)
    assert validated(MountedWire, {**MOUNTED, **keys, "beyond_catalogue": True}, "rig file").beyond_catalogue


def test_a_call_confirms_it_for_a_rig_and_a_command_for_all_that_it_starts() -> None:
    hot = RigConfiguration(limits={"maximum_temperature": 5000.0})
    with open_rig(hot, beyond_catalogue=True) as rig:
        assert rig.protection_limits.maximum_temperature_k == 5000.0
    assert not confirmed_beyond()
    with beyond_catalogue(True):
        assert confirmed_beyond()
        with beyond_catalogue(False):
            assert confirmed_beyond()
        open_rig(hot).close()
    assert not confirmed_beyond()
    with open_rig(RigConfiguration(beyond_catalogue=True, maximum_voltage="60 V")) as rig:
        assert rig.maximum_voltage_v == 60.0


@pytest.mark.parametrize("key", ["wire_length", "maximum_voltage", "pretension", "ambient_temperature", "shunt"])
def test_true_is_no_number_even_when_confirmed(key: str) -> None:
    for keys in ({key: True}, {"settings": {"wire_length_m": True}}):
        with pytest.raises(CallerError, match="true is no number"):
            validated(RigConfiguration, {**keys, "beyond_catalogue": True}, "rig file")
    with pytest.raises(CallerError, match="true, which is no number"):
        open_rig("simulated", wire_length_m=True)


def test_a_setting_of_the_call_is_judged_as_well() -> None:
    with pytest.raises(CallerError, match="wire_length 60 m"):
        open_rig("simulated", wire_length_m=60.0)
    with pytest.raises(CallerError, match=r"diameter_m 0\.1 m"):
        open_rig("simulated", diameter_m=0.1)


@pytest.mark.parametrize("row", load_catalogue().row, ids=lambda row: row.name)
def test_every_size_of_the_catalogue_is_within_with_its_own_current_power_and_resistance(row: Any) -> None:
    ohm = row.resistance_ohm_per_m.value * 0.14
    volts = load_wire(f"flexinol-{row.name}-ht").maximum_voltage_v.value
    own = {"wire_length": 0.14, "diameter_m": row.diameter_m, "maximum_voltage": volts}
    limits = {
        "maximum_current_a": 1.1 * row.current_a,
        "maximum_power_w": 1.1 * row.current_a**2 * ohm,
        "resistance_low_ohm": 0.85 * 0.8 * ohm,
        "resistance_high_ohm": 1.5 * ohm,
        "maximum_temperature_k": 473.15,
    }
    refuse_beyond_catalogue(StatedCircuit(0.14, 1.0, own), limits)


def test_the_rig_files_that_ship_are_within(tmp_path: Path) -> None:
    for file in shipped_rig_files().values():
        assert read_rig_file(file)
    wrong = tmp_path / "bench.toml"
    wrong.write_text("wire_length = 60\n", "utf-8")
    with pytest.raises(CallerError, match=r"bench\.toml: wire_length 60 m"):
        open_rig(wrong)
