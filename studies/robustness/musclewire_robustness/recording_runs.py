"""Recorded runs for the table of estimators: after a home move the wire follows a reference by its displacement sensor.

A PI controller on the measured strain drives it, so that the trajectory is the same whatever an estimator says. Each
run is recorded once, and every estimator is run over its samples.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire import (
    CallerError,
    FloatArray,
    NumericsError,
    RawSample,
    RigError,
    SensingModel,
    home,
    required_true_state,
)
from musclewire.errors import FitRejectedError
from musclewire.rigs import Rig
from musclewire_robustness.characterizing import UsersKnowledge
from musclewire_robustness.plant import AS_CHARACTERIZED, DisturbedPlant, open_plant
from musclewire_robustness.population import PopulationWire
from musclewire_robustness.recorded_run import RecordedRun
from musclewire_robustness.references import REFERENCES, reference_targets, start_up
from musclewire_robustness.settings import Condition, RunSettings, settings

# Error of a thermometer in the air [K].
THERMOMETER_STD_K = 0.3
STREAM = 17


class HomedModel(NamedTuple):
    """The model after a home move.

    Parameters
    ----------
    model
        The model of today; the old one without a home move and after one that was refused.
    outcome
        "corrected", "not corrected", or "refused: " with the cause; "" without a home move.
    """

    model: SensingModel
    outcome: str


def homed(plant: DisturbedPlant, condition: Condition, model: SensingModel) -> HomedModel:
    """Return the model after the home move that a condition has, made on the rig as it is now.

    Parameters
    ----------
    plant
        The rig, open and cold; it is driven if the condition has a home move.
    condition
        The condition.
    model
        The user's model.

    Returns
    -------
    The model, and what became of the move.

    Raises
    ------
    RigError
        If the protection ended the move.
    """
    if not condition.home:
        return HomedModel(model, "")
    ambient_k = None
    if condition.thermometer:
        noise_k = THERMOMETER_STD_K * float(np.random.default_rng([STREAM, plant.seed]).standard_normal())
        ambient_k = plant.disturbance.ambient_k(0.0) + noise_k
    try:
        # The user has not touched the load, and says so.
        load_n = float(model.wire["pretension_n"])
        found = home(plant.rig, model, load_n=load_n, ambient_k=ambient_k)
    except (CallerError, FitRejectedError) as error:
        return HomedModel(model, f"refused: {' '.join(str(error).split())}")
    return HomedModel(found.model, "corrected" if found.home.corrected else "not corrected")


# Power, as a fraction of that at the amplitude, per error in strokes, and the time of the integral.
GAIN, INTEGRAL_S = 6.0, 1.2
# Cold samples from which a new zero of the displacement sensor is read.
ZERO_SAMPLES = 20


class StrainServo:
    """PI controller of the heating power on the measured strain."""

    def __init__(self, rig: Rig, stroke: float, amplitude_v: float) -> None:
        """Take the rig's limits, and what the user knows of stroke and amplitude."""
        self._low, self._full, self._high = (
            volts**2 for volts in (rig.sense_voltage_v, amplitude_v, rig.maximum_voltage_v)
        )
        self._stroke, self._period_s = stroke, rig.sample_period_s
        self._integral = 0.0

    def drive_v(self, target: float, strain: float) -> float:
        """Return the next drive voltage [V]."""
        error = (target - strain) / self._stroke
        wanted = self._full * GAIN * (error + self._integral)
        inside = min(max(wanted, self._low), self._high)
        if wanted == inside or (wanted > inside) != (error > 0.0):
            self._integral += error * self._period_s / INTEGRAL_S
        return float(np.sqrt(inside))


def record_run(
    wire: PopulationWire, condition: Condition, reference: str, knowledge: UsersKnowledge
) -> tuple[RecordedRun, SensingModel]:
    """Return the run of a wire along a reference under a condition, and the user's model after any home move."""
    plant = open_plant(wire, condition, run=10 + list(REFERENCES).index(reference))
    with plant.rig:
        try:
            model, outcome = homed(plant, condition, knowledge.model)
        except RigError as error:
            raise NumericsError(f"wire {wire.name}, {condition.name}: the home move was ended: {error}") from None
        if condition.zeroed:
            plant.take_zero(settings().run.zeroing_s)
        run = followed(plant, wire, condition, reference, knowledge)
    return replace(run, home=outcome), model


