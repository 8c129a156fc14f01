"""The protection in C is the table and the arithmetic of Python: driven with the same faults, in the same state."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from emulation.exported_library.on_this_machine import HostLibrary
from tests.extras.board.export.export_parts import Exported, compiled, export, limits_for, usual_model

from musclewire.controllers import Effect, Event, Protection, ProtectionLimits, Signal, State, protection_table

Loaded = Callable[[str, bool], HostLibrary]
PERIODS_S = (0.01, 0.02, 0.05)


def readings(limits: Any, random: np.random.Generator, drive_v: float, resistance_ohm: float) -> tuple[float, float]:
    """Voltages of a drive, sound or wrong in a random way."""
    current = drive_v / (resistance_ohm + limits.shunt_resistance_ohm)
    wire, shunt = current * resistance_ohm, current * limits.shunt_resistance_ohm
    wire, shunt = wire + random.normal(0, 1e-4), shunt + random.normal(0, 1e-4)
    wrong = max(0, math.floor((random.random() - 0.78) / 0.02) + 1)  # sound in 78 of 100
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
    ][min(wrong, 11)]


@dataclass
class Both:
    """The C library and the host's protection: every signal goes to both."""

    library: HostLibrary
    limits: ProtectionLimits
    random: np.random.Generator

    def __post_init__(self) -> None:
        self.python = Protection(self.limits)
        self.cold_row = self.python.row.copy()
        self.library.start()

    @property
    def state(self) -> State:
        return State(self.python.row["state"][0])

    @property
    def event(self) -> Event:
        return Event(self.python.row["event"][0])

    def begin(self) -> None:
        """Arm for a cold wire."""
        self.python.row[:] = self.cold_row
        self.library.start()

    def arm(self) -> None:
        """Open again: the wire is as warm as it was."""
        self.python.arm()
        self.library.arm_again()

    def command(self, volts: float | None = None) -> None:
        drive_v = self.random.uniform(0.0, self.limits.maximum_voltage_v) if volts is None else volts
        drive_v = float(np.float32(drive_v))
        self.library.command(drive_v)
        self.python.command(drive_v)

    def reading(self, drive_v: float, wire_v: float, shunt_v: float, dt_s: float) -> None:
        drive_v, wire_v, shunt_v = (float(np.float32(value)) for value in (drive_v, wire_v, shunt_v))
        # Now and then a higher drive was ordered in this time than the one that is out at its end.
        higher = self.random.uniform(1.0, 2.0) if self.random.random() < 0.05 else 1.0
        ordered_v = float(np.float32(higher * drive_v))
        self.library.reading(drive_v, wire_v, shunt_v, dt_s, ordered_v)
        self.python.reading(drive_v, wire_v, shunt_v, dt_s, ordered_v)

    def present(self) -> None:
        """Say that what was missing is back: of the host's, only a reading does."""
        before = self.state
        assert self.library.recover(self.event) is (before in (State.HOLD, State.DEGRADED))
        if protection_table().transitions[before][Signal.PRESENT].effect is Effect.RESUME:
            self.python.row["state"], self.python.row["event"], self.python.row["missing_s"] = State.RUN, 0, 0.0

    def missing(self, from_s: float = 0.0, to_s: float = 0.099) -> None:
        event = Event(self.random.choice([Event.COMMAND_MISSING, Event.SAMPLE_LATE]))
        missing_s = self.random.uniform(from_s, to_s)
        self.library.missing(event, missing_s)
        self.python.missing(event, missing_s)

    def missing_long(self) -> None:
        self.missing(0.101, 0.249)

    def missing_too_long(self) -> None:
        self.missing(0.251, 1.0)

    def fault(self) -> None:
        if self.random.random() < 0.5:
            self.command(math.nan)
        else:
            self.library.trip(Event.LINK_CORRUPTED)
            self.python.trip(Event.LINK_CORRUPTED)

    def rest(self) -> None:
        self.library.rest()
        self.python.rest()

    def close(self) -> None:
        self.library.off()
        self.python.close()

    def agree(self) -> bool:
        """Whether both have the same state; numbers must agree in any case."""
        state, event, drive_v, above_k = self.library.protection()
        own_k = self.python.row["temperature_k"][0] - self.limits.ambient_temperature_k
        assert math.isclose(above_k, own_k, rel_tol=1e-4, abs_tol=1e-3), (above_k, own_k)
        if (State(state), Event(event)) != (self.state, self.event):
            return False
        own_v = self.python.allowed_drive_v
        assert math.isclose(drive_v, own_v, rel_tol=2e-7, abs_tol=1e-12), (drive_v, own_v)
        return True

    def at_a_limit(self) -> bool:
        """Whether the estimate is so near to its limit that single precision may fall on either side."""
        own_k = self.python.row["temperature_k"][0] - self.limits.ambient_temperature_k
        limit_k = self.limits.maximum_temperature_k - self.limits.ambient_temperature_k
        return bool(abs(own_k - limit_k) <= 1e-4 * limit_k)


