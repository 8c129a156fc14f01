"""The gated estimator: Eq. 1, then the branch of the direction in which the wire is driven (``gated_branches``).

Samples without current are bridged, another wire's resistance is detected, and on a known spring the guide's
friction is added, all as the paper's estimator does. In contrast to it a reading that no wire of this model can have,
as a contact that jumps gives it, leaves the estimate as it is; and a wire that has cooled beyond B again is cold again.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.physics import MINIMUM_CURRENT_A, ResistanceReading, wire_resistance
from musclewire.sensing._curve import ResistanceCurve
from musclewire.sensing._estimator import MAX_DROPOUTS, EstimatorSetup, dropout_failure
from musclewire.sensing._gated_branches import BranchState, GatedBranches, time_step
from musclewire.sensing._known_load import KnownSpring
from musclewire.sensing._polynomial_estimator import MISMATCH_FRACTION, mismatch_failure
from musclewire.signals import CompiledTick, EstimatorStep, QuantityEstimate, Reason, WireSample

__all__ = ["GatedEstimator", "GatedState", "filled", "gated_estimator"]


class GatedState(NamedTuple):
    """The estimator's state.

    The last value, samples in a row without current and with another wire's resistance, the branches (None
    before the first sample), and on a known spring its last force [N] and the friction [N].
    """

    value: float
    dropouts: int
    mismatches: int
    branches: BranchState | None
    spring_force_n: float | None
    friction_n: float


class GatedEstimator:
    """Estimates by the branch of the direction in which electrical power drives the wire.

    Parameters
    ----------
    curve
        The wire's resistance curve. One whose two branches are equal gives a filtered polynomial.
    shunt_resistance_ohm
        R [ohm] of Eq. 1.
    sample_period_s
        Time [s] between two samples.
    load
        A known spring, if the curve is one of the force on it; its friction is added in the direction of motion.
    """

    columns = ("wire_resistance_ohm",)
    has_c_form = True
    slow_part = None

    def __init__(
        self,
        curve: ResistanceCurve,
        shunt_resistance_ohm: float,
        sample_period_s: float,
        load: KnownSpring | None = None,
    ) -> None:
        """Take the numbers; the state of a run is not kept here."""
        self.curve, self.load = curve, load
        self.quantity = curve.quantity
        self._shunt_resistance_ohm = shunt_resistance_ohm
        self._branches, self._step = GatedBranches(curve), time_step(sample_period_s)
        margin = MISMATCH_FRACTION * (curve.resistance_max_ohm - curve.resistance_min_ohm)
        self._own_ohm = (curve.resistance_min_ohm - margin, curve.resistance_max_ohm + margin)
        self._full = curve.quantity_max - curve.quantity_min
        self._scale_variance = curve.scale_std**2

    def start(self) -> GatedState:
        """Return the state before the first sample."""
        friction_n = 0.0 if self.load is None else self.load.friction_n
        return GatedState(self.curve.quantity_min, 0, 0, None, None, friction_n)

    def step(self, state: GatedState, sample: WireSample) -> EstimatorStep:
        """Return the estimate of one sample."""
        resistance_ohm, has_current = self.read(sample.wire_voltage_v, sample.shunt_voltage_v)
        if not has_current:
            return self._without_current(state, sample)
        low_ohm, high_ohm = self._own_ohm
        if not low_ohm <= resistance_ohm <= high_ohm:
            return self._of_another_wire(state, sample, resistance_ohm)
        power_w = sample.wire_voltage_v * sample.wire_voltage_v / resistance_ohm
        if state.branches is None:
            variance, on_curve, branches = self._branches.start(resistance_ohm, power_w)
        else:
            variance, on_curve, branches = self._branches.step(
                state.branches, resistance_ohm, power_w, sample.shunt_voltage_v, self._step
            )
        spring_force_n, friction_n = state.spring_force_n, state.friction_n
        if self.load is not None:
            if spring_force_n is not None:
                friction_n = self.load.friction_after(friction_n, branches.value - spring_force_n)
            spring_force_n = branches.value
        reason = Reason.OUT_OF_RANGE
        if on_curve:
            reason = Reason.OK if branches.sensing != 0.0 else Reason.COLD
        value = branches.value + friction_n
        std = sqrt(variance + self._scale_variance * branches.value * branches.value)
        return EstimatorStep(
            QuantityEstimate(value, min(std, self._full), reason is Reason.OK, reason),
            GatedState(value, 0, 0, branches, spring_force_n, friction_n),
            (resistance_ohm,),
        )

    def _without_current(self, state: GatedState, sample: WireSample) -> EstimatorStep:
        """Return the last value for a sample without current."""
        state = state._replace(dropouts=state.dropouts + 1)
        failure = dropout_failure(state.dropouts, sample)
        return EstimatorStep(
            QuantityEstimate(state.value, self._full, False, Reason.NO_CURRENT, failure), state, (0.0,)
        )

    def _of_another_wire(self, state: GatedState, sample: WireSample, resistance_ohm: float) -> EstimatorStep:
        """Return the last value for a sample whose resistance this model's wire never has."""
        state = state._replace(dropouts=0, mismatches=state.mismatches + 1)
        failed = state.mismatches >= MAX_DROPOUTS
        failure = mismatch_failure(self.curve, resistance_ohm, sample) if failed else ""
        return EstimatorStep(
            QuantityEstimate(state.value, self._full, False, Reason.MISMATCH, failure), state, (resistance_ohm,)
        )

    def compiled_tick(self) -> CompiledTick | None:
        """Return ``step`` as a compiled function."""
        from musclewire.sensing import _gated_tick as gated_tick

        curve, load = self.curve, self.load
        known = load is None or type(load) is KnownSpring
        if not known or type(curve).estimate is not ResistanceCurve.estimate:  # other parts estimate otherwise
            return None
        low_ohm, high_ohm = self._own_ohm
        numbers = {
            "shunt_resistance_ohm": self._shunt_resistance_ohm,
            "minimum_current_a": MINIMUM_CURRENT_A,
            "own_low_ohm": low_ohm,
            "own_high_ohm": high_ohm,
            "allowed_samples": MAX_DROPOUTS,
            **curve.tick_constants(),
        }
        if load is not None:
            numbers |= {"loaded": 1.0, "stiffness_n_per_m": load.stiffness_n_per_m}
            numbers |= {"load_friction_n": load.friction_n, "turning_m": load.turning_m}
        gates = self._branches.tick_constants(self._step)
        start = self.start()
        shared = {"value": start.value, "friction_n": start.friction_n}
        return CompiledTick(
            gated_tick.tick,
            np.concatenate(
                [
                    filled(gated_tick.SHARED_CONSTANTS, numbers),
                    filled(gated_tick.CONSTANTS, gates),
                    np.array(curve.falling_coefficients).reshape(-1),
                ]
            ),
            np.concatenate([filled(gated_tick.SHARED_STATE, shared), filled(gated_tick.STATE, {})]),
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


def filled(layout: np.dtype[np.void], numbers: Mapping[str, float]) -> FloatArray:
    """Return named numbers as an array in the order of a layout; the others are 0."""
    row = np.zeros(1, layout)
    for name, number in numbers.items():
        row[name] = number
    return row.view(np.float64)


def gated_estimator(setup: EstimatorSetup) -> GatedEstimator:
    """Return the estimator by direction-gated branches for a loop.

    Parameters
    ----------
    setup
        Model, shunt, sample period, and the known spring if force is estimated.

    Returns
    -------
    The estimator.
    """
    return GatedEstimator(setup.model.curve(), setup.shunt_resistance_ohm, setup.sample_period_s, setup.load)
