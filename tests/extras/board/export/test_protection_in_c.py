"""The protection in C is the table and the arithmetic of Python: driven with the same faults, in the same state."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from emulation.exported_library.on_this_machine import HostLibrary
from tests.extras.board.export.export_parts import Exported
from tests.unit.controllers.protected_wire import (
    allowed_drive_v,
    armed,
    closed,
    protect_command,
    protect_missing,
    protect_reading,
    rested,
    tripped_by,
)

from musclewire.controllers import Effect, Event, ProtectionState, Signal, State, protection_table

Loaded = Callable[[str, bool], HostLibrary]
PERIODS_S = (0.01, 0.02, 0.05)


def readings(limits: Any, random: np.random.Generator, drive_v: float, resistance_ohm: float) -> tuple[float, float]:
    """Voltages of a drive, sound or wrong in a random way."""
    current = drive_v / (resistance_ohm + limits.shunt_resistance_ohm)
    wire, shunt = current * resistance_ohm, current * limits.shunt_resistance_ohm
    wire, shunt = wire + random.normal(0, 1e-4), shunt + random.normal(0, 1e-4)
    wrong = random.choice(12, p=[0.78, *[0.02] * 11])
    return [
        (wire, shunt),
        (math.nan, shunt),
        (wire, -math.inf),
        (0.0, 0.0),
        (wire, 0.0),
        (shunt, wire),
        (-wire, shunt),
        (1.3 * wire, shunt),
        (0.2 * wire, 0.8 * wire + shunt),
        (limits.wire_range_v, shunt),
        (wire, 8.0 * shunt),
        (3.0 * wire + 1.0, shunt),
    ][wrong]


@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
@pytest.mark.parametrize("seed", range(4))
def test_the_same_random_faults_give_the_same_states_events_and_drives(
    exported: Callable[[str], Exported], loaded: Loaded, seed: int, double: bool
) -> None:
    limits = exported("fixed").limits
    library, random = loaded("fixed", double), np.random.default_rng(seed)
    python = start(library, limits)
    resistance, wrong_for, wrong = 16.0, 0, (0.0, 0.0)
    seen = set()
    for _ in range(4000):
        dt_s = float(random.choice(PERIODS_S))
        drive_v = allowed_drive_v(python, limits)
        if wrong_for == 0:
            wrong, wrong_for = readings(limits, random, drive_v, resistance), int(random.integers(1, 12))
        wrong_for -= 1
        again = random.random() < 0.4
        wire, shunt = wrong if again else readings(limits, random, drive_v, resistance)
        wire, shunt, drive_v = (float(np.float32(value)) for value in (wire, shunt, drive_v))
        python = protect_reading(python, limits, drive_v, wire, shunt, dt_s)
        library.reading(drive_v, wire, shunt, dt_s)
        python = other_things(library, python, limits, random)
        seen.add(int(python.event))
        agree(library, python, limits)
        resistance = float(np.clip(resistance + random.normal(0, 0.1), 15.0, 17.6))
        if python.state in (State.TRIPPED, State.OFF) and random.random() < 0.3:
            python = start(library, limits)
    assert len(seen) >= 10


def start(library: HostLibrary, limits: Any) -> ProtectionState:
    library.start()
    return armed(limits)


def other_things(
    library: HostLibrary, python: ProtectionState, limits: Any, random: np.random.Generator
) -> ProtectionState:
    """Commands, sound and not; silences; trips and switching off: the same to both."""
    what = random.random()
    if what < 0.7:
        drive_v = float(np.float32(random.uniform(0.3, 1.0) * limits.maximum_voltage_v))
        library.command(drive_v)
        return protect_command(python, limits, drive_v)
    if what < 0.72:
        drive_v = float(random.choice([math.nan, math.inf, -0.1, 1.01 * limits.maximum_voltage_v]))
        library.command(drive_v)
        return protect_command(python, limits, drive_v)
    if what < 0.78:
        missing_s = float(random.choice([0.02, 0.05, 0.09, 0.1, 0.15, 0.2, 0.249, 0.25, 0.4]))
        library.missing(Event.COMMAND_MISSING, missing_s)
        return protect_missing(python, Event.COMMAND_MISSING, missing_s)
    if what < 0.782:
        library.trip(Event.LINK_CORRUPTED)
        return tripped_by(python, Event.LINK_CORRUPTED)
    if what < 0.8:
        library.rest()
        return rested(python, limits)
    return python


@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
@pytest.mark.parametrize("seed", range(3))
def test_host_and_c_follow_the_same_random_signals_through_every_pair_of_the_table(
    exported: Callable[[str], Exported], loaded: Loaded, seed: int, double: bool
) -> None:
    limits, table = exported("fixed").limits, protection_table()
    library, random = loaded("fixed", double), np.random.default_rng(seed)
    both = Both(library, limits, random, start(library, limits))
    seen = set()
    # How often each comes: a latched state is left only by arming, and a long silence ends there.
    often = {"arm": 4, "command": 6, "present": 6, "missing": 8, "missing_long": 4, "rest": 3}
    weights = np.array([often.get(signal.name.lower(), 1) for signal in Signal], float)
    for _ in range(6000):
        signal = Signal(random.choice(len(Signal), p=weights / weights.sum()))
        before = both.python.state
        assert library.follows() is (table.transitions[before][Signal.COMMAND].effect is Effect.FOLLOW)
        getattr(both, signal.name.lower())()
        assert both.python.state is table.transitions[before][signal].state
        agree(library, both.python, limits)
        seen.add((before, signal))
    assert len(seen) == len(State) * len(Signal)


@dataclass
class Both:
    """The C library and Python's state beside it: every signal goes to both."""

    library: HostLibrary
    limits: Any
    random: np.random.Generator
    python: ProtectionState

    def arm(self) -> None:
        self.python = start(self.library, self.limits)

    def command(self) -> None:
        drive_v = float(np.float32(self.random.uniform(0.0, self.limits.maximum_voltage_v)))
        self.library.command(drive_v)
        self.python = protect_command(self.python, self.limits, drive_v)

    def present(self) -> None:
        """Say that what was missing is back."""
        assert self.library.recover(self.python.event) is (self.python.state in (State.HOLD, State.DEGRADED))
        if protection_table().transitions[self.python.state][Signal.PRESENT].effect is Effect.RESUME:
            self.python = self.python._replace(state=State.RUN, event=Event.NONE, missing_s=0.0)

    def missing(self, from_s: float = 0.0, to_s: float = 0.099) -> None:
        event = Event(self.random.choice([Event.COMMAND_MISSING, Event.SAMPLE_LATE]))
        missing_s = self.random.uniform(from_s, to_s)
        self.library.missing(event, missing_s)
        self.python = protect_missing(self.python, event, missing_s)

    def missing_long(self) -> None:
        self.missing(0.101, 0.249)

    def missing_too_long(self) -> None:
        self.missing(0.251, 1.0)

    def fault(self) -> None:
        if self.random.random() < 0.5:
            self.library.command(math.nan)
            self.python = protect_command(self.python, self.limits, math.nan)
        else:
            self.library.trip(Event.LINK_CORRUPTED)
            self.python = tripped_by(self.python, Event.LINK_CORRUPTED)

    def rest(self) -> None:
        self.library.rest()
        self.python = rested(self.python, self.limits)

    def close(self) -> None:
        self.library.off()
        self.python = closed(self.python)


