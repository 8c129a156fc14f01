"""The particle filter as an estimator: strain, displacement or force by the wire file, whatever load and air do."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, argument
from musclewire.extras.calibration._particles._changes import ChangeEvidence, ChangeState, after_evidence, change_of
from musclewire.extras.calibration._particles._cloud import cloud_at_rest, cloud_of, state_of
from musclewire.extras.calibration._particles._explanations import (
    ExplanationEstimate,
    after_sample,
    combined_estimate,
    weights_of,
)
from musclewire.extras.calibration._particles._kernel import (
    SUMMARY,
    HypothesisWire,
    ParticleNumbers,
    ParticleSample,
    follow_sample,
)
from musclewire.extras.calibration._particles._settings import EXPLANATIONS, UNKNOWNS, ParticleSettings
from musclewire.sensing import EstimatorSetup, FilterEstimator, FilterState, HomeMove, filter_estimator
from musclewire.signals import EstimatorStep, QuantityEstimate, Reason, WireSample
from musclewire.wire import WireConstants, resting_state

PARTICLE_COLUMNS = (
    "wire_resistance_ohm",
    "resistance_misfit_ohm",
    "estimated_temperature_k",
    "convection_ratio",
    "ambient_change_k",
    "load_change_n",
    "stiffness_ratio",
    "changed_air",
    "changed_load",
    "health",
)
# A time between two samples further from the period than this factor is a gap or a clock that was set.
ODD_TIME = 5.0
# A reading by which the wire would warm up faster than this is a fault of the reading.
MAX_RATE_K_PER_S = 2000.0
# [N] by which a change of load is divided if the pretension is less.
MIN_PRETENSION_N = 0.05
MIN_RESISTANCE_OHM = 1e-3
# A shift of the transformation temperatures that a home move knows no better than this [K] is left out.
KNOWN_SHIFT_K = 3.0
# Standard deviations: with a larger smoothed misfit no hypothesis explains the resistance, and the value is not valid.
UNEXPLAINED_MISFIT = 3.0


class ParticleState(NamedTuple):
    """The estimator's state: hypotheses and evidence are of each explanation."""

    modelled: FilterState  # of the filter on the model, which says whether a sample is valid
    time_s: float | None
    hypotheses: tuple[bytes, ...]
    evidence: tuple[float, ...]
    change: ChangeState  # for how long something has changed
    value: float


