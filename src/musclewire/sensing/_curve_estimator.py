"""An estimator on a wire's resistance curve: its state is a row of numbers, and its step is one compiled tick.

What the ticks of all such estimators have in common is here, too: reading, friction on a known spring, and answer.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import callback, compiled_inner
from musclewire.physics import MINIMUM_CURRENT_A, friction_force_n, series_resistance_ohm
from musclewire.sensing._curve import CURVE_NUMBERS, ResistanceCurve, Row
from musclewire.sensing._estimator import MAX_DROPOUTS, dropout_failure
from musclewire.sensing._known_load import KnownSpring
from musclewire.signals import (
    ESTIMATOR_ANSWERS,
    CompiledTick,
    EstimatorStep,
    QuantityEstimate,
    Reason,
    WireEstimate,
    WireSample,
)

REASONS, VALID = tuple(Reason), Reason.OK
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
# Constants, state, sample and answer.
N_ARRAYS = 4


class CurveEstimator:
    """Runs a tick on copies of its state, which are named tuples of numbers.

    Parameters
    ----------
    curve
        The wire's resistance curve; its coefficients follow the numbers in what the tick reads.
    function
        The tick, a function of four arrays; see ``signals._compiled_tick``.
    numbers
        What does not change in a run, in the order in which the tick reads it.
    first_state
        The state before the first sample, in the order in which the tick reads it.
    """

    columns: tuple[str, ...] = ("wire_resistance_ohm",)
    has_c_form = True

    def __init__(self, curve: ResistanceCurve, function: Any, numbers: Sequence[float], first_state: Any) -> None:
        """Take the tick, and compile it here: not in the first sample of a loop."""
        self.curve, self.quantity = curve, curve.quantity
        constants = np.concatenate([numbers, curve.coefficients_in_turns])
        self._function, self._constants = function, constants
        self._tick = CompiledTick(function, constants, np.array(first_state))
        self._first_state, self._state_of = first_state, type(first_state)._make
        callback(function, N_ARRAYS)

    def start(self) -> Any:
        """Return the state before the first sample."""
        return self._first_state

    def step(self, state: Any, sample: WireSample) -> EstimatorStep:
        """Return the estimate of one sample."""
        row, answer = np.array(state), np.empty(len(ESTIMATOR_ANSWERS) + len(self.columns))
        self._function(self._constants, row, np.array(sample[:4], np.float64), answer)
        value, std, _, number, failed, *recorded = answer.tolist()
        reason, after = REASONS[int(number)], self._state_of(row.tolist())
        failure = self._failure(after, reason, sample, recorded[0]) if failed else ""
        wire = WireEstimate(*recorded[1:]) if self.columns[1:] == WireEstimate._fields else None
        estimate = QuantityEstimate(value, std, reason is VALID, reason, failure, wire)
        return EstimatorStep(estimate, after, tuple(recorded))

    def _failure(self, state: Any, reason: Reason, sample: WireSample, resistance_ohm: float) -> str:
        """Return why a run must end; with another wire's resistance it would read as cold and be overheated."""
        if reason is Reason.NO_CURRENT:
            return dropout_failure(round(state.dropouts), sample)
        low, high = self.curve.resistance_min_ohm, self.curve.resistance_max_ohm
        return (
            f"resistance {resistance_ohm:.3f} ohm at {sample.time_s:.2f} s is not this model's wire ({low:.3f} to "
            f"{high:.3f} ohm): check wire and wiring, or make a home move; the rig is at its sense voltage"
        )


def estimator_numbers(
    curve: ResistanceCurve, shunt_resistance_ohm: float, load: KnownSpring | None
) -> dict[str, float]:
    """Return the numbers that the ticks of all estimators on a curve read, by name."""
    low_ohm, high_ohm = curve.own_resistance_ohm
    return {
        "shunt_resistance_ohm": shunt_resistance_ohm,
        "own_low_ohm": low_ohm,
        "own_high_ohm": high_ohm,
        "stiffness_n_per_m": 0.0 if load is None else load.stiffness_n_per_m,
        "load_friction_n": 0.0 if load is None else load.friction_n,
        "turning_m": 0.0 if load is None else load.turning_m,
        **curve.numbers,
    }


NO_CURRENT, OK = float(Reason.NO_CURRENT), float(Reason.OK)

series_resistance = compiled_inner(series_resistance_ohm)


@compiled_inner
def resistance_of(numbers: Row, wire_voltage_v: float, shunt_voltage_v: float) -> float:
    """Return the resistance [ohm] by Eq. 1, 0 without current."""
    if not abs(shunt_voltage_v) >= MINIMUM_CURRENT_A * numbers.shunt_resistance_ohm:
        return 0.0
    resistance_ohm = series_resistance(wire_voltage_v, shunt_voltage_v, numbers.shunt_resistance_ohm)
    return resistance_ohm if 0.0 < resistance_ohm < math.inf else 0.0


@compiled_inner
def answer_with(
    answer: FloatArray, value: float, std: float, reason: float, in_a_row: float, resistance_ohm: float
) -> None:
    """Write the answer of a tick, which fails after too many bad samples in a row, and the resistance to record."""
    answer[0] = value
    answer[1] = std
    answer[2] = 1.0 if reason == OK else 0.0
    answer[3] = reason
    answer[4] = 1.0 if in_a_row >= MAX_DROPOUTS else 0.0
    answer[5] = resistance_ohm


@compiled_inner
def answer_without_current(numbers: Row, state: Row, answer: FloatArray) -> None:
    """Bridge a sample without current by the last value."""
    state.dropouts += 1.0
    answer_with(answer, state.value, numbers.quantity_span, NO_CURRENT, state.dropouts, 0.0)


@compiled_inner
def add_friction(numbers: Row, state: Row, spring_force_n: float) -> None:
    """Follow the guide's friction in addition to a known spring's force."""
    if state.spring_known != 0.0:
        moved_m = (spring_force_n - state.spring_force_n) / numbers.stiffness_n_per_m
        state.friction_n = friction_force_n(state.friction_n, moved_m, numbers.load_friction_n, numbers.turning_m)
    state.spring_known = 1.0
    state.spring_force_n = spring_force_n
