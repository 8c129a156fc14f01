"""The particle filter as an estimator: strain, displacement or force by the wire file, whatever load and air do."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.sensing.estimator import EstimatorSetup
from musclewire.sensing.particles.cloud import cloud_at_rest, cloud_of, state_of
from musclewire.sensing.particles.kernel import SUMMARY, Measured, Numbers, Wire, follow_sample
from musclewire.sensing.particles.settings import UNKNOWNS, ParticleSettings
from musclewire.sensing.polynomial_estimator import PolynomialEstimator, PolynomialState, polynomial_estimator
from musclewire.signals.exchange import EstimatorStep, QuantityEstimate, Reason, WireSample
from musclewire.wire.building import resting_state
from musclewire.wire.constants import WireConstants

__all__ = ["PARTICLE_COLUMNS", "ParticleFilter", "ParticleState", "particle_filter"]

PARTICLE_COLUMNS = (
    "wire_resistance_ohm",
    "estimate_std",
    "resistance_misfit_ohm",
    "estimated_temperature_k",
    "convection_ratio",
    "ambient_change_k",
    "load_change_n",
    "stiffness_ratio",
    "changed_air",
    "changed_load",
)
# A time between two samples further from the period than this factor is a gap or a clock that was set.
ODD_TIME = 5.0
# A reading by which the wire would warm up faster than this is a fault of the reading.
MAX_RATE_K_PER_S = 2000.0
# A smoothed misfit of so many deviations, and the value is not valid: no hypothesis explains the resistance.
UNEXPLAINED_MISFIT = 3.0


class ParticleState(NamedTuple):
    """The estimator's state: that of the curve, which says whether a sample is valid, the last time, the hypotheses."""

    curve: PolynomialState
    time_s: float | None
    hypotheses: bytes


