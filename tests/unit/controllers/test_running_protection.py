"""A running protection goes through the states that the functions of ``protect.py`` go through, number by number."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.controllers.protected_wire import LIMITS, of_wire

from musclewire.controllers import (
    Event,
    ProtectionState,
    State,
    allowed_drive_v,
    armed,
    closed,
    protect_command,
    protect_missing,
    protect_reading,
    protection_table,
    rested,
    tripped_by,
)
from musclewire.controllers._protection.protect import RunningProtection, after_reading, fills_block, sound_sample


class ByFunctions:
    """The same by the functions alone, with a block of samples averaged in Python."""

    def __init__(self, period_s: float) -> None:
        self.period_s, self.state = period_s, armed(LIMITS)
        self.block = (0.0, 0.0, 0.0, 0.0)

    def command(self, volts: float) -> None:
        self.state = protect_command(self.state, LIMITS, volts)

    def sample(self, *volts: float) -> None:
        covered_s, *means = self.block
        weight = self.period_s / (covered_s + self.period_s)
        covered_s += self.period_s
        means = [mean + weight * (volt - mean) for mean, volt in zip(means, volts, strict=True)]
        self.block = (covered_s, means[0], means[1], means[2])
        if covered_s >= protection_table().reading_period_s - 1e-9:
            self.block = (0.0, 0.0, 0.0, 0.0)
            self.state = protect_reading(self.state, LIMITS, means[0], means[1], means[2], covered_s)

    def missing(self, event: Event, missing_s: float) -> None:
        self.state = protect_missing(self.state, event, missing_s)

    def trip(self, event: Event) -> None:
        self.state = tripped_by(self.state, event)

    def close(self) -> None:
        self.state = closed(self.state)

    def rest(self) -> None:
        self.state, self.block = rested(self.state, LIMITS), (0.0, 0.0, 0.0, 0.0)

    def allowed(self) -> tuple[float, bool]:
        return allowed_drive_v(self.state, LIMITS), self.state.state is not State.RUN


Protection = RunningProtection | ByFunctions
Act = Callable[[Protection], None]


def sample_of(drive_v: float, ohm: float, noise_v: float) -> Act:
    """A sample of a wire with a resistance."""
    _, wire_v, shunt_v = of_wire(drive_v, ohm)
    return lambda protection: protection.sample(drive_v, wire_v + noise_v, shunt_v + noise_v)


volts = st.floats(0.0, 3.6) | st.sampled_from([-0.1, 3.6, 4.0, math.nan, math.inf])
sound = st.builds(sample_of, st.floats(0.0, 3.6), st.floats(14.0, 18.0), st.floats(0.0, 1e-4))
same = st.just(sample_of(1.0, 16.0, 0.0))
odd = st.builds(
    sample_of,
    st.floats(0.0, 3.6),
    st.floats(-2.0, 40.0).filter(lambda ohm: ohm != -1.0),
    st.floats(-6.0, 6.0) | st.just(math.nan),
)
events = st.sampled_from([Event.SAMPLE_LATE, Event.COMMAND_MISSING])
commands = st.builds(lambda v: lambda protection: protection.command(v), volts)
others = st.one_of(
    st.builds(lambda event, s: lambda protection: protection.missing(event, s), events, st.floats(0.0, 0.3)),
    st.just(lambda protection: protection.rest()),
    st.just(lambda protection: protection.close()),
    st.just(lambda protection: protection.trip(Event.DEVICE_LOST)),
)
# Mostly sound, so that most sequences stay in the quick part for a while.
acts = st.one_of(sound, sound, sound, same, commands, commands, odd, others)


def numbers_of(state: ProtectionState) -> tuple[object, ...]:
    """The state with its NaN comparable."""
    return tuple("NaN" if value != value else value for value in state)


@pytest.mark.parametrize("period_s", [1e-3, 0.05])
@given(st.lists(acts, max_size=60))
def test_every_state_on_the_way_is_that_of_the_functions(period_s: float, acts: list[Act]) -> None:
    running, by_functions = RunningProtection(LIMITS, period_s), ByFunctions(period_s)
    for act in [lambda protection: protection.command(1.0), *acts]:
        act(running)
        act(by_functions)
        assert numbers_of(running.state) == numbers_of(by_functions.state)
        assert running.allowed() == by_functions.allowed()
        assert running.tripped == (by_functions.state.state is State.TRIPPED)


def test_a_sample_of_whole_numbers_is_judged_as_floats_and_compiles_nothing() -> None:
    running = RunningProtection(LIMITS, 0.05)
    functions: list[Any] = [sound_sample, fills_block, after_reading]
    known = [set(one.signatures) for one in functions]
    assert all(known)
    running.command(2)
    running.sample(2, 1, 1)
    assert running.state.lasting_s.channel_saturated == 0.05
    assert [set(one.signatures) for one in functions] == known


def test_a_reading_that_trips_is_kept_for_the_message() -> None:
    running = RunningProtection(LIMITS, 0.05)
    running.command(1.0)
    for _ in range(20):
        running.sample(1.0, 0.5, 0.31)
    assert running.tripped
    assert running.last_reading_v == (1.0, 0.5, 0.31)


@pytest.mark.parametrize("period_s", [1e-3, 0.05])
@given(st.lists(acts, max_size=30), volts)
def test_a_command_that_is_said_to_be_followed_is_what_may_be_applied(
    period_s: float, acts: list[Act], commanded_v: float
) -> None:
    running = RunningProtection(LIMITS, period_s)
    for act in acts:
        act(running)
    if running.command(commanded_v):
        assert running.allowed() == (commanded_v, False)
    else:
        assert running.state.state is not State.RUN or running.state.lasting_s != armed(LIMITS).lasting_s


FAST_S = 1e-3
BLOCK = round(protection_table().reading_period_s / FAST_S)
one_sample = st.tuples(st.floats(0.0, 3.6), st.floats(-5.0, 5.0), st.floats(-0.3, 0.3))


@given(st.lists(one_sample, min_size=1, max_size=40))
def test_a_block_of_fast_samples_covers_their_time_and_holds_their_means(samples: list[tuple[float, ...]]) -> None:
    block = np.zeros(4)
    full = [bool(fills_block(block, *volts, FAST_S, protection_table().reading_period_s)) for volts in samples]
    assert block[0] == pytest.approx(len(samples) * FAST_S)
    assert block[1:] == pytest.approx(np.mean(samples, axis=0), abs=1e-12)
    assert full == [count >= BLOCK for count in range(1, len(samples) + 1)]


@pytest.mark.parametrize("sound_one", range(BLOCK))
def test_a_fault_in_all_fast_samples_but_one_is_seen_whichever_sample_is_sound(sound_one: int) -> None:
    running = RunningProtection(LIMITS, FAST_S)
    running.command(3.0)
    for tick in range(60 * BLOCK):
        running.sample(*of_wire(3.0, 16.0 if tick % BLOCK == sound_one else 1.5))
    assert running.tripped
    sound_volts, bad_volts = np.array(of_wire(3.0, 16.0)), np.array(of_wire(3.0, 1.5))
    assert running.last_reading_v == pytest.approx(tuple(bad_volts + (sound_volts - bad_volts) / BLOCK))


@pytest.mark.parametrize("noisy_one", range(BLOCK))
def test_noise_in_one_fast_sample_of_each_reading_trips_nothing(noisy_one: int) -> None:
    """Judged by itself such a sample would be outside the window of resistance; the mean is near that of the wire."""
    running = RunningProtection(LIMITS, FAST_S)
    running.command(1.0)
    for tick in range(60 * BLOCK):
        drive_v, wire_v, shunt_v = of_wire(1.0 + 1e-5 * tick, 16.0)
        running.sample(drive_v, wire_v * (1.7 if tick % BLOCK == noisy_one else 1.0), shunt_v)
    assert running.state.state is State.RUN
