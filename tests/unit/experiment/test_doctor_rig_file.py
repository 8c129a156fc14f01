"""What ``musclewire doctor --write`` changes in a rig file, and what it leaves alone."""

from __future__ import annotations

import tomllib

import pytest

from musclewire.errors import CallerError
from musclewire.experiment import ChannelCalibration
from musclewire.experiment._doctor.rig_file import with_calibration

FILE = """# my bench
kind = "nidaq"
device = "Dev1"

[inputs.wire_voltage]   # the pair at the crimps
channel = "ai0"
gain = 2.0  # a divider by two
offset = "4 mV"

[inputs.shunt_voltage]
channel = "ai1"

[output]
channel = "ao0"
gain = 1.0
"""


def test_offset_and_gain_are_corrected_by_what_was_found_beyond_the_files_own() -> None:
    found = (ChannelCalibration("wire", 3e-3, 1.01), ChannelCalibration("shunt", -2e-4, None))
    tables = tomllib.loads(with_calibration(FILE, found, "rig.toml"))
    wire, shunt = tables["inputs"]["wire_voltage"], tables["inputs"]["shunt_voltage"]
    terminal_v = 0.7
    reading_v = 2.0 * terminal_v + 4e-3
    assert wire["gain"] * terminal_v + wire["offset"] == pytest.approx((reading_v - 3e-3) * 1.01)
    assert shunt == {"channel": "ai1", "offset": pytest.approx(2e-4)}
    assert tables["output"] == {"channel": "ao0", "gain": 1.0}


def test_comments_and_other_lines_stay_as_they_were() -> None:
    text = with_calibration(FILE, (ChannelCalibration("wire", 3e-3, 1.01),), "rig.toml")
    assert "# my bench" in text
    assert "[inputs.wire_voltage]   # the pair at the crimps" in text
    assert "gain = 2.02  # a divider by two" in text
    assert len(text.splitlines()) == len(FILE.splitlines())


def test_writing_what_is_right_already_changes_no_number() -> None:
    once = with_calibration(FILE, (ChannelCalibration("shunt", 1e-4, None),), "rig.toml")
    assert with_calibration(once, (ChannelCalibration("shunt", 0.0, 1.0),), "rig.toml").count("offset = -0.0001") == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('kind = "nidaq"\n', "no \\[inputs.wire_voltage\\]"),
        ("kind = \n", "rig file rig.toml"),
    ],
)
def test_a_file_that_has_no_such_table_is_refused_in_one_line(text: str, words: str) -> None:
    with pytest.raises(CallerError, match=words):
        with_calibration(text, (ChannelCalibration("wire", 1e-3, None),), "rig.toml")