def one_random_step(both: Both, drive_v: float, volts: tuple[float, float], dt_s: float) -> None:
    """A reading, and with it now and then a command, a silence, a pause, a trip, an opening."""
    both.reading(drive_v, *volts, dt_s)
    what, random = both.random.random(), both.random
    if what < 0.7:
        both.command(random.uniform(0.3, 1.0) * both.limits.maximum_voltage_v)
    elif what < 0.71:
        both.command(float(random.choice([math.nan, math.inf, -0.1, 1.01 * both.limits.maximum_voltage_v])))
    elif what < 0.76:
        missing_s = float(random.choice([0.02, 0.05, 0.09, 0.1, 0.15, 0.2, 0.249, 0.25, 0.4]))
        both.library.missing(Event.COMMAND_MISSING, missing_s)
        both.python.missing(Event.COMMAND_MISSING, missing_s)
    elif what < 0.762:
        both.library.trip(Event.LINK_CORRUPTED)
        both.python.trip(Event.LINK_CORRUPTED)
    elif what < 0.78:
        both.rest()


def follow_random_steps(both: Both, steps: int) -> set[int]:
    """Lead both through random readings, sound, wrong and missing; return the events that were seen."""
    random, resistance, wrong_for, wrong = both.random, 16.0, 0, (0.0, 0.0)
    seen: set[int] = set()
    for _ in range(steps):
        # Now and then a clock leaps: the estimate goes by the time that a reading covers.
        dt_s = 60.0 if random.random() < 1e-3 else float(PERIODS_S[int(3 * random.random())])
        drive_v = both.python.allowed_drive_v
        if wrong_for == 0:
            wrong, wrong_for = readings(both.limits, random, drive_v, resistance), int(random.integers(1, 12))
        wrong_for -= 1
        volts = wrong if random.random() < 0.4 else readings(both.limits, random, drive_v, resistance)
        one_random_step(both, drive_v, volts, dt_s)
        seen.add(int(both.event))
        if not both.agree():
            assert not both.library.double
            assert both.at_a_limit()
            both.begin()
        resistance = min(max(resistance + random.normal(0, 0.1), 15.0), 17.6)
        if both.state in (State.TRIPPED, State.OFF) and random.random() < 0.3:
            both.arm() if random.random() < 0.8 else both.begin()
    return seen


@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.full)])
def test_the_same_random_faults_give_the_same_states_events_and_drives(
    exported: Callable[[str], Exported], loaded: Loaded, seed: int, double: bool
) -> None:
    both = Both(loaded("fixed", double), exported("fixed").limits, np.random.default_rng(seed))
    assert len(follow_random_steps(both, 5000)) >= 10


@pytest.mark.full
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
def test_a_million_random_steps_give_the_same_states_events_and_drives(
    exported: Callable[[str], Exported], loaded: Loaded, double: bool
) -> None:
    both = Both(loaded("fixed", double), exported("fixed").limits, np.random.default_rng(41))
    assert len(follow_random_steps(both, 1_000_000)) >= 10


