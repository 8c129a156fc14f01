import numpy as np
import pytest

from musclewire.errors import RecordingError
from musclewire.signals._electrical import ElectricalSource, require_electrical
from musclewire.signals._recording import Recording


def recording_of(*names, **metadata):
    return Recording({name: np.array([0.1, 0.2]) for name in ("time_s", *names)}, metadata)


def test_a_shunt_of_known_resistance_comes_first():
    everything = ("wire_voltage_v", "shunt_voltage_v", "wire_current_a", "wire_resistance_ohm")
    assert require_electrical(recording_of(*everything, shunt_resistance_ohm=1.0)) is ElectricalSource.SHUNT


def test_without_the_shunts_resistance_a_measured_current_serves():
    recording = recording_of("wire_voltage_v", "shunt_voltage_v", "wire_current_a")
    assert require_electrical(recording) is ElectricalSource.CURRENT


def test_a_resistance_serves_as_it_is():
    assert require_electrical(recording_of("wire_resistance_ohm")) is ElectricalSource.RESISTANCE


@pytest.mark.parametrize("shunt", [None, 0.0, -1.0, float("nan"), float("inf"), True, "1 ohm"])
def test_a_shunt_needs_a_positive_resistance(shunt):
    recording = recording_of("wire_voltage_v", "shunt_voltage_v", shunt_resistance_ohm=shunt)
    with pytest.raises(RecordingError, match=r"metadata shunt_resistance_ohm is .*give a positive number"):
        require_electrical(recording)


def test_what_is_missing_is_named():
    with pytest.raises(RecordingError, match="it lacks shunt_voltage_v, wire_current_a, wire_resistance_ohm: give"):
        require_electrical(recording_of("wire_voltage_v"))
