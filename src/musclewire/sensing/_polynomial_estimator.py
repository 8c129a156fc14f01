"""The paper's estimator: Eq. 1, the polynomials of Eqs. 3 to 5, and the segment of the loop in which the wire is.

In addition, samples without current are bridged, the resistance of another wire is detected, segment A-B of a cold wire
is distinguished from B-C (``_segment_tracking``), and on a known spring the guide's friction is added to the force.
"""

from __future__ import annotations

from typing import NamedTuple

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, row_in
from musclewire.sensing._curve import ResistanceCurve, curve_estimate, row_type
from musclewire.sensing._curve_estimator import (
    ESTIMATOR_NUMBERS,
    CurveEstimator,
    add_friction,
    answer_with,
    answer_without_current,
    estimator_numbers,
    resistance_of,
)
from musclewire.sensing._estimator import EstimatorSetup
from musclewire.sensing._known_load import KnownSpring
from musclewire.sensing._segment_tracking import begin_segment, segment_numbers, track
from musclewire.signals import CompiledTick, Reason

POLYNOMIAL_NUMBERS = (*ESTIMATOR_NUMBERS, "ambiguous_above_ohm", "min_change_ohm")
OK, COLD = float(Reason.OK), float(Reason.COLD)
OUT_OF_RANGE, MISMATCH = float(Reason.OUT_OF_RANGE), float(Reason.MISMATCH)


class PolynomialState(NamedTuple):
    """State of the paper's estimator between two samples; all are numbers."""

    value: float  # the quantity, and on a known spring the friction
    friction_n: float  # on a known spring; a wire that was warmed up has been contracting and pulls against it
    dropouts: float = 0.0  # samples in a row without current
    mismatches: float = 0.0  # samples in a row with another wire's resistance
    tracked: float = 0.0  # 1 once there has been a sample within the range; before it the segment does not count
    sensing: float = 0.0  # 1 if strain can be sensed: the wire is between B and C
    heating: float = 0.0  # 1 if power has last been rising
    power_extreme_w: float = 0.0  # extreme since the power turned
    resistance_anchor_ohm: float = 0.0  # from which a change in the opposite direction is counted
    smoothed_ohm: float = 0.0  # over eight samples
    spring_known: float = 0.0  # 1 once the force of a known spring has been estimated
    spring_force_n: float = 0.0


NUMBERS_ROW, STATE_ROW = row_type(POLYNOMIAL_NUMBERS), row_type(PolynomialState._fields)
N_NUMBERS = len(POLYNOMIAL_NUMBERS)


@compiled
def polynomial_tick(constants: FloatArray, state_array: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Estimate one sample; see ``signals._compiled_tick`` for the arrays."""
    numbers, state = row_in(constants, NUMBERS_ROW), row_in(state_array, STATE_ROW)
    wire_voltage_v, shunt_voltage_v = given[2], given[3]
    resistance_ohm = resistance_of(numbers, wire_voltage_v, shunt_voltage_v)
    if resistance_ohm == 0.0:
        answer_without_current(numbers, state, answer)
        return
    quantity, std, in_range = curve_estimate(numbers, constants[N_NUMBERS:], resistance_ohm, numbers.noise_ohm)
    own = numbers.own_low_ohm <= resistance_ohm <= numbers.own_high_ohm
    if numbers.stiffness_n_per_m > 0.0:
        add_friction(numbers, state, quantity)
    if in_range:
        power_w = wire_voltage_v * wire_voltage_v / resistance_ohm
        if state.tracked == 0.0:
            state.tracked = 1.0
            begin_segment(numbers, state, resistance_ohm, power_w)
        elif state.sensing == 0.0:  # once between B and C the wire remains there: a reference is within the range
            track(numbers, state, resistance_ohm, power_w)
        reason = OK if state.sensing != 0.0 else COLD
    else:
        reason = OUT_OF_RANGE if own else MISMATCH
    state.value = quantity + state.friction_n
    state.dropouts = 0.0
    state.mismatches = 0.0 if own else state.mismatches + 1.0
    answer_with(answer, state.value, std, reason, state.mismatches, resistance_ohm)


class PolynomialEstimator(CurveEstimator):
    """Estimates by the mean of the heating and the cooling polynomial of the normalised resistance.

    Parameters
    ----------
    curve
        The wire's resistance curve.
    shunt_resistance_ohm
        R [ohm] of Eq. 1.
    load
        A known spring, if the curve is one of the force on it; its friction is added in the direction of motion.
    """

    def __init__(self, curve: ResistanceCurve, shunt_resistance_ohm: float, load: KnownSpring | None = None) -> None:
        """Take the numbers; the state of a run is not kept here."""
        numbers = estimator_numbers(curve, shunt_resistance_ohm, load)
        numbers |= segment_numbers(curve.resistance_min_ohm, curve.resistance_max_ohm)
        first_state = PolynomialState(curve.quantity_min, numbers["load_friction_n"])
        super().__init__(curve, polynomial_tick, [numbers[name] for name in POLYNOMIAL_NUMBERS], first_state)

    def compiled_tick(self) -> CompiledTick:
        """Return the tick that ``step`` runs."""
        return self._tick


def polynomial_estimator(setup: EstimatorSetup) -> PolynomialEstimator:
    """Return the paper's estimator for a loop."""
    return PolynomialEstimator(setup.model.curve(), setup.shunt_resistance_ohm, setup.load)