@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.full) for seed in (1, 2))])
def test_host_and_c_follow_the_same_random_signals_through_every_pair_of_the_table(
    exported: Callable[[str], Exported], loaded: Loaded, seed: int, double: bool
) -> None:
    limits, table = exported("fixed").limits, protection_table()
    both = Both(loaded("fixed", double), limits, np.random.default_rng(seed))
    seen = set()
    # How often each comes: a latched state is left only by arming, and a long silence ends there.
    often = {"arm": 4, "command": 6, "present": 6, "missing": 8, "missing_long": 4, "rest": 3}
    weights = np.array([often.get(signal.name.lower(), 1) for signal in Signal], float)
    for _ in range(6000):
        signal = Signal(both.random.choice(len(Signal), p=weights / weights.sum()))
        before = both.state
        assert both.library.follows() is (table.transitions[before][Signal.COMMAND].effect is Effect.FOLLOW)
        getattr(both, signal.name.lower())()
        assert both.state is table.transitions[before][signal].state
        assert both.agree()
        seen.add((before, signal))
    assert len(seen) == len(State) * len(Signal)


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


# A loop's usual drive, the resistance it sees, and the time that a reading covers.
DRIVE_V, OHM, DT_S = 1.8, 16.0, 0.01


def constants_of(one: Exported) -> dict[str, float]:
    """The numbers of an exported library by their names in C."""
    text = (one.library.folder / "src" / "mw_constants.h").read_text("utf-8")
    return {name: float(number) for name, number in re.findall(r"#define MW_(\w+) MW_R\((\S+?)\)", text)}


def volts_of(ohm: float, drive_v: float = DRIVE_V, shunt_ohm: float = 1.0) -> tuple[float, float]:
    """Wire and shunt voltage of a drive."""
    return drive_v * ohm / (ohm + shunt_ohm), drive_v * shunt_ohm / (ohm + shunt_ohm)


def edges(c: dict[str, float]) -> dict[str, tuple[float, Callable[[float], tuple[float, float, float]]]]:
    """The value at which something is decided, and the reading (drive, wire, shunt) that has such a value."""
    wire_v, _ = volts_of(OHM)
    shunt_ohm = c["SHUNT_RESISTANCE_OHM"]
    return {
        "driven": (c["DRIVEN_SHARE"] * c["SENSE_VOLTAGE_V"], lambda x: (x, 0.0, 0.0)),
        "supply": (c["SUPPLY_SHARE"] * DRIVE_V, lambda x: (DRIVE_V, x, 0.0)),
        "open": (c["OPEN_SHUNT_VOLTAGE_V"], lambda x: (DRIVE_V, wire_v, x)),
        "low": (c["RESISTANCE_LOW_OHM"] / shunt_ohm * 0.125, lambda x: (DRIVE_V, x, 0.125)),
        "high": (c["RESISTANCE_HIGH_OHM"] / shunt_ohm * 0.0625, lambda x: (DRIVE_V, x, 0.0625)),
        "short": (c["SHORT_SHARE"] * c["RESISTANCE_LOW_OHM"] / shunt_ohm * 0.25, lambda x: (DRIVE_V, x, 0.25)),
        "swapped": (0.0, lambda x: (0.5, x, 0.3)),
        "swapped at the low end": (0.125 * c["RESISTANCE_LOW_OHM"] / shunt_ohm, lambda x: (DRIVE_V, 0.125, x)),
        "swapped at the high end": (0.0625 * c["RESISTANCE_HIGH_OHM"] / shunt_ohm, lambda x: (DRIVE_V, 0.0625, x)),
        "saturated wire": (c["SATURATED_WIRE_V"], lambda x: (DRIVE_V, x, x / OHM)),
        "saturated shunt": (c["SATURATED_SHUNT_V"], lambda x: (DRIVE_V, wire_v, x)),
        "current": (c["MAXIMUM_CURRENT_A"] * shunt_ohm, lambda x: (2.2, 2.1, x)),
        "power": (c["MAXIMUM_POWER_W"] * 4.0, lambda x: (DRIVE_V, x, 0.25 * shunt_ohm)),
        "stuck": (DRIVE_V + c["STUCK_SHARE"] * c["MAXIMUM_VOLTAGE_V"] - 0.125, lambda x: (DRIVE_V, x, 0.125)),
        "jump up": ((1.0 + c["JUMP_SHARE"]) * OHM * 0.125, lambda x: (DRIVE_V, x, 0.125)),
        "jump down": ((1.0 - c["JUMP_SHARE"]) * OHM * 0.125, lambda x: (DRIVE_V, x, 0.125)),
    }


