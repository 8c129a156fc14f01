"""By how much a warmer room leaves the cold wire shorter, from a loop."""

from __future__ import annotations

from typing import Any

import pytest

import musclewire as mw
from musclewire.identify._zero_of_room import cold_contraction_per_k
from musclewire.signals import Recording


@pytest.mark.parametrize("moved", [lambda moved_m: moved_m - 0.01, lambda moved_m: -moved_m - 1e-4])
def test_a_motion_that_is_negative_throughout_is_no_traceback(moved: Any) -> None:
    with mw.open_rig("simulated", ambient_temperature_k=295.15, seed=3) as rig:
        loop = mw.characterize(rig, cycles=1, period_s=30.0)
    shown = {**loop.columns, "displacement_m": moved(loop["displacement_m"])}
    found = cold_contraction_per_k(Recording(shown, loop.metadata), moved(loop["displacement_m"]))
    assert found is None or found > 0.0
    still = {**loop.columns, "wire_voltage_v": 16.0 * loop["shunt_voltage_v"]}
    assert cold_contraction_per_k(Recording(still, loop.metadata), loop["displacement_m"]) is None