class ParticleFilter:
    """Weighs hypotheses of what has changed since characterization: air, load, stiffness.

    Each hypothesis is a wire of the user's wire file under its own load and air, driven by the measured power; the
    measured resistance weighs them. A filter follows each of three explanations: only the air has changed, only the
    load has, or both. With an unchanged load the filter on the model knows the strain, too, whatever the air does: the
    value is then the mean of both. That filter, ``modelled``, also reads the voltages, bridges dropouts and says which
    samples are valid; ``wire`` is the calibrated wire on its load.
    """

    columns = PARTICLE_COLUMNS
    has_c_form = False

    def __init__(
        self, modelled: FilterEstimator, wire: WireConstants, setup: EstimatorSetup, settings: ParticleSettings
    ) -> None:
        """Take the numbers; the state of a run is not kept here."""
        self.quantity = modelled.quantity
        home = getattr(setup.model, "home", None)
        settings, wire = after_home(settings, wire, home)
        scale, offset_ohm = resistance_after(home)
        self._scale, self._offset_ohm = scale / setup.correction.scale, offset_ohm / setup.correction.scale
        self._modelled, self._wire, self._settings = modelled, wire, settings
        self._shunt_ohm, self._period_s = setup.shunt_resistance_ohm, setup.sample_period_s
        self._range = modelled.curve.quantity_max - modelled.curve.quantity_min
        self._max_power_w = MAX_RATE_K_PER_S * wire.heat_capacity_j_per_k
        derived, cells, load = wire.step_arrays()
        self._arrays = HypothesisWire(derived.copy(), cells, load)
        self._numbers = tuple(numbers_of(settings, name, place) for place, name in enumerate(EXPLANATIONS))
        rest = state_of(cloud_at_rest(resting_state(wire), settings, self._period_s))
        n = len(EXPLANATIONS)
        self._start = ParticleState(
            modelled.start(), None, (rest,) * n, (0.0,) * n, ChangeState(), modelled.curve.quantity_min
        )
        self.step(self._start, WireSample(self._period_s, 0.0, 0.0, 0.0))  # compiles it, as of every estimator

    def start(self) -> ParticleState:
        """Return the state before the first sample: the wire at rest, and nothing has changed."""
        return self._start

    def going_on(self, before: ParticleState) -> ParticleState:
        """Return the state by which it goes on for a corrected model: what its hypotheses were through stays."""
        return before._replace(modelled=self._modelled.start())

    def step(self, state: ParticleState, sample: WireSample) -> EstimatorStep:
        """Return the estimate of one sample."""
        seen, modelled, (resistance_ohm, *_) = self._modelled.step(state.modelled, sample)
        readable = seen.reason not in (Reason.NO_CURRENT, Reason.MISMATCH)
        measured = self._measured(state, sample, resistance_ohm if readable else None)
        hypotheses, answers = self._followed(state, measured)
        evidence = state.evidence
        if readable:
            gained = [answer[SUMMARY.evidence] for answer in answers]
            evidence = after_sample(evidence, gained, measured.duration_s, self._settings)
        opinions = self._opinions(answers, seen if seen.reason is Reason.OK else None)
        value, std = combined_estimate(opinions, evidence, self._settings) if readable else (state.value, self._range)
        weight = weights_of(evidence, self._settings.load_cost, 1.0)
        shown = weight @ np.array(answers)
        reason = seen.reason if seen.reason is not Reason.OK else self._doubts(shown[SUMMARY.misfit], std)
        recorded = self._recorded(measured.resistance_ohm, shown)
        change = after_evidence(state.change, self._evidence(recorded, reason), measured.duration_s)
        return EstimatorStep(
            QuantityEstimate(value, std, reason is Reason.OK, reason, seen.failure),
            ParticleState(modelled, sample.time_s, hypotheses, evidence, change, value),
            (*recorded, float(change_of(change))),
        )

    def _followed(self, state: ParticleState, measured: ParticleSample) -> tuple[tuple[bytes, ...], list[FloatArray]]:
        """Return the hypotheses of each explanation after a sample, and what each says."""
        after, answers = [], []
        for before, numbers in zip(state.hypotheses, self._numbers, strict=True):
            cloud = cloud_of(before, self._wire.classes, self._settings)
            answer = np.zeros(SUMMARY.size)
            follow_sample(cloud, self._arrays, numbers, measured, answer)
            after.append(state_of(cloud))
            answers.append(answer)
        return tuple(after), answers

    def _opinions(self, answers: list[FloatArray], seen: QuantityEstimate | None) -> list[ExplanationEstimate]:
        """Return what each explanation says, where valid with that of the filter on the model, ``seen``.

        Little distinguishes a change of load from one of load and air: both filters then have half a vote.
        """
        air, load, both = (self._opinion(answer) for answer in answers)
        if seen is not None:
            apart = 0.5 * (air.value - seen.value)
            air = ExplanationEstimate(air.value - apart, math.hypot(air.std, apart))
        halfway = 0.5 * (load.value + both.value)
        return [air, ExplanationEstimate(halfway, load.std), both]

    def _opinion(self, answer: FloatArray) -> ExplanationEstimate:
        """Return value and standard deviation by one explanation, in the model's quantity."""
        own_std = math.hypot(self._settings.structural_strain * self._range, self._modelled.curve.offset_std)
        factor, value, std = 1.0, answer[SUMMARY.contraction], answer[SUMMARY.contraction_std]
        if self.quantity == "force":
            value, std = answer[SUMMARY.force_n], answer[SUMMARY.force_std_n]
        elif self.quantity == "displacement":
            factor = self._wire.leg_length_m
        # A filter whose explanation is wrong goes astray; beyond these bounds it says nothing more.
        low, high = self._modelled.curve.quantity_min - self._range, self._modelled.curve.quantity_max + self._range
        std = min(math.hypot(factor * std, own_std), self._range)
        return ExplanationEstimate(min(max(factor * float(value), low), high), std)

    def _doubts(self, misfit: float, std: float) -> Reason:
        """Return why a sample that the model can sense is not valid after all, or OK."""
        if abs(misfit) > UNEXPLAINED_MISFIT:
            return Reason.UNEXPLAINED
        return Reason.UNCERTAIN if std > self._settings.largest_std * self._range else Reason.OK

    def _measured(self, state: ParticleState, sample: WireSample, resistance_ohm: float | None) -> ParticleSample:
        """Return a sample as the hypotheses take it; without a resistance the power follows from the drive."""
        duration_s = self._period_s
        if state.time_s is not None and duration_s / ODD_TIME < sample.time_s - state.time_s < duration_s * ODD_TIME:
            duration_s = sample.time_s - state.time_s
        if resistance_ohm is not None:
            power_w = sample.wire_voltage_v * sample.shunt_voltage_v / self._shunt_ohm
            # The calibrated wire has the resistance of its characterization; a home move says what became of it.
            calibrated_ohm = max((resistance_ohm - self._offset_ohm) / self._scale, MIN_RESISTANCE_OHM)
            return ParticleSample(
                min(power_w, self._max_power_w), calibrated_ohm, abs(sample.shunt_voltage_v), duration_s
            )
        usual_ohm = self._modelled.curve.resistance_max_ohm
        current_a = sample.drive_voltage_v / (usual_ohm + self._shunt_ohm)
        return ParticleSample(min(current_a * current_a * usual_ohm, self._max_power_w), 0.0, 0.0, duration_s)

    def _evidence(self, recorded: tuple[float, ...], reason: Reason) -> ChangeEvidence:
        """Return what has been found of changes in a sample."""
        found = dict(zip(PARTICLE_COLUMNS, recorded, strict=False))
        return ChangeEvidence(
            found["changed_air"],
            found["changed_load"],
            found["convection_ratio"],
            found["ambient_change_k"],
            found["load_change_n"] / max(self._wire.pretension_n, MIN_PRETENSION_N),
            found["stiffness_ratio"],
            reason,
        )

    def _recorded(self, resistance_ohm: float, shown: FloatArray) -> tuple[float, ...]:
        """Return the numbers to record, but for the health."""
        unknown = dict(zip(UNKNOWNS, shown[SUMMARY.first_unknown : SUMMARY.first_change].tolist(), strict=True))
        changed = dict(zip(UNKNOWNS, shown[SUMMARY.first_change : SUMMARY.evidence].tolist(), strict=True))
        return (
            resistance_ohm,
            float(shown[SUMMARY.misfit_ohm]),
            float(shown[SUMMARY.temperature_k]),
            math.exp(unknown["convection"]),
            unknown["ambient"],
            unknown["load"] * self._wire.pretension_n,
            math.exp(unknown["stiffness"]),
            max(changed["convection"], changed["ambient"]),
            max(changed["load"], changed["stiffness"]),
        )


