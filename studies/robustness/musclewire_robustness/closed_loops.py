"""Closed loops of the benchmark: estimator and controller together on the paper's staircase."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from musclewire import (
    ESTIMATORS,
    CallerError,
    EstimatorSetup,
    NumericsError,
    RigError,
    SensingModel,
    control,
    required_true_state,
)
from musclewire.experiment import APPROACH_S, ControlRun, StepMetrics, flagged, noted, staircase_within
from musclewire.rigs import Rig
from musclewire.sensing import EstimatorFactory
from musclewire.wire import WireConstants
from musclewire_robustness.plant import DisturbedPlant, open_plant
from musclewire_robustness.population import PopulationWire
from musclewire_robustness.recording_runs import homed
from musclewire_robustness.scoring import half_width_pct, judged_from_s
from musclewire_robustness.settings import Condition, settings

# Number of the run of a wire, for its noise: after those that are recorded for estimators.
RUN_NUMBER = 50


class ScoredLoop(NamedTuple):
    """What one closed loop came to; errors by Eq. 7 in percent of the target.

    Parameters
    ----------
    mae_first_pct
        Error of the first step, approach included; None for a run that did not come that far.
    mae_other_max_pct
        Largest of the other steps that count: all undisturbed, else those that begin after the change has settled.
    mae_mean_pct
        Mean over the steps that count, the first one included where nothing changes during the run.
    estimate_rms_pct
        Root mean square error of the estimate, in percent of the largest target.
    valid_share
        Fraction of valid samples.
    half_width_pct
        Median half-width of the 95 % interval over the valid samples, in percent of the measured stroke.
    noted_share, flagged_share
        Fractions of the samples at which only causes with which a run holds were named, and any with which it does not.
    ended
        Why the run ended early; "" if it did not.
    power_w, power_limit_w
        Largest electrical power and its limit [W].
    mean_k, hottest_k
        Highest true temperature, mean over the length and of the hottest segment [K].
    """

    mae_first_pct: float | None
    mae_other_max_pct: float | None
    mae_mean_pct: float | None
    estimate_rms_pct: float | None
    valid_share: float | None
    half_width_pct: float | None
    noted_share: float | None
    flagged_share: float | None
    ended: str
    power_w: float
    power_limit_w: float
    mean_k: float
    hottest_k: float


class TrueExtremes:
    """The extremes of a run that no instrument shows: true temperatures, and power at the wire's terminals."""

    def __init__(self, plant: DisturbedPlant) -> None:
        """Watch a simulated rig."""
        self._plant = plant
        self._truth, self._shunt_ohm = required_true_state(plant.rig), plant.rig.shunt_resistance_ohm
        self.power_w = self.mean_k = self.hottest_k = 0.0

    def __call__(self, row: Mapping[str, float]) -> None:
        """Look at the rig after a sample, and let its leads drift before the next."""
        self._plant.before_sample()
        state = self._truth.wire_state
        self.power_w = max(self.power_w, row["wire_voltage_v"] * row["shunt_voltage_v"] / self._shunt_ohm)
        self.mean_k = max(self.mean_k, state.temperature_k)
        self.hottest_k = max(self.hottest_k, float(getattr(state, "hottest_temperature_k", state.temperature_k)))


def run_loop(
    wire: PopulationWire,
    condition: Condition,
    model: SensingModel,
    estimator: str,
    controller: str,
    users_wire: WireConstants | None,
) -> ScoredLoop:
    """Return what a closed loop on the paper's staircase came to, from cold, with the change during the run.

    Parameters
    ----------
    wire
        The wire.
    condition
        What changes.
    model
        The user's model.
    estimator, controller
        Their names.
    users_wire
        Constants of the user's wire file, for an estimator that takes them.

    Returns
    -------
    Its errors and extremes.
    """
    run = settings().run
    plant = open_plant(wire, condition, run=RUN_NUMBER)
    with plant.rig as rig:
        try:
            model, outcome = homed(plant, condition, model)
        except RigError as error:
            return not_begun(" ".join(str(error).split()))
        if outcome.startswith("refused"):
            return not_begun(outcome)
        if condition.zeroed:
            plant.take_zero(run.zeroing_s)
        elif condition.rest_s:
            heat_and_rest(rig, run.start_up_s, condition.rest_s)
        began_s = required_true_state(rig).wire_state.time_s
        plant.disturbance.change_at(began_s + APPROACH_S + run.change_at_s)
        watched = TrueExtremes(plant)
        limit_w = rig.protection_limits.maximum_power_w
        made_by = factory_with(estimator, users_wire)
        found: ControlRun | None = None
        ended = ""
        try:
            reference = staircase_within(model)
            zero_from = "today" if condition.zeroed else "kept"
            found = control(
                rig,
                model,
                reference,
                estimator=made_by,
                controller=controller,
                zero_from=zero_from,
                on_sample=watched,
            )
        except (RigError, NumericsError, CallerError) as error:
            ended = " ".join(str(error).split())
    first, others, mean = (None, None, None) if found is None else step_errors(found, judged_from_s(condition, run))
    metrics = None if found is None else found.metrics
    return ScoredLoop(
        first,
        others,
        mean,
        None if metrics is None else metrics.estimate_rms_pct,
        None if metrics is None else metrics.valid_share,
        None if found is None else half_width_pct(found["estimate_std"], found["valid"] > 0.0, model.stroke),
        None if found is None else float(noted(found).mean()),
        None if found is None else float(flagged(found).mean()),
        ended,
        watched.power_w,
        limit_w,
        watched.mean_k,
        watched.hottest_k,
    )


def heat_and_rest(rig: Rig, heated_s: float, rest_s: float) -> None:
    """Heat a wire by the rig's own amplitude for a time, and let it rest for another [s]."""
    drives_v = {rig.drive_amplitude_v: heated_s, rig.sense_voltage_v: rest_s}
    for drive_v, time_s in drives_v.items():
        for _ in range(round(time_s / rig.sample_period_s)):
            rig.exchange(drive_v)


def factory_with(name: str, wire: WireConstants | None) -> EstimatorFactory:
    """Return the factory of a named estimator that also gets the constants of the user's wire file."""
    factory = ESTIMATORS.find(name)
    if wire is None or "wire" not in {item.name for item in fields(EstimatorSetup)}:
        return factory
    known: dict[str, Any] = {"wire": wire}
    return lambda setup: factory(replace(setup, **known))


def not_begun(why: str) -> ScoredLoop:
    """Return the outcome of a loop that did not begin, because its home move was refused or ended."""
    return ScoredLoop(None, None, None, None, None, None, None, None, why, 0.0, 1.0, 0.0, 0.0)


def step_errors(run: ControlRun, from_s: float) -> tuple[float | None, float | None, float | None]:
    """Return the error of the first step, the largest other and the mean of those that begin from a time on [%]."""
    steps = run.metrics.steps
    hold_s = 6.0
    counted: list[StepMetrics] = [step for number, step in enumerate(steps) if number * hold_s >= from_s - 1e-9]
    errors = [step.mae_pct for step in counted if step.mae_pct is not None]
    first = steps[0].mae_pct if steps and from_s <= 0.0 else None
    others = errors[1:] if first is not None else errors
    return first, max(others, default=None), float(np.mean(errors)) if errors else None
