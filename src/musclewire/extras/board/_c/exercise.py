"""Repeatable random ticks that exercise a library: targets, noise, lost readings, faults; and the table of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from itertools import chain
from typing import NamedTuple

import numpy as np

from musclewire.extras.board._c.loops import FILTER
from musclewire.extras.board._c.reference import GAINS, ReferenceTick, TickOutcome
from musclewire.parameters import require_seed
from musclewire.sensing import filter_numbers

# Largest step of the resistance in a control period, as a fraction of the model's span.
WALK_FRACTION = 0.02
TARGET_CHANGES_EACH_S = 2.0
MAX_FAULT_S = 0.6
NOISE_V = 2e-4


class ExerciseRow(NamedTuple):
    """One row: inputs, which are exact in single precision, and Python's outcome after it."""

    start: bool  # the library is started again before it
    wire_voltage_v: float
    shunt_voltage_v: float
    target: float
    tick_s: float
    control_s: float  # 0 if only a sample is taken
    outcome: TickOutcome


class ExerciseVoltages(NamedTuple):
    """The readings of both channels, with what a fault may depend on: the last reading and the channels' ranges."""

    wire_v: float
    shunt_v: float
    last_wire_v: float
    ranges_v: tuple[float, float]


# Each fault replaces the two voltages by those that the channels would then read.
FAULTS: dict[str, Callable[[ExerciseVoltages], tuple[float, float]]] = {
    "open wire": lambda v: (v.wire_v + v.shunt_v, 0.0),
    "supply missing": lambda _: (0.0, 0.0),
    "not a number": lambda v: (math.nan, v.shunt_v),
    "infinite": lambda v: (v.wire_v, math.inf),
    "swapped": lambda v: (v.shunt_v, v.wire_v),
    "reversed": lambda v: (-v.wire_v, v.shunt_v),
    "short": lambda v: (0.3 * v.wire_v, 0.7 * v.wire_v + v.shunt_v),
    "jump": lambda v: (1.5 * v.wire_v, v.shunt_v),
    "outside": lambda v: (4.0 * v.wire_v, v.shunt_v),
    "saturated": lambda v: (v.ranges_v[0], v.shunt_v),
    "frozen": lambda v: (v.last_wire_v, v.shunt_v),
    "over-current": lambda v: (6.0 * v.wire_v, 6.0 * v.shunt_v),
    "output stuck": lambda v: (3.0 * v.wire_v + 1.0, 3.0 * v.shunt_v),
}


def exercise(
    reference: ReferenceTick,
    seed: int,
    ticks: int,
    *,
    tick_s: float = 0.05,
    ticks_a_control: int = 1,
    fault_probability: float = 0.01,
) -> Iterator[ExerciseRow]:
    """Run the reference through random ticks, each with a ``fault_probability``, and start it again after a trip."""
    random = np.random.default_rng(require_seed(seed))
    bench = (_WireInAir if reference.estimator == FILTER else _RandomWalkWire)(reference, random)
    start, tripped_for = True, 0
    fault, fault_left = "", 0
    for index in range(ticks):
        if start:
            reference.start()
            fault_left = tripped_for = 0
        wire_v, shunt_v = bench.read(tick_s, ticks_a_control)
        if fault_left == 0 and random.random() < fault_probability:
            fault = str(random.choice(list(FAULTS)))
            fault_left = int(random.integers(1, max(2, int(MAX_FAULT_S / tick_s))))
        if fault_left:
            fault_left -= 1
            wire_v, shunt_v = (_single(v) for v in FAULTS[fault](bench.voltages(wire_v, shunt_v)))
        bench.last_wire_v = wire_v
        target = bench.target_after(tick_s)
        control_s = _single(tick_s * ticks_a_control) if (index + 1) % ticks_a_control == 0 else 0.0
        outcome = reference.sample(wire_v, shunt_v, _single(tick_s))
        if control_s:
            outcome = reference.control(target, control_s)
        yield ExerciseRow(start, wire_v, shunt_v, target, _single(tick_s), control_s, outcome)
        tripped_for = tripped_for + 1 if outcome.state == 4 else 0
        start = tripped_for > 3