def resistance_after(home: HomeMove | None) -> tuple[float, float]:
    """Return scale and offset [ohm] of the resistance since the characterization, as the last home move found them."""
    if home is None or not home.corrected:
        return 1.0, 0.0
    return home.resistance_scale, home.resistance_offset_ohm


def after_home(
    settings: ParticleSettings, wire: WireConstants, home: HomeMove | None
) -> tuple[ParticleSettings, WireConstants]:
    """Return the wire with what a home move found of its temperatures, and settings that leave open what it did not."""
    if home is None:
        return settings, wire
    at_rest = dict(zip(UNKNOWNS, settings.spread_at_rest, strict=True))
    if home.transformation_shift_std_k < KNOWN_SHIFT_K:
        shift_k = home.transformation_shift_k
        wire = wire.replace(
            martensite_temperature_k=wire.martensite_temperature_k + shift_k,
            r_phase_temperature_k=wire.r_phase_temperature_k + shift_k,
        )
        at_rest["transformation"] = home.transformation_shift_std_k
    return replace(settings, spread_at_rest=tuple(at_rest.values())), wire


def numbers_of(settings: ParticleSettings, explanation: str, place: int) -> ParticleNumbers:
    """Return the numbers of an explanation's filter; each has random numbers of its own."""
    return ParticleNumbers(
        settings.tables(explanation),
        settings.resistance_error,
        settings.error_time_s,
        settings.renewed,
        settings.renewed_when_lost,
        settings.lost_misfit,
        settings.wandering,
        settings.restarts,
        settings.seed * len(EXPLANATIONS) + place,
    )


def particle_filter(setup: EstimatorSetup, settings: ParticleSettings | None = None) -> ParticleFilter:
    """Return a particle filter for a loop.

    Raises CallerError without a wire file, for a model of an endpoint's displacement, which a wire file does not
    describe, and for one without a slow loop.
    """
    if setup.wire is None:
        raise CallerError(
            "estimator 'particle-filter' needs a wire file: musclewire calibrate makes one of a recording, and "
            + argument("wire_file")
            + " names it; without one choose "
            + argument("estimator", "filter")
        )
    if setup.model.wire.get("finger") and setup.model.quantity == "displacement":
        raise CallerError(
            "estimator 'particle-filter': this model is of a finger's endpoint, which a wire file does not "
            "describe: fit a model of strain, or choose " + argument("estimator", "filter")
        )
    return ParticleFilter(filter_estimator(setup), setup.wire, setup, settings or ParticleSettings())
