"""An estimator on a wire's resistance curve: its state is a row of numbers, and its step is one compiled tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from musclewire.compiled import callback
from musclewire.sensing._curve import ResistanceCurve
from musclewire.sensing._estimator import dropout_failure
from musclewire.sensing._known_load import KnownSpring
from musclewire.signals import ESTIMATOR_ANSWERS, CompiledTick, EstimatorStep, QuantityEstimate, Reason, WireSample

__all__ = ["CurveEstimator", "estimator_numbers"]

REASONS, OK = tuple(Reason), Reason.OK
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

    columns = ("wire_resistance_ohm",)
    has_c_form = True
    slow_part = None

    def __init__(self, curve: ResistanceCurve, function: Any, numbers: Sequence[float], first_state: Any) -> None:
        """Take the tick, and compile it here: not in the first sample of a loop."""
        self.curve, self.quantity = curve, curve.quantity
        constants = np.concatenate([numbers, curve.coefficients_in_turns])
        self._tick = CompiledTick(function, constants, np.array(first_state))
        self._first_state, self._state_of = first_state, type(first_state)._make
        callback(function, N_ARRAYS)

    def start(self) -> Any:
        """Return the state before the first sample."""
        return self._first_state

    def step(self, state: Any, sample: WireSample) -> EstimatorStep:
        """Return the estimate of one sample."""
        row, answer = np.array(state), np.empty(len(ESTIMATOR_ANSWERS) + 1)
        self._tick.function(self._tick.constants, row, np.array(sample[:4], np.float64), answer)
        value, std, _, number, failed, resistance_ohm = answer.tolist()
        reason, after = REASONS[int(number)], self._state_of(row.tolist())
        failure = self._failure(after, reason, sample, resistance_ohm) if failed else ""
        return EstimatorStep(QuantityEstimate(value, std, reason is OK, reason, failure), after, (resistance_ohm,))

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