def agree(library: HostLibrary, python: ProtectionState, limits: Any) -> None:
    state, event, drive_v, above_k = library.protection()
    assert (State(state), Event(event)) == (python.state, python.event)
    assert drive_v == pytest.approx(allowed_drive_v(python, limits), rel=2e-7)
    assert above_k == pytest.approx(python.temperature_k - limits.ambient_temperature_k, rel=1e-4, abs=1e-3)


@pytest.mark.parametrize("event", [event for event in Event if event is not Event.NONE])
def test_an_event_seen_outside_does_what_the_table_says(loaded: Loaded, event: Event) -> None:
    library = loaded("fixed", False)
    library.start()
    library.command(1.0)
    library.event(event, 0.15)
    expected = {"trip": State.TRIPPED, "degrade": State.DEGRADED}
    assert State(library.protection()[0]) is expected[protection_table().row(event).action]


@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
@pytest.mark.parametrize("tick_s", [0.0, -0.001, math.nan, math.inf])
def test_a_sample_that_no_time_stands_behind_trips_instead_of_blinding_the_protection(
    exported: Callable[[str], Exported], loaded: Loaded, tick_s: float, double: bool
) -> None:
    library, python = loaded("fixed", double), exported("fixed").library.reference
    library.start()
    python.start()
    for one in (library, python):
        assert State(one.sample(0.28, 0.017, 0.01).state) is not State.TRIPPED
        outcome = one.sample(0.28, 0.017, tick_s)
        assert (State(outcome.state), Event(outcome.event)) == (State.TRIPPED, Event.CLOCK_BACKWARDS)
        assert outcome.drive_voltage_v == 0.0
