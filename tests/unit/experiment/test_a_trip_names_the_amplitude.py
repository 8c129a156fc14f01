"""A slow sine that is too hot ends with the estimate, the limit and an amplitude that is within it."""

from __future__ import annotations

import re

import pytest

from musclewire.experiment import characterize
from musclewire.rigs import ProtectionTripError, open_rig


def test_the_amplitude_that_a_trip_proposes_does_not_trip() -> None:
    with (
        open_rig("simulated", wire_length_m=0.06, maximum_voltage_v=3.6) as rig,
        pytest.raises(ProtectionTripError) as trip,
    ):
        characterize(rig, amplitude_v=3.2, cycles=1, period_s=20.0)
    said = str(trip.value)
    assert re.search(r"amplitude of 3\.2 V the protection's estimate was 20\d C, its limit is 200 C", said)
    proposed = re.search(r"amplitude_v=([\d.]+),", said)
    assert proposed is not None
    with open_rig("simulated", wire_length_m=0.06, maximum_voltage_v=3.6) as rig:
        again = characterize(rig, amplitude_v=float(proposed[1]), cycles=1, period_s=20.0)
    assert again.metadata["ended"] == "done"
    assert float(proposed[1]) >= 0.7 * rig.drive_amplitude_v


def test_another_trip_is_told_as_it_is() -> None:
    with (
        open_rig("simulated") as rig,
        pytest.raises(ProtectionTripError) as trip,
    ):
        rig.exchange(99.0)
    assert "amplitude_v" not in str(trip.value)
