"""Keys of wire and circuit are the same in rig files of simulated and of real rigs."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from tests.places import CHECKOUT

from musclewire.errors import CallerError
from musclewire.rigs import SETTINGS, MountedWire, RigConfiguration, open_rig, read_rig_file

BY_KEYS = """
wire_length = "120 mm"
legs = 2
shunt = "0.5 ohm"
sense_voltage = "0.25 V"
maximum_voltage = "3.1 V"
drive_amplitude = "2.8 V"
pretension = "1.7 N"
ambient_temperature = "20 degC"
sample_period = "40 ms"
"""
BY_SETTINGS = """
[settings]
wire_length_m = "120 mm"
legs = 2
shunt_resistance_ohm = "0.5 ohm"
sense_voltage_v = "0.25 V"
maximum_voltage_v = "3.1 V"
drive_amplitude_v = "2.8 V"
pretension_n = "1.7 N"
ambient_temperature_k = "20 degC"
sample_period_s = "40 ms"
"""


def rig_file(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "rig.toml"
    path.write_text(text, "utf-8")
    return path


def test_every_key_of_a_real_wire_and_its_circuit_is_one_of_a_simulated_rig() -> None:
    of_a_real_one = {"arrives", "loss_factor"}  # a simulated rig knows its output and its air
    assert set(MountedWire.model_fields) - of_a_real_one <= set(RigConfiguration.model_fields)
    assert set(SETTINGS) == set(MountedWire.model_fields) - {"wire", "limits", "beyond_catalogue"} - of_a_real_one


def test_the_keys_set_what_the_settings_set_by_their_old_names(tmp_path: Path) -> None:
    recorded = []
    for text in (BY_KEYS, BY_SETTINGS):
        with open_rig(rig_file(tmp_path, text)) as rig:
            recorded.append((rig.metadata(), [rig.exchange(1.0) for _ in range(5)]))
    assert recorded[0] == recorded[1]
    assert recorded[0][0]["pretension_n"] == 1.7
    assert recorded[0][0]["shunt_resistance_ohm"] == 0.5


def test_a_number_that_is_said_twice_and_a_quantity_of_another_kind_are_refused(tmp_path: Path) -> None:
    text = 'pretension = "1 N"\n[settings]\npretension_n = "2 N"\n'
    with pytest.raises(CallerError, match=r"pretension and settings\.pretension_n are the same number"):
        read_rig_file(rig_file(tmp_path, text))
    with pytest.raises(CallerError, match="pretension"):
        read_rig_file(rig_file(tmp_path, 'pretension = "1 V"\n'))


# What a maintainer adds to MountedWire for a key that nobody else knows, and what then has to follow.
ADDED = """    spool: Annotated[str | None, Field(description="What is printed on the spool of the wire.")] = None
    oven_time: Annotated[float | None, SiName("oven_time_s"), measured_in("s"), Field(description="Oven.")] = None
"""
FOLLOWS = """
import sys
import musclewire as mw
import rig_keys_page
from musclewire.rigs import MountedWire

board = {"wire": "paper-100um", "wire_length": "14 cm", "shunt": "1 ohm", "sense_voltage": "0.3 V"}
facts = MountedWire.model_validate({**board, "spool": "lot 7", "oven_time": "10 min"}).facts()
print(facts["spool"], facts["oven_time_s"])
with mw.open_rig(sys.argv[1]) as rig:
    print(rig.metadata()["spool"], rig.metadata()["oven_time_s"], rig.metadata()["wire"])
with mw.open_rig("simulated") as rig:
    print("spool" in rig.metadata(), "| what is printed on the spool" in rig_keys_page.page())
"""


@pytest.mark.slow
def test_a_key_is_added_by_one_edit_and_all_rigs_their_facts_and_the_page_have_it(tmp_path: Path) -> None:
    """In a copy of the package: files with and without the key open, and recordings and the page state it."""
    shutil.copytree(CHECKOUT / "src", tmp_path / "src", ignore=shutil.ignore_patterns("__pycache__"))
    edited = tmp_path / "src" / "musclewire" / "rigs" / "_mounted_wire.py"
    before = "    limits: LimitsTable = LimitsTable()\n"
    text = edited.read_text("utf-8")
    assert text.count(before) == 1
    edited.write_text(text.replace(before, ADDED + before), "utf-8")
    file = rig_file(tmp_path, 'spool = "lot 7"\noven_time = "10 min"\n')
    path = os.pathsep.join(str(one) for one in (tmp_path / "src", CHECKOUT / "docs" / "images"))
    done = subprocess.run(
        [sys.executable, "-c", FOLLOWS, str(file)],
        # A copy has no compiled kernels, and what opens two rigs needs none.
        env={**os.environ, "PYTHONPATH": path, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.splitlines() == ["lot 7 600.0", "lot 7 600.0 paper-100um", "False True"], done.stderr
