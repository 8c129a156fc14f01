"""The compiled verdict on a reading is that of the protection, and so is what it remembers."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.controllers._protection import (
    Event,
    ProtectionLimits,
    ProtectionState,
    State,
    armed,
    protect_command,
    protect_reading,
)
from musclewire.controllers._protection.protect import HEALTHY, conditions, missing_event
from musclewire.controllers._protection.running import (
    REMEMBERED,
    packed_limits,
    packed_memory,
    sound_command,
    sound_reading,
)

LIMITS = ProtectionLimits(
    sense_voltage_v=0.3,
    maximum_voltage_v=3.6,
    shunt_resistance_ohm=1.0,
    minimum_current_a=0.001,
    maximum_current_a=0.4,
    maximum_power_w=1.4,
    resistance_low_ohm=10.0,
    resistance_high_ohm=26.0,
    jump_share=0.1,
    wire_range_v=5.0,
    shunt_range_v=0.3,
    readings_noisy=1.0,
    heat_capacity_j_per_k=5.4e-3,
    heat_loss_w_per_k=6e-3,
    ambient_temperature_k=295.15,
    maximum_temperature_k=373.15,
)
QUIET = LIMITS._replace(readings_noisy=0.0)
Reading = tuple[float, float, float]


def of_wire(drive_v: float, ohm: float) -> Reading:
    """Drive, wire and shunt voltage of a resistance."""
    current_a = drive_v / (ohm + 1.0)
    return drive_v, current_a * ohm, current_a


any_volts = st.floats(-12.0, 12.0) | st.sampled_from([math.nan, math.inf, 0.0])
wires = st.builds(of_wire, st.floats(0.0, 3.6), st.floats(14.0, 18.0))
odd = st.tuples(st.floats(0.0, 3.6), any_volts, any_volts) | st.builds(
    of_wire, st.floats(0.0, 6.0), st.floats(2.0, 40.0)
)
# Few different readings, so that channels repeat their numbers.
readings = st.lists(st.one_of(wires, wires, odd, st.just(of_wire(1.0, 16.0))), min_size=1, max_size=40)


def is_sound(state: ProtectionState, limits: ProtectionLimits, reading: Reading, dt_s: float) -> bool:
    """Whether the protection in Python finds nothing in a reading."""
    if missing_event(limits, *reading) is not Event.NONE:
        return False
    return conditions(state, limits, *reading, dt_s)[0] is HEALTHY


@pytest.mark.parametrize("limits", [LIMITS, QUIET])
@pytest.mark.parametrize("dt_s", [0.01, 0.05])
@given(readings)
def test_a_reading_is_sound_if_the_protection_finds_nothing_in_it(
    limits: ProtectionLimits, dt_s: float, readings: list[Reading]
) -> None:
    memory, packed = packed_memory(armed(limits)), packed_limits(limits)
    state = protect_command(armed(limits), limits, 1.0)
    for reading in readings:
        sound = sound_reading(memory[0], packed[0], *reading, dt_s)
        assert sound == is_sound(state, limits, reading, dt_s)
        if not sound:
            return
        state = protect_reading(state, limits, *reading, dt_s)
        assert state.state is State.RUN
        assert tuple(memory[0]) == tuple(getattr(state, name) for name in REMEMBERED)


@pytest.mark.parametrize("noise_v", [0.0, 1e-6], ids=["a frozen channel", "a wire that gets too hot"])
def test_what_builds_up_over_readings_is_found_at_the_same_one(noise_v: float) -> None:
    drive_v, wire_v, shunt_v = of_wire(3.6, 16.0)
    memory, packed = packed_memory(armed(LIMITS)), packed_limits(LIMITS)
    state = protect_command(armed(LIMITS), LIMITS, 1.0)
    for tick in range(1000):
        reading = drive_v, wire_v + noise_v * (tick % 2), shunt_v + noise_v * (tick % 2)
        sound = is_sound(state, LIMITS, reading, 0.05)
        assert sound_reading(memory[0], packed[0], *reading, 0.05) == sound
        if not sound:
            break
        state = protect_reading(state, LIMITS, *reading, 0.05)
    assert 1 < tick < 999
    assert (noise_v > 0.0) == (protect_reading(state, LIMITS, *reading, 0.05).event is Event.OVER_TEMPERATURE)


@pytest.mark.parametrize("volts", [0.0, 1.0, 3.6, 3.6 * (1.0 + 1e-7), 3.7, -0.1, math.nan, math.inf])
def test_a_command_is_sound_if_the_protection_follows_it(volts: float) -> None:
    followed = protect_command(armed(LIMITS), LIMITS, volts).state is State.RUN
    assert sound_command(packed_limits(LIMITS)[0], volts) == followed
