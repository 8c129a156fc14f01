"""Samples that come faster than readings are averaged first; nothing compiles while a wire is driven."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.controllers.protected_wire import LIMITS, of_wire

from musclewire.controllers import (
    CONDITION_EVENTS,
    Event,
    Protection,
    State,
    commanded,
    judged_sample,
    protection_table,
)


def test_a_sample_of_whole_numbers_is_judged_as_floats_and_compiles_nothing() -> None:
    running = Protection(LIMITS)
    functions: list[Any] = [commanded, judged_sample]
    known = [set(one.signatures) for one in functions]
    assert all(known)
    running.command(2)
    running.sample(2, 1, 1, 0.05)
    assert running.state.lasting_s[CONDITION_EVENTS.index(Event.CHANNEL_SATURATED)] == 0.05
    assert [set(one.signatures) for one in functions] == known


def test_a_reading_that_trips_is_kept_for_the_message() -> None:
    running = Protection(LIMITS)
    running.command(1.0)
    for _ in range(20):
        running.sample(1.0, 0.5, 0.31, 0.05)
    assert running.tripped
    assert running.last_reading_v == (1.0, 0.5, 0.31)


FAST_S = 1e-3
BLOCK = round(protection_table().reading_period_s / FAST_S)
one_sample = st.tuples(st.floats(0.0, 3.6), st.floats(-5.0, 5.0), st.floats(-0.3, 0.3))


@given(st.lists(one_sample, min_size=1, max_size=BLOCK))
def test_a_block_of_fast_samples_covers_their_time_and_holds_their_means(samples: list[tuple[float, ...]]) -> None:
    running = Protection(LIMITS)
    for volts in samples:
        running.sample(*volts, FAST_S)
    unfinished = samples[-((len(samples) - 1) % BLOCK + 1) :]
    block_s, ordered_v, *means_v = running.state[-5:]
    assert ordered_v == max(drive_v for drive_v, _, _ in unfinished)
    assert block_s == pytest.approx(len(unfinished) * FAST_S)
    assert means_v == pytest.approx(np.mean(unfinished, axis=0), abs=1e-12)


@pytest.mark.parametrize("sound_one", range(BLOCK))
def test_a_fault_in_all_fast_samples_but_one_is_seen_whichever_sample_is_sound(sound_one: int) -> None:
    running = Protection(LIMITS)
    running.command(3.0)
    for tick in range(60 * BLOCK):
        running.sample(*of_wire(3.0, 16.0 if tick % BLOCK == sound_one else 1.5), FAST_S)
    assert running.tripped
    sound_volts, bad_volts = np.array(of_wire(3.0, 16.0)), np.array(of_wire(3.0, 1.5))
    assert running.last_reading_v == pytest.approx(tuple(bad_volts + (sound_volts - bad_volts) / BLOCK))


@pytest.mark.parametrize("noisy_one", range(BLOCK))
def test_noise_in_one_fast_sample_of_each_reading_trips_nothing(noisy_one: int) -> None:
    """Judged by itself such a sample would be outside the window of resistance; the mean is near that of the wire."""
    running = Protection(LIMITS)
    running.command(1.0)
    for tick in range(60 * BLOCK):
        drive_v, wire_v, shunt_v = of_wire(1.0 + 1e-5 * tick, 16.0)
        running.sample(drive_v, wire_v * (1.7 if tick % BLOCK == noisy_one else 1.0), shunt_v, FAST_S)
    assert running.state.state is State.RUN
