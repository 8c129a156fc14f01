"""The paper's estimator: Eq. 1, the polynomials of Eqs. 3 to 5, and the segment of the loop in which the wire is.

In addition, samples without current are bridged, the resistance of another wire is detected, segment A-B of a cold wire
is distinguished from B-C, and on a known spring the guide's friction is added to the force.

One resistance near its maximum has two meanings: a cold wire on its way from A to B, which hardly strains, or a
wire between B and C, which does (Lan and Fan 2010, Fig. 3b). They differ in sign: from A to B
resistance rises as the wire is heated, from B to C it falls. The direction of the last change of electrical power is
therefore compared with the direction in which the resistance changes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.physics import MINIMUM_CURRENT_A, ResistanceReading, wire_resistance
from musclewire.sensing._curve import MISMATCH_FRACTION, ResistanceCurve
from musclewire.sensing._estimator import MAX_DROPOUTS, EstimatorSetup, dropout_failure
from musclewire.sensing._known_load import KnownSpring
from musclewire.signals import CompiledTick, EstimatorStep, QuantityEstimate, Reason, WireSample

__all__ = [
    "AMBIGUOUS_ABOVE",
    "MISMATCH_FRACTION",
    "PolynomialEstimator",
    "PolynomialState",
    "SegmentTrackerState",
    "SegmentTracker",
    "mismatch_failure",
    "polynomial_estimator",
]

# What every sample compares with: to look up a member of an enumeration takes longer than to compare it.
OK = Reason.OK


# Nearer to R_min than this, as normalised resistance, a wire cannot be in segment A-B: from A to B resistance rises
# by a few percent, from B to C it falls by more than ten (Lan and Fan 2010, Fig. 3b).
AMBIGUOUS_ABOVE = 0.8
# A change of the smoothed resistance counts from this fraction of the span. At the sense voltage the current is small
# and the noise of one sample is one to two hundredths of it; a mean over eight samples reduces it to well below.
MIN_CHANGE = 0.02
SMOOTHING_SAMPLES = 8.0
# A change of power counts from this fraction.
MIN_POWER_CHANGE = 0.02


class SegmentTrackerState(NamedTuple):
    """State of a :class:`SegmentTracker` between two samples.

    Parameters
    ----------
    sensing
        Whether strain can be sensed: the wire is between B and C.
    heating
        Whether power has last been rising.
    power_extreme_w
        Extreme of the power since it turned [W].
    resistance_anchor_ohm
        Resistance from which a change in the opposite direction is counted [ohm].
    smoothed_ohm
        Resistance, smoothed over eight samples [ohm].
    """

    sensing: bool
    heating: bool
    power_extreme_w: float
    resistance_anchor_ohm: float
    smoothed_ohm: float


class SegmentTracker:
    """Follows a wire through A-B and B-C; state in, state out.

    Parameters
    ----------
    resistance_min_ohm
        R_min of the wire's model [ohm].
    resistance_max_ohm
        R_max of the wire's model [ohm].
    """

    def __init__(self, resistance_min_ohm: float, resistance_max_ohm: float) -> None:
        """Take R_min and R_max of the wire's model."""
        span = resistance_max_ohm - resistance_min_ohm
        self._ambiguous_above_ohm = resistance_min_ohm + AMBIGUOUS_ABOVE * span
        self._min_change_ohm = MIN_CHANGE * span

    def tick_constants(self) -> dict[str, float]:
        """Return the numbers that ``step`` reads, by their names in ``polynomial_tick.CONSTANTS``."""
        return {
            "ambiguous_above_ohm": self._ambiguous_above_ohm,
            "min_change_ohm": self._min_change_ohm,
            "smoothing_samples": SMOOTHING_SAMPLES,
            "min_power_change": MIN_POWER_CHANGE,
        }

    def start(self, resistance_ohm: float, power_w: float) -> SegmentTrackerState:
        """Return the state for a first sample: near R_max a wire counts as cold until a change shows otherwise.

        Parameters
        ----------
        resistance_ohm
            Resistance [ohm].
        power_w
            Electrical power [W].

        Returns
        -------
        The state.
        """
        cold = resistance_ohm >= self._ambiguous_above_ohm
        return SegmentTrackerState(not cold, True, power_w, resistance_ohm, resistance_ohm)

    def step(self, state: SegmentTrackerState, resistance_ohm: float, power_w: float) -> SegmentTrackerState:
        """Return the state after one more sample with current.

        Parameters
        ----------
        state
            The state before.
        resistance_ohm
            Resistance [ohm].
        power_w
            Electrical power [W].

        Returns
        -------
        The state after.
        """
        sensing, heating, extreme, anchor, smoothed = state
        smoothed += (resistance_ohm - smoothed) / SMOOTHING_SAMPLES
        if heating:
            extreme = max(extreme, power_w)
            turned = power_w < extreme * (1.0 - MIN_POWER_CHANGE)
        else:
            extreme = min(extreme, power_w)
            turned = power_w > extreme * (1.0 + MIN_POWER_CHANGE)
        if turned:
            heating, extreme, anchor = not heating, power_w, smoothed
        # The anchor follows changes in the direction of this segment; a change in the opposite one is of the other
        # segment.
        if sensing == heating:
            anchor = min(anchor, smoothed)
            opposite_ohm = smoothed - anchor
        else:
            anchor = max(anchor, smoothed)
            opposite_ohm = anchor - smoothed
        if opposite_ohm > self._min_change_ohm:
            sensing, anchor = not sensing, smoothed
        return SegmentTrackerState(sensing or smoothed < self._ambiguous_above_ohm, heating, extreme, anchor, smoothed)

    def track(
        self, resistance_ohm: FloatArray, power_w: FloatArray, valid: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """Return for each sample of a recording whether strain can be sensed.

        Parameters
        ----------
        resistance_ohm
            Resistances [ohm], shape (n_times,).
        power_w
            Electrical power [W], shape (n_times,).
        valid
            Which samples have current, shape (n_times,); the others are skipped and not sensed.

        Returns
        -------
        Whether strain can be sensed, shape (n_times,).
        """
        sensing = np.zeros(resistance_ohm.shape, dtype=np.bool_)
        state: SegmentTrackerState | None = None
        for row in np.flatnonzero(valid):
            resistance, power = float(resistance_ohm[row]), float(power_w[row])
            state = self.start(resistance, power) if state is None else self.step(state, resistance, power)
            sensing[row] = state.sensing
        return sensing


class PolynomialState(NamedTuple):
    """The estimator's state.

    The last value, samples in a row without current and with another wire's resistance, the segment (None before the
    first sample), and on a known spring its last force [N] and the friction [N].
    """

    value: float
    dropouts: int
    mismatches: int
    segment: SegmentTrackerState | None
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
        """Take the numbers; the state of a run is not kept here."""
        self.curve, self.load = curve, load
        self.quantity = curve.quantity
        self._shunt_resistance_ohm = shunt_resistance_ohm
        self._tracker = SegmentTracker(curve.resistance_min_ohm, curve.resistance_max_ohm)
        margin = MISMATCH_FRACTION * (curve.resistance_max_ohm - curve.resistance_min_ohm)
        self._own_ohm = (curve.resistance_min_ohm - margin, curve.resistance_max_ohm + margin)
        self._full = curve.quantity_max - curve.quantity_min

    def start(self) -> PolynomialState:
        """Return the state before the first sample.

        A wire that was warmed up has been contracting: it pulls against the friction.
        """
        friction_n = 0.0 if self.load is None else self.load.friction_n
        return PolynomialState(self.curve.quantity_min, 0, 0, None, None, friction_n)

    def step(self, state: PolynomialState, sample: WireSample) -> EstimatorStep:
        """Return the estimate of one sample."""
        resistance_ohm, has_current = self.read(sample.wire_voltage_v, sample.shunt_voltage_v)
        if not has_current:
            return self._without_current(state, sample)
        read, std, in_range = self.curve.estimate(resistance_ohm)
        low_ohm, high_ohm = self._own_ohm
        own = low_ohm <= resistance_ohm <= high_ohm
        _, _, mismatches, segment, spring_force_n, friction_n = state
        if self.load is not None:
            friction_n, spring_force_n = self._friction_after(state, read), read
        # Once between B and C the wire remains there: a reference is within the model's range.
        if in_range and not (segment is not None and segment.sensing):
            segment = self._segment_after(segment, sample, resistance_ohm)
        value, mismatches = read + friction_n, 0 if own else mismatches + 1
        # The usual case first; without a function, which a loop at 1 kHz would call in every sample.
        sensing = in_range and segment is not None and segment.sensing
        reason = OK if sensing else self._reason(own, in_range)
        failure = mismatch_failure(self.curve, resistance_ohm, sample) if mismatches >= MAX_DROPOUTS else ""
        return EstimatorStep(
            QuantityEstimate(value, std, reason is OK, reason, failure),
            PolynomialState(value, 0, mismatches, segment, spring_force_n, friction_n),
            (resistance_ohm,),
        )

    def _without_current(self, state: PolynomialState, sample: WireSample) -> EstimatorStep:
        """Return the last value for a sample without current."""
        state = state._replace(dropouts=state.dropouts + 1)
        failure = dropout_failure(state.dropouts, sample)
        return EstimatorStep(
            QuantityEstimate(state.value, self._full, False, Reason.NO_CURRENT, failure), state, (0.0,)
        )

    def compiled_tick(self) -> CompiledTick | None:
        """Return ``step`` as a compiled function."""
        from musclewire.sensing import _polynomial_tick as polynomial_tick

        curve, load = self.curve, self.load
        known = load is None or type(load) is KnownSpring
        if not known or type(curve).estimate is not ResistanceCurve.estimate:  # other parts estimate otherwise
            return None
        constants = np.zeros(1, polynomial_tick.CONSTANTS)
        low_ohm, high_ohm = self._own_ohm
        numbers = {
            "shunt_resistance_ohm": self._shunt_resistance_ohm,
            "minimum_current_a": MINIMUM_CURRENT_A,
            "own_low_ohm": low_ohm,
            "own_high_ohm": high_ohm,
            "allowed_samples": MAX_DROPOUTS,
            **curve.tick_constants(),
            **self._tracker.tick_constants(),
        }
        if load is not None:
            numbers |= {"loaded": 1.0, "stiffness_n_per_m": load.stiffness_n_per_m}
            numbers |= {"load_friction_n": load.friction_n, "turning_m": load.turning_m}
        for name, number in numbers.items():
            constants[name] = number
        state = np.zeros(1, polynomial_tick.STATE)
        start = self.start()
        state["value"], state["friction_n"] = start.value, start.friction_n
        both = np.array(curve.falling_coefficients).reshape(-1)
        return CompiledTick(
            polynomial_tick.tick, np.concatenate([constants.view(np.float64), both]), state.view(np.float64)
        )

    def read(self, wire_voltage_v: float, shunt_voltage_v: float) -> ResistanceReading:
        """Return the resistance of two voltages by Eq. 1, as the C form does.

        Parameters
        ----------
        wire_voltage_v
            Voltage across the wire [V].
        shunt_voltage_v
            Voltage across the shunt [V].

        Returns
        -------
        The reading; it is not valid without current.
        """
        return wire_resistance(wire_voltage_v, shunt_voltage_v, self._shunt_resistance_ohm)

    def re_anchored(self, resistance_min_ohm: float, resistance_max_ohm: float) -> PolynomialEstimator:
        """Return the same estimator between new resistances of C and B (Eq. 3 re-anchored).

        Parameters
        ----------
        resistance_min_ohm
            R_min of today [ohm].
        resistance_max_ohm
            R_max of today [ohm].

        Returns
        -------
        The estimator of today.

        Raises
        ------
        CallerError
            Unless 0 < R_min < R_max.
        """
        curve = replace(self.curve, resistance_min_ohm=resistance_min_ohm, resistance_max_ohm=resistance_max_ohm)
        return PolynomialEstimator(curve, self._shunt_resistance_ohm, self.load)

    @staticmethod
    def _reason(own: bool, in_range: bool) -> Reason:
        """Return why a sample with current is not valid."""
        if in_range:
            return Reason.COLD
        return Reason.OUT_OF_RANGE if own else Reason.MISMATCH

    def _friction_after(self, state: PolynomialState, spring_force_n: float) -> float:
        """Return the friction in addition to a known spring [N], by the direction of motion."""
        if self.load is None or state.spring_force_n is None:
            return state.friction_n
        return self.load.friction_after(state.friction_n, spring_force_n - state.spring_force_n)

    def _segment_after(
        self, segment: SegmentTrackerState | None, sample: WireSample, resistance_ohm: float
    ) -> SegmentTrackerState:
        """Return the segment after a sample of a wire on its way from a cold start to between B and C."""
        power_w = sample.wire_voltage_v * sample.wire_voltage_v / resistance_ohm
        if segment is None:
            return self._tracker.start(resistance_ohm, power_w)
        return self._tracker.step(segment, resistance_ohm, power_w)


def mismatch_failure(curve: ResistanceCurve, resistance_ohm: float, sample: WireSample) -> str:
    """Return why a run must end: the wire would read as cold and be overheated."""
    low, high = curve.resistance_min_ohm, curve.resistance_max_ohm
    return (
        f"resistance {resistance_ohm:.3f} ohm at {sample.time_s:.2f} s is not this model's wire ({low:.3f} to "
        f"{high:.3f} ohm): check wire and wiring, or make a home move; the rig is at its sense voltage"
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
    return PolynomialEstimator(setup.model.curve(), setup.shunt_resistance_ohm, setup.load)
