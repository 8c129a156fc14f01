"""The paper's estimator: Eq. 1, the polynomials of Eqs. 3 to 5, and where on the curve the wire is.

Around them: samples without current are bridged, a resistance of another wire is noticed, a cold wire's A-B is
distinguished from B-C, and on a known spring the guide's friction is added to the force.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from musclewire.sensing.curve import Estimate, ResistanceCurve
from musclewire.sensing.estimator import MAX_DROPOUTS, EstimatorSetup, dropout_failure
from musclewire.sensing.known_load import KnownSpring
from musclewire.sensing.resistance import ResistanceReading, wire_resistance
from musclewire.sensing.tracking import SegmentState, SegmentTracker
from musclewire.signals.samples import EstimatorStep, QuantityEstimate, Reason, WireSample

__all__ = ["PolynomialEstimator", "PolynomialState", "polynomial_estimator"]

# So far outside R_min..R_max, as a fraction of their span, no sample of this wire can be: another wire, or a fault.
MISMATCH_FRACTION = 0.15


class PolynomialState(NamedTuple):
    """All the estimator remembers of the samples so far.

    The last value, samples in a row without current and with another wire's resistance, the segment (None before the
    first sample), and on a known spring its last force [N] and the friction [N].
    """

    value: float
    dropouts: int
    mismatches: int
    segment: SegmentState | None
    spring_force_n: float | None
    friction_n: float


class PolynomialEstimator:
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

    columns = ("wire_resistance_ohm",)
    has_c_form = True
    slow_part = None

    def __init__(self, curve: ResistanceCurve, shunt_resistance_ohm: float, load: KnownSpring | None = None) -> None:
        """Take the numbers; nothing of a run is kept here."""
        self.curve, self.load = curve, load
        self.quantity = curve.quantity
        self._shunt_resistance_ohm = shunt_resistance_ohm
        self._tracker = SegmentTracker(curve.resistance_min_ohm, curve.resistance_max_ohm)
        margin = MISMATCH_FRACTION * (curve.resistance_max_ohm - curve.resistance_min_ohm)
        self._own_ohm = (curve.resistance_min_ohm - margin, curve.resistance_max_ohm + margin)
        self._full = curve.quantity_max - curve.quantity_min

    def start(self) -> PolynomialState:
        """Return the state of a wire of which nothing is known.

        One that was warmed up has been contracting: it pulls against the friction.
        """
        friction_n = 0.0 if self.load is None else self.load.friction_n
        return PolynomialState(self.curve.quantity_min, 0, 0, None, None, friction_n)

    def step(self, state: PolynomialState, sample: WireSample) -> EstimatorStep:
        """Return the estimate of one sample."""
        reading = self.read(sample.wire_voltage_v, sample.shunt_voltage_v)
        if not reading.valid:
            state = state._replace(dropouts=state.dropouts + 1)
            failure = dropout_failure(state.dropouts, sample)
            return EstimatorStep(
                QuantityEstimate(state.value, self._full, False, Reason.NO_CURRENT, failure), state, (0.0,)
            )
        resistance_ohm = reading.resistance_ohm
        read = self.curve.estimate(resistance_ohm)
        own = self._own_ohm[0] <= resistance_ohm <= self._own_ohm[1]
        friction_n = self._friction_after(state, read.value)
        segment = self._segment_after(state.segment, sample, resistance_ohm) if read.valid else state.segment
        state = PolynomialState(
            value=read.value + friction_n,
            dropouts=0,
            mismatches=0 if own else state.mismatches + 1,
            segment=segment,
            spring_force_n=None if self.load is None else read.value,
            friction_n=friction_n,
        )
        reason = self._reason(own, read, segment)
        failure = self._mismatch_failure(resistance_ohm, sample) if state.mismatches >= MAX_DROPOUTS else ""
        estimate = QuantityEstimate(state.value, read.std, reason is Reason.OK, reason, failure)
        return EstimatorStep(estimate, state, (resistance_ohm,))

    def read(self, wire_voltage_v: float, shunt_voltage_v: float) -> ResistanceReading:
        """Return the resistance of two voltages [V] by Eq. 1, which is what the C form reads too."""
        return wire_resistance(wire_voltage_v, shunt_voltage_v, self._shunt_resistance_ohm)

    def re_anchored(self, resistance_min_ohm: float, resistance_max_ohm: float) -> PolynomialEstimator:
        """Return the same estimator between new resistances of C and B [ohm] (Eq. 3 re-anchored).

        Raises CallerError unless 0 < R_min < R_max.
        """
        curve = replace(self.curve, resistance_min_ohm=resistance_min_ohm, resistance_max_ohm=resistance_max_ohm)
        return PolynomialEstimator(curve, self._shunt_resistance_ohm, self.load)

    @staticmethod
    def _reason(own: bool, read: Estimate, segment: SegmentState | None) -> Reason:
        """Return why a sample with current is valid or not."""
        if not read.valid:
            return Reason.OUT_OF_RANGE if own else Reason.MISMATCH
        return Reason.OK if segment is not None and segment.sensing else Reason.COLD

    def _friction_after(self, state: PolynomialState, spring_force_n: float) -> float:
        """Return the friction that the wire pulls beside a known spring, by which way it has been moving [N]."""
        if self.load is None or state.spring_force_n is None:
            return state.friction_n
        return self.load.friction_after(state.friction_n, spring_force_n - state.spring_force_n)

    def _segment_after(self, segment: SegmentState | None, sample: WireSample, resistance_ohm: float) -> SegmentState:
        """Return whether the wire has come from its cold start to between B and C.

        Once there it stays there: a reference keeps within the model's range, so the wire is not let go cold.
        """
        power_w = sample.wire_voltage_v * sample.wire_voltage_v / resistance_ohm
        if segment is None:
            return self._tracker.start(resistance_ohm, power_w)
        return segment if segment.sensing else self._tracker.step(segment, resistance_ohm, power_w)

    def _mismatch_failure(self, resistance_ohm: float, sample: WireSample) -> str:
        """Return why a run must end: the wire would read as cold and be overheated."""
        low, high = self.curve.resistance_min_ohm, self.curve.resistance_max_ohm
        return (
            f"resistance {resistance_ohm:.3f} ohm at {sample.time_s:.2f} s is not this model's wire ({low:.3f} to "
            f"{high:.3f} ohm): check wire and wiring, or recalibrate; the rig is at its sense voltage"
        )


def polynomial_estimator(setup: EstimatorSetup) -> PolynomialEstimator:
    """Return the paper's estimator for a loop.

    Parameters
    ----------
    setup
        Model, shunt, and the known spring if force is estimated.

    Returns
    -------
    The estimator.
    """
    return PolynomialEstimator(setup.model, setup.shunt_resistance_ohm, setup.load)
