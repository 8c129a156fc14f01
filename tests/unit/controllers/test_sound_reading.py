"""The compiled verdict on commands and readings is that of the protection, and so is what it remembers."""

from __future__ import annotations

import math

import pytest
from tests.unit.controllers.protected_wire import LIMITS, Reading, of_wire

from musclewire.controllers._protection import State, armed, protect_command, protect_reading
from musclewire.controllers._protection.protect import packed_memory
from musclewire.controllers._protection.reading import packed_limits, sound_reading
from musclewire.controllers._protection.running import sound_command


@pytest.mark.parametrize(
    ("reading", "sound"), [(of_wire(1.0, 16.0), True), (of_wire(1.0, 40.0), False), ((1.0, math.nan, 0.1), False)]
)
def test_a_sound_reading_is_remembered_and_another_one_is_not(reading: Reading, sound: bool) -> None:
    state = protect_command(armed(LIMITS), LIMITS, 1.0)
    memory = packed_memory(state)
    assert sound_reading(memory[0], packed_limits(LIMITS)[0], *reading, 0.05) == sound
    after = protect_reading(state, LIMITS, *reading, 0.05)
    assert memory == packed_memory(after if sound else state)
    assert (after.state is State.RUN and after.lasting_s == state.lasting_s) == sound


@pytest.mark.parametrize("volts", [0.0, 1.0, 3.6, 3.6 * (1.0 + 1e-7), 3.7, -0.1, math.nan, math.inf])
def test_a_command_is_sound_if_the_protection_follows_it(volts: float) -> None:
    followed = protect_command(armed(LIMITS), LIMITS, volts).state is State.RUN
    assert sound_command(packed_limits(LIMITS)[0], volts) == followed