EDGES = (
    *("driven", "supply", "open", "low", "high", "short", "swapped", "swapped at the low end"),
    *("swapped at the high end", "saturated wire", "saturated shunt", "current", "power", "stuck"),
    *("jump up", "jump down"),
)


@pytest.mark.parametrize("name", EDGES)
def test_on_the_edge_of_a_decision_and_next_to_it_c_decides_as_python_does(
    exported: Callable[[str], Exported], loaded: Loaded, name: str
) -> None:
    edge, reading_of = edges(constants_of(exported("fixed")))[name]
    both = Both(loaded("fixed", True), exported("fixed").limits, np.random.default_rng(0))
    decided = set()
    beside = (math.nextafter(edge, -math.inf), edge, math.nextafter(edge, math.inf))
    for value in (0.99 * edge - 1e-6, *beside, 1.01 * edge + 1e-6):
        both.begin()
        both.command(DRIVE_V)
        # Long enough for whatever must last, and too short for equal numbers to be a frozen channel.
        for volts in ((DRIVE_V, OHM * 0.125, 0.125), *(reading_of(value) for _ in range(28))):
            both.library.reading(*volts, DT_S, volts[0])
            both.python.reading(*volts, DT_S, volts[0])
            assert both.agree()
        decided.add((both.state, both.event))
    assert len(decided) > 1


@pytest.mark.parametrize("share", [0.9, 1.1])
@pytest.mark.parametrize("frozen", ["wire", "shunt", "both"])
def test_readings_without_noise_are_frozen_only_if_a_changed_drive_does_not_move_them(
    tmp_path: Path, frozen: str, share: float
) -> None:
    one = export(tmp_path, limits=limits_for(usual_model(), readings_noisy=0.0), rule_base="fixed")
    both = Both(compiled(one.library, tmp_path, double=True), one.limits, np.random.default_rng(0))
    constants = constants_of(one)
    higher_v = DRIVE_V + share * constants["MOVED_SHARE"] * constants["MAXIMUM_VOLTAGE_V"]
    both.command(DRIVE_V)
    for number in range(80):
        wire_v, shunt_v = volts_of(OHM)
        moves = 1e-4 * (number % 2)
        volts = wire_v + moves * (frozen == "shunt"), shunt_v + moves * (frozen == "wire")
        drive_v = DRIVE_V if number < 40 else higher_v
        for protection in (both.library, both.python):
            protection.command(drive_v)
            protection.reading(drive_v, *volts, DT_S, drive_v)
        assert both.agree()
        assert both.state is (State.TRIPPED if share > 1.0 and number >= 40 else State.RUN)
    assert both.event is (Event.CHANNEL_FROZEN if share > 1.0 else Event.NONE)


def test_a_wire_of_less_resistance_than_its_shunt_is_not_swapped_with_it(tmp_path: Path) -> None:
    """Either of the two would fit the window in the other's place."""
    shunt_ohm = 20.0
    one = export(tmp_path, limits=limits_for(usual_model(), shunt_ohm), rule_base="fixed")
    both = Both(compiled(one.library, tmp_path, double=True), one.limits, np.random.default_rng(0))
    both.command(DRIVE_V)
    wire_v, shunt_v = volts_of(OHM, DRIVE_V, shunt_ohm)
    for number in range(20):
        noise = 1.0 + 1e-6 * (number % 3)
        for protection in (both.library, both.python):
            protection.reading(DRIVE_V, wire_v * noise, shunt_v * noise, DT_S, DRIVE_V)
        assert both.agree()
    assert both.state is State.RUN