class RunRows:
    """What is recorded of a run, a row for each sample."""

    def __init__(self, plant: DisturbedPlant) -> None:
        """Begin without a row."""
        self._plant, self._truth = plant, required_true_state(plant.rig)
        self._rows: list[tuple[float, ...]] = []

    def append(self, sample: RawSample) -> float:
        """Keep a sample; return the strain that the displacement sensor shows. The devices in segments have one."""
        strain = (sample.displacement_m or 0.0) / self._plant.rig.leg_length_m
        truth, level = self._truth.wire_state, self._plant.disturbance.level(sample.time_s)
        self._rows.append((*sample[:4], strain, sample.force_n or 0.0, truth.temperature_k, level))
        return strain

    def columns(self) -> FloatArray:
        """Return time, drive, two voltages, strain, force, true temperature and level of the change, (8, n_samples)."""
        return np.array(self._rows, dtype=np.float64).reshape(-1, 8).T


def followed(
    plant: DisturbedPlant, wire: PopulationWire, condition: Condition, reference: str, knowledge: UsersKnowledge
) -> RecordedRun:
    """Return what was recorded while a wire followed the start-up loop and a reference."""
    rig, run = plant.rig, settings().run
    targets = run_targets(wire, condition, reference, knowledge.stroke, run, rig.sample_period_s)
    servo, rows = StrainServo(rig, knowledge.stroke, knowledge.amplitude_v), RunRows(plant)
    began_s = required_true_state(rig).wire_state.time_s + run.start_up_s
    plant.disturbance.change_at(began_s + run.change_at_s)
    drive_v, ended = rig.sense_voltage_v, ""
    for target in targets.tolist():
        plant.before_sample()
        try:
            sample = rig.exchange(drive_v)
        except RigError as error:
            ended = " ".join(str(error).split())
            break
        drive_v = servo.drive_v(target, rows.append(sample))
    clock_s, drive, wire_v, shunt_v, strain, force_n, temperature_k, level = rows.columns()
    return RecordedRun(
        seed=wire.seed,
        condition=condition.name,
        reference=reference,
        time_s=clock_s - began_s,
        clock_s=clock_s,
        drive_voltage_v=drive,
        wire_voltage_v=wire_v,
        shunt_voltage_v=shunt_v,
        strain=strain,
        zero_shift=level * zero_shift(wire, condition, rig.leg_length_m),
        force_n=force_n,
        temperature_k=temperature_k,
        target=targets[: strain.size],
        change_level=level,
        ended=ended,
        facts=facts_of(rig),
    )


def facts_of(rig: Rig) -> dict[str, float]:
    """Return the numbers of a rig that an estimator and a judge need."""
    return {
        "shunt_resistance_ohm": rig.shunt_resistance_ohm,
        "sample_period_s": rig.sample_period_s,
        "sense_voltage_v": rig.sense_voltage_v,
        "leg_length_m": rig.leg_length_m,
        "maximum_voltage_v": rig.maximum_voltage_v,
    }


def run_targets(
    wire: PopulationWire, condition: Condition, reference: str, stroke: float, run: RunSettings, period_s: float
) -> FloatArray:
    """Return the targets of all samples of a run: the start-up loop, then the reference, a rest in it at no strain."""
    before = round(run.start_up_s / period_s)
    after = np.asarray(np.arange(round(run.reference_s / period_s)) * period_s, dtype=np.float64)
    follows = reference_targets(reference, after, stroke, wire.seed)
    follows[rests_at(after, condition, run)] = 0.0
    first = start_up(
        np.asarray(np.arange(before) * period_s, dtype=np.float64), stroke, float(follows[0]), run.start_up_s
    )
    return np.concatenate([first, follows])


def rests_at(time_s: FloatArray, condition: Condition, run: RunSettings) -> npt.NDArray[np.bool_]:
    """Return at which times from the reference's start on the wire rests without heat, (n_samples,)."""
    return np.asarray((time_s >= run.change_at_s) & (time_s < run.change_at_s + condition.rest_s))


def zero_shift(wire: PopulationWire, condition: Condition, leg_length_m: float) -> float:
    """Return the strain that the cold wire shows once a changed load is on: what taking zero again takes away."""
    if condition.zeroed or not condition.moves_zero:
        return 0.0
    only = AS_CHARACTERIZED.model_copy(
        update={"load_fraction": condition.load_fraction, "pretension_fraction": condition.pretension_fraction}
    )
    plant = open_plant(wire, only, run=9)
    plant.disturbance.change_at(0.0)
    with plant.rig as rig:
        settle = round(2.0 * settings().run.ramp_s / rig.sample_period_s)
        samples = [rig.exchange(rig.sense_voltage_v) for _ in range(settle + ZERO_SAMPLES)]
    cold = [sample.displacement_m or 0.0 for sample in samples[settle:]]
    return float(np.mean(cold)) / leg_length_m
