"""What the ticks of the estimators on a resistance curve have in common: reading, friction and answer, compiled."""

from __future__ import annotations

import math

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled
from musclewire.physics import MINIMUM_CURRENT_A, friction_force_n, series_resistance_ohm
from musclewire.sensing._curve_tick import CURVE_NUMBERS, Row
from musclewire.sensing._estimator import MAX_DROPOUTS
from musclewire.signals import Reason

__all__ = [
    "ESTIMATOR_NUMBERS",
    "add_friction",
    "answer_with",
    "answer_without_current",
    "resistance_of",
]

# The numbers of every such estimator, by name: circuit, own wire, known spring (a stiffness of 0 without one), curve.
ESTIMATOR_NUMBERS = (
    "shunt_resistance_ohm",
    "own_low_ohm",
    "own_high_ohm",
    "stiffness_n_per_m",
    "load_friction_n",
    "turning_m",
    *CURVE_NUMBERS,
)
NO_CURRENT, OK, MISMATCH = float(Reason.NO_CURRENT), float(Reason.OK), float(Reason.MISMATCH)

series_resistance = compiled(series_resistance_ohm)


@compiled
def resistance_of(numbers: Row, wire_voltage_v: float, shunt_voltage_v: float) -> float:
    """Return the resistance [ohm] by Eq. 1, 0 without current."""
    if not abs(shunt_voltage_v) >= MINIMUM_CURRENT_A * numbers.shunt_resistance_ohm:
        return 0.0
    resistance_ohm = series_resistance(wire_voltage_v, shunt_voltage_v, numbers.shunt_resistance_ohm)
    return resistance_ohm if 0.0 < resistance_ohm < math.inf else 0.0


@compiled
def answer_with(
    answer: FloatArray, value: float, std: float, reason: float, failed: bool, resistance_ohm: float
) -> None:
    """Write the answer of a tick, and the resistance that is recorded with it."""
    answer[0] = value
    answer[1] = std
    answer[2] = 1.0 if reason == OK else 0.0
    answer[3] = reason
    answer[4] = 1.0 if failed else 0.0
    answer[5] = resistance_ohm


@compiled
def answer_without_current(numbers: Row, state: Row, answer: FloatArray) -> None:
    """Bridge a sample without current by the last value."""
    state.dropouts += 1.0
    answer_with(answer, state.value, numbers.quantity_span, NO_CURRENT, state.dropouts >= MAX_DROPOUTS, 0.0)


@compiled
def add_friction(numbers: Row, state: Row, spring_force_n: float) -> None:
    """Follow the guide's friction in addition to a known spring's force."""
    if state.spring_known != 0.0:
        moved_m = (spring_force_n - state.spring_force_n) / numbers.stiffness_n_per_m
        state.friction_n = friction_force_n(state.friction_n, moved_m, numbers.load_friction_n, numbers.turning_m)
    state.spring_known = 1.0
    state.spring_force_n = spring_force_n