class _RandomWalkWire:
    """A wire whose resistance follows a random walk, in the circuit of the protection's limits."""

    def __init__(self, reference: ReferenceTick, random: np.random.Generator) -> None:
        self._reference, self._random = reference, random
        self._normalised_resistance = 1.0
        # Never the very end of the range, where a cold wire's estimate does not change: an error of exactly 0 there is
        # 1e-9 in single precision, and some rule bases jump in between.
        self._target = _single(0.9 * reference.model.quantity_min + 0.1 * reference.model.quantity_max)
        self.last_wire_v = 0.0

    def _resistance_after(self, tick_s: float, ticks_a_control: int) -> float:
        """Return the resistance [ohm] a tick later."""
        del tick_s
        step = WALK_FRACTION / ticks_a_control
        walked = self._normalised_resistance + self._random.uniform(-step, step)
        self._normalised_resistance = min(max(walked, -0.01), 1.01)
        return self._resistance_ohm()

    def _resistance_ohm(self) -> float:
        model = self._reference.model
        span_ohm = model.resistance_max_ohm - model.resistance_min_ohm
        return model.resistance_min_ohm + self._normalised_resistance * span_ohm

    def read(self, tick_s: float, ticks_a_control: int) -> tuple[float, float]:
        """Return both voltages a tick later, at the present drive and with noise."""
        limits = self._reference.protection_limits
        resistance = self._resistance_after(tick_s, ticks_a_control)
        current = self._reference.drive_voltage_v / (resistance + limits.shunt_resistance_ohm)
        noise = self._random.normal(0.0, NOISE_V, 2)
        return (
            _single(current * resistance + float(noise[0])),
            _single(current * limits.shunt_resistance_ohm + float(noise[1])),
        )

    def voltages(self, wire_v: float, shunt_v: float) -> ExerciseVoltages:
        """Return two readings with what a fault may depend on."""
        limits = self._reference.protection_limits
        return ExerciseVoltages(wire_v, shunt_v, self.last_wire_v, (limits.wire_range_v, limits.shunt_range_v))

    def target_after(self, tick_s: float) -> float:
        """Return the target, which occasionally jumps to another value in the range."""
        model = self._reference.model
        if self._random.random() < tick_s * TARGET_CHANGES_EACH_S:
            self._target = _single(self._random.uniform(model.quantity_min, model.quantity_max))
        return _single(self._target)


class _WireInAir(_RandomWalkWire):
    """A wire with the heat balance and the play of its model, for a filter that believes in both.

    What power and resistance say that have nothing to do with one another has no bound in single precision: the filter
    is lost, and which way it is found again hangs on the last digit.
    """

    def __init__(self, reference: ReferenceTick, random: np.random.Generator) -> None:
        super().__init__(reference, random)
        self._numbers, tables = filter_numbers(reference.model, reference.protection_limits.shunt_resistance_ohm)
        self._heating_w, self._cooling_w, self._heating, self._cooling = tables.T
        self._places = np.linspace(self._numbers["first_place"], self._numbers["last_place"], len(tables))
        self._steady_w, self._place = float(self._heating_w[0]), float(self._places[0])

    def _resistance_after(self, tick_s: float, ticks_a_control: int) -> float:
        """Return the resistance [ohm] a tick later: on a branch the place moves, and takes its heat."""
        del ticks_a_control
        resistance_ohm, numbers = self._resistance_ohm(), self._numbers
        circuit_ohm = resistance_ohm + self._reference.protection_limits.shunt_resistance_ohm
        power_w = (self._reference.drive_voltage_v / circuit_ohm) ** 2 * resistance_ohm
        free_w = self._steady_w + (power_w - self._steady_w) * -math.expm1(-tick_s / numbers["time_constant_s"])
        heat_j = numbers["transformation_heat_j"] if self._place > numbers["sensed_from"] else 0.0
        taken_w = heat_j / numbers["time_constant_s"] * (self._places - self._place)
        if free_w > np.interp(self._place, self._places, self._heating_w):
            branch_w = self._heating_w
        elif free_w < np.interp(self._place, self._places, self._cooling_w):
            branch_w = self._cooling_w
        else:
            branch_w = None
        if branch_w is not None:
            self._place = float(np.interp(free_w, branch_w + taken_w, self._places))
            free_w = float(np.interp(self._place, self._places, branch_w))
        self._steady_w = free_w
        cooling_w, heating_w = (np.interp(self._place, self._places, one) for one in (self._cooling_w, self._heating_w))
        part = min(max((free_w - cooling_w) / (heating_w - cooling_w), 0.0), 1.0)
        cooling, heating = (np.interp(self._place, self._places, one) for one in (self._cooling, self._heating))
        self._normalised_resistance = float(cooling + part * (heating - cooling))
        return self._resistance_ohm()


def _single(value: float) -> float:
    """Return the nearest number that single precision holds, so that both precisions start from the same value."""
    return float(np.float32(value))


SEED = 2010
CALM = 150  # ticks without faults
FAULTY = 250  # ticks with faults at the control rate
FAST = 300  # ticks of a converter that is faster than the controller
INPUTS = ("start", "wire_voltage_v", "shunt_voltage_v", "target", "tick_s", "control_s")


def golden_ticks(reference: ReferenceTick) -> list[ExerciseRow]:
    """Return the ticks of the golden vectors, the same each time."""
    return list(
        chain(
            exercise(reference, SEED, CALM, fault_probability=0.0),
            exercise(reference, SEED + 1, FAULTY, fault_probability=0.05),
            exercise(reference, SEED + 2, FAST, tick_s=0.002, ticks_a_control=10, fault_probability=0.01),
        )
    )


def golden_vectors(reference: ReferenceTick) -> str:
    """Return the golden vectors as comma-separated values; every number reads back as the same double."""
    names = dict(zip(GAINS, reference.recorded, strict=True))
    lines = [",".join((*INPUTS, *(names.get(name, name) for name in TickOutcome._fields)))]
    for tick in golden_ticks(reference):
        values = (*tick[:-1], *tick.outcome)
        lines.append(",".join(_text(value) for value in values))
    return "\n".join(lines) + "\n"


def _text(value: float) -> str:
    return str(int(value)) if isinstance(value, (bool, int)) else repr(float(value))
