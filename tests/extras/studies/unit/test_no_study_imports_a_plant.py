"""A study whose rig file names a class of a module is refused, and the module is not imported."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from musclewire.errors import CallerError
from musclewire.extras.studies import read_study

STUDY = """
format = "musclewire-study"
version = 1
name = "hostile"
rig = "plant.toml"
seed = 1
[run]
kind = "characterize"
[sampling]
method = "sobol"
samples = 4
[parameters.pretension]
low = "1.3 N"
high = "2.5 N"
"""
RIG = """
kind = "python:my_plant:Resistor"
resistance = 17.0
wire = "paper-100um"
wire_length = "14 cm"
shunt = "1 ohm"
sense_voltage = "0.3 V"
drive_amplitude = "3.0 V"
maximum_voltage = "3.6 V"
"""
PLANT = """
import pathlib

pathlib.Path(__file__).with_suffix(".imported").touch()


class Resistor: ...
"""


def test_no_study_imports_a_plant(tmp_path: Path) -> None:
    (tmp_path / "my_plant.py").write_text(PLANT, encoding="utf-8")
    (tmp_path / "plant.toml").write_text(RIG, encoding="utf-8")
    study = tmp_path / "study.toml"
    study.write_text(STUDY, encoding="utf-8")
    with pytest.raises(CallerError, match="only a rig that is opened by its path"):
        read_study(study)
    assert "my_plant" not in sys.modules
    assert not (tmp_path / "my_plant.imported").exists()
