"""The lanes of the vector environment: the protection of many is that of every rig."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from musclewire.controllers import Event, Protection
from musclewire.extras.interfaces import simulated_wire
from musclewire.extras.interfaces._environments.kernels import ENDS, MEMORY, drive_lanes, read_lanes
from musclewire.extras.interfaces._environments.vector import facts_of

pytestmark = pytest.mark.slow

READINGS = st.lists(st.tuples(st.floats(0.3, 3.6), st.floats(-0.2, 1.3), st.floats(-0.1, 2.0)), min_size=1, max_size=12)


@settings(max_examples=200)
@given(READINGS, st.floats(300.0, 400.0), st.floats(0.01, 0.5))
def test_the_protection_of_many_is_that_of_every_rig(
    readings: list[tuple[float, float, float]], hottest_k: float, jump_share: float
) -> None:
    """Readings of any circuit, also of one without supply or current, in two lanes of which one stays sound."""
    wire = simulated_wire("simulated")
    limits = wire.limits._replace(maximum_temperature_k=hottest_k, jump_share=jump_share)
    facts, memory = np.repeat(facts_of(wire), 2), np.zeros(2, MEMORY)
    facts["acquisition_noise_v"] = facts["displacement_noise_m"] = 0.0
    facts["acquisition_step_v"] = 1e-12
    both = [Protection(limits), Protection(wire.limits)]
    rules, rows = (np.concatenate([getattr(one, name) for one in both]) for name in ("rules", "row"))
    single, span_v = both[0], limits.maximum_voltage_v - limits.sense_voltage_v
    for drive_v, wire_factor, shunt_v in readings:
        drives = np.empty(2)
        actions = 2.0 * (np.array([drive_v, 1.0]) - limits.sense_voltage_v) / span_v - 1.0
        drive_lanes(facts, rules, rows, memory, actions, drives)
        step_v = facts["amplifier_resolution_v"][0]
        allowed_v, _ = single.command(min(step_v * round(drive_v / step_v), limits.maximum_voltage_v))
        assert drives == pytest.approx([allowed_v, step_v * round(1.0 / step_v)], abs=1e-12)
        means = np.array([[wire_factor * drive_v, 0.944], [shunt_v, 0.056], [0.0, 0.0]])
        ends = np.zeros(2, ENDS)
        read_lanes(facts, rules, rows, memory, 1, means, ends)
        single.reading(drives[0], ends["wire_voltage_v"][0], ends["shunt_voltage_v"][0], 0.05)
        state = single.state
        assert ends["event"].tolist() == [state.event if single.tripped else Event.NONE, Event.NONE]
        assert rows["temperature_k"][0] == state.temperature_k
        if single.tripped:
            break
