import numpy as np
import pytest

from musclewire.errors import RecordingError
from musclewire.judge import JudgedRecording
from musclewire.signals import Recording


def recording_of(*names, **metadata):
    return Recording({name: np.array([0.1, 0.2]) for name in ("time_s", *names)}, metadata)


@pytest.mark.parametrize(
    ("names", "metadata", "source"),
    [
        (
            ("wire_voltage_v", "shunt_voltage_v", "wire_current_a", "wire_resistance_ohm"),
            {"shunt_resistance_ohm": 1.0},
            ("wire_voltage_v", "shunt_voltage_v"),
        ),
        (("wire_voltage_v", "shunt_voltage_v", "wire_current_a"), {}, ("wire_voltage_v", "wire_current_a")),
        (("wire_resistance_ohm",), {}, ("wire_resistance_ohm",)),
    ],
)
def test_a_known_shunt_comes_first_then_a_measured_current_then_a_resistance(names, metadata, source):
    assert JudgedRecording(recording_of(*names, **metadata)).source == source


@pytest.mark.parametrize("shunt", [None, 0.0, -1.0, float("nan"), float("inf"), True, "1 ohm"])
def test_a_shunt_needs_a_positive_resistance(shunt):
    recording = recording_of("wire_voltage_v", "shunt_voltage_v", shunt_resistance_ohm=shunt)
    with pytest.raises(RecordingError, match=r"metadata shunt_resistance_ohm is .*give a positive number"):
        _ = JudgedRecording(recording).source


def test_what_is_missing_is_named():
    with pytest.raises(RecordingError, match="it lacks shunt_voltage_v, wire_current_a, wire_resistance_ohm: give"):
        _ = JudgedRecording(recording_of("wire_voltage_v")).source