class ParticleFilter:
    """Weighs hypotheses of what has changed since characterisation: air, load, stiffness.

    Each hypothesis is a wire of the user's wire file under its own load and air, driven by the measured power; the
    measured resistance weighs them, and the value is their weighted mean. The fitted curve says which samples are
    valid.

    Parameters
    ----------
    curve
        The estimator by the fitted curve: it reads the voltages, bridges dropouts and knows the valid range.
    wire
        The calibrated wire on its load.
    setup
        Shunt, period and model.
    settings
        What is taken for possible.

    Raises
    ------
    CallerError
        For a model of an endpoint's displacement, which a wire file does not describe.
    """

    columns = PARTICLE_COLUMNS
    has_c_form = False
    slow_part = None

    def __init__(
        self, curve: PolynomialEstimator, wire: WireConstants, setup: EstimatorSetup, settings: ParticleSettings
    ) -> None:
        """Take the numbers; the state of a run is not kept here."""
        self.quantity = curve.quantity
        self._curve, self._wire, self._settings = curve, wire, settings
        if setup.model.wire.get("finger") and curve.quantity == "displacement":
            raise CallerError(
                "estimator 'particle-filter': this model is of a finger's endpoint, which a wire file does not "
                "describe: fit a model of strain, or choose --estimator gated"
            )
        self._shunt_ohm, self._period_s = setup.shunt_resistance_ohm, setup.sample_period_s
        self._own_std = settings.structural_strain * (curve.curve.quantity_max - curve.curve.quantity_min)
        self._max_power_w = MAX_RATE_K_PER_S * wire.heat_capacity_j_per_k
        derived, cells, load = wire.step_arrays()
        self._arrays = Wire(derived.copy(), cells, load)
        self._numbers = Numbers(
            settings.tables(),
            settings.resistance_error,
            settings.error_time_s,
            settings.renewed,
            settings.renewed_when_lost,
            settings.lost_misfit,
            settings.wandering,
            settings.restarts,
            settings.seed,
        )
        self._start = ParticleState(
            curve.start(), None, state_of(cloud_at_rest(resting_state(wire), settings, self._period_s))
        )

    def start(self) -> ParticleState:
        """Return the state before the first sample: the wire at rest, and nothing has changed."""
        return self._start

    def step(self, state: ParticleState, sample: WireSample) -> EstimatorStep:
        """Return the estimate of one sample."""
        seen, curve_state, _ = self._curve.step(state.curve, sample)
        readable = seen.reason not in (Reason.NO_CURRENT, Reason.MISMATCH)
        measured = self._measured(state, sample, readable)
        cloud = cloud_of(state.hypotheses, self._wire.classes, self._settings)
        answer = np.zeros(SUMMARY.size)
        follow_sample(cloud, self._arrays, self._numbers, measured, answer)
        value, std = self._value(answer)
        curve_state = curve_state._replace(value=value)
        if not readable:
            value, std = state.curve.value, self._curve.curve.quantity_max - self._curve.curve.quantity_min
            curve_state = curve_state._replace(value=value)
        reason = seen.reason
        if reason is Reason.OK and abs(answer[SUMMARY.misfit]) > UNEXPLAINED_MISFIT:
            reason = Reason.UNEXPLAINED
        return EstimatorStep(
            QuantityEstimate(value, std, reason is Reason.OK, reason, seen.failure),
            ParticleState(curve_state, sample.time_s, state_of(cloud)),
            self._recorded(measured.resistance_ohm, std, answer),
        )

    def _measured(self, state: ParticleState, sample: WireSample, readable: bool) -> Measured:
        """Return a sample as the hypotheses take it; without a reading the power follows from drive and last state."""
        duration_s = self._period_s
        if state.time_s is not None and duration_s / ODD_TIME < sample.time_s - state.time_s < duration_s * ODD_TIME:
            duration_s = sample.time_s - state.time_s
        if readable:
            resistance_ohm, _ = self._curve.read(sample.wire_voltage_v, sample.shunt_voltage_v)
            power_w = sample.wire_voltage_v * sample.shunt_voltage_v / self._shunt_ohm
            return Measured(min(power_w, self._max_power_w), resistance_ohm, abs(sample.shunt_voltage_v), duration_s)
        usual_ohm = self._curve.curve.resistance_max_ohm
        current_a = sample.drive_voltage_v / (usual_ohm + self._shunt_ohm)
        return Measured(min(current_a * current_a * usual_ohm, self._max_power_w), 0.0, 0.0, duration_s)

    def _value(self, answer: FloatArray) -> tuple[float, float]:
        """Return value and standard deviation in the model's quantity."""
        if self.quantity == "force":
            own_n = self._own_std
            return float(answer[SUMMARY.force_n]), math.hypot(answer[SUMMARY.force_std_n], own_n)
        per_contraction = 1.0 if self.quantity == "strain" else self._wire.leg_length_m
        value, std = answer[SUMMARY.contraction], answer[SUMMARY.contraction_std]
        return float(per_contraction * value), math.hypot(per_contraction * std, self._own_std)

    def _recorded(self, resistance_ohm: float, std: float, answer: FloatArray) -> tuple[float, ...]:
        """Return the numbers to record."""
        unknown = dict(zip(UNKNOWNS, answer[SUMMARY.first_unknown : SUMMARY.first_change].tolist(), strict=True))
        changed = dict(zip(UNKNOWNS, answer[SUMMARY.first_change :].tolist(), strict=True))
        return (
            resistance_ohm,
            std,
            float(answer[SUMMARY.misfit_ohm]),
            float(answer[SUMMARY.temperature_k]),
            math.exp(unknown["convection"]),
            unknown["ambient"],
            unknown["load"] * self._wire.pretension_n,
            math.exp(unknown["stiffness"]),
            max(changed["convection"], changed["ambient"]),
            max(changed["load"], changed["stiffness"]),
        )


def particle_filter(setup: EstimatorSetup, settings: ParticleSettings | None = None) -> ParticleFilter:
    """Return a particle filter for a loop.

    Parameters
    ----------
    setup
        Model, shunt, period, and the constants of the user's wire file on the rig's load.
    settings
        What is taken for possible; the defaults if None.

    Returns
    -------
    The estimator.

    Raises
    ------
    CallerError
        Without a wire file, or for a model of an endpoint's displacement.
    """
    if setup.wire is None:
        raise CallerError(
            "estimator 'particle-filter' needs a wire file: musclewire calibrate makes one of a recording, and "
            "--wire-file names it; without one choose --estimator gated"
        )
    return ParticleFilter(polynomial_estimator(setup), setup.wire, setup, settings or ParticleSettings())
