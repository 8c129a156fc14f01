"""One task on one plant in one condition: the default loop, the paper's fuzzy PID, and a PI on a displacement sensor.

The loops are judged by the reference instrument, which neither they nor what is named of them see: a user has none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view
from pydantic import TypeAdapter

from musclewire import (
    CallerError,
    FloatArray,
    GuardedRig,
    MusclewireError,
    RawSample,
    Recording,
    RigError,
    SensingModel,
    control,
)
from musclewire.controllers import Reference
from musclewire.errors import NumericsError
from musclewire.experiment import APPROACH_S, control_compiled
from musclewire.extras.studies import KindOptions, Outcome, Quantity, RunKind, StudyRuns, each
from musclewire.judge import judgement_of
from musclewire.rigs import SimulatedDevice
from musclewire.signals import COLUMN_SUFFIX, reference_quantity
from musclewire_robustness.recording_runs import StrainServo
from musclewire_robustness.store import FOLDER
from musclewire_robustness.task_plants import PLANTS, changed
from musclewire_robustness.tasks import CHANGES, STILL, TASKS

DEFAULT, FUZZY, SERVO = "default", "fuzzy-pid", "PI on a sensor"
CONTROLLERS = (DEFAULT, FUZZY, SERVO)
# A change begins so long after a task [s]; a task counts from so long after its beginning, or its change, on.
CHANGE_AT_S, COUNTS_FROM_S = 20.0, 2.0
# Of a target that jumps the first second is left out (Eq. 7).
SETTLE_S = 1.0
# A hold counts for swings from 2 s after its target came on, if that leaves a second; a swing is above half a volt
# within four seconds: over minutes the drive follows what the wire warms up around it.
QUIET_S, QUIET_FROM_S, SWING_V, SWINGS_WITHIN_S = 3.0, 2.0, 0.5, 4.0
# What a loop sees of its own error, as it is named: a part of the target, and of what its model senses.
OF_TARGET, OF_RANGE = 0.03, 0.01
DEVIATIONS = 2.0
# Columns of instruments that a user does not have.
OF_INSTRUMENTS = ("displacement_m", "force_n", "endpoint_displacement_m", "endpoint_force_n", "reference_strain")


class ScoredTask(NamedTuple):
    """What a controller came to; errors in percent of the target, None for a run that did not come that far.

    Parameters
    ----------
    mean_pct, largest_pct
        Mean and largest absolute error by the instrument [%].
    estimate_rms_pct
        Error of the estimate, rms, in percent of what the model senses.
    half_width_pct
        Median half-width of the 95 % interval, in percent of the same.
    inside_share
        Fraction of the samples at which the instrument is within it.
    all_pct
        Mean absolute error of all samples, those after a jump, too [%]: what a loop names, it names of these.
    allowed_pct
        Mean of tolerance and half-width [% of the target]: an error of less is none that a loop could name.
    seen_pct
        By how much the estimate is farther from the target than tolerance and half-width in their mean [% of it].
    unannounced_pct
        The same of those samples alone for which the speed limits announced no miss.
    announced_share
        Fraction of the samples for which they did.
    swinging, holds
        Holds in which the drive swings by more than half a volt, and all.
    named
        What was named without an instrument.
    exit
        What the command would have ended with.
    ended
        Why it ended early; "" if it did not.
    """

    mean_pct: float | None
    largest_pct: float | None
    estimate_rms_pct: float | None
    half_width_pct: float | None
    inside_share: float | None
    all_pct: float | None
    allowed_pct: float | None
    seen_pct: float | None
    unannounced_pct: float | None
    announced_share: float | None
    swinging: int
    holds: int
    named: tuple[str, ...]
    exit: int
    ended: str


def not_done(ended: str, code: int) -> ScoredTask:
    """Return the score of a run that did not come to its end."""
    return ScoredTask(None, None, None, None, None, None, None, None, None, None, 0, 0, (), code, ended)


class TaskCase(NamedTuple):
    """A row of the table on one seed, named as 'plant/task/condition/seed'."""

    plant: str
    task: str
    condition: str
    seed: int

    @property
    def row(self) -> str:
        """Its row."""
        return f"{self.plant}/{self.task}/{self.condition}"

    @property
    def name(self) -> str:
        """Its name."""
        return f"{self.row}/{self.seed}"


def case_of(name: str) -> TaskCase:
    """Return a case by its name. Raises CallerError for another one."""
    plant, task, condition, seed = name.split("/")
    if plant not in PLANTS or task not in TASKS or condition not in CHANGES:
        raise CallerError(f"there is no task '{name}': plant/task/condition/seed, as the table prints them")
    return TaskCase(plant, task, condition, int(seed))


def scores_of(case: TaskCase, model: SensingModel) -> dict[str, ScoredTask]:
    """Return what each controller comes to."""
    plant, task, change = PLANTS[case.plant], TASKS[case.task], CHANGES[case.condition]
    found = {}
    for name in CONTROLLERS:
        try:
            reference = task.reference(model, case.seed)
            with plant.opened(case.seed, of_task=True) as rig:
                if name == SERVO:
                    changed(rig, change, CHANGE_AT_S, case.seed)
                    found[name] = servo_score(servo_run(rig, model, reference), case)
                else:
                    found[name] = loop_score(loop_run(rig, model, reference, name, case), model, case)
        except CallerError as error:  # as a target that the model does not sense
            found[name] = not_done(one_line(error), 2)
        except (RigError, NumericsError) as error:
            found[name] = not_done(one_line(error), 3)
    return found


def one_line(error: MusclewireError) -> str:
    """Return an error's message in one line."""
    return " ".join(str(error).split())


def loop_run(rig: GuardedRig, model: SensingModel, reference: Reference, name: str, case: TaskCase) -> Recording:
    """Return the recording of a loop that senses by resistance, compiled where its rig can be."""
    change = CHANGES[case.condition]
    controller, begins_s = (None, 0.0) if name == DEFAULT else (FUZZY, APPROACH_S)
    changed(rig, change, begins_s + CHANGE_AT_S, case.seed)
    one_wire = isinstance(rig.device, SimulatedDevice) and rig.device.partner_state is None
    if one_wire and not change.of_the_supply:
        return control_compiled(rig, model, reference, controller=controller)
    return control(rig, model, reference, controller=controller)


def servo_run(rig: GuardedRig, model: SensingModel, reference: Reference) -> FollowedTargets:
    """Return what a PI on the displacement sensor did. Raises CallerError for a rig without one."""
    servo = StrainServo(rig, model.quantity_max, rig.drive_amplitude_v)
    drive_v, rows = rig.sense_voltage_v, []
    for index in range(round(reference.duration_s / rig.sample_period_s)):
        sample, target = rig.exchange(drive_v), reference.target_at(index * rig.sample_period_s)
        measured = measured_by(sample, rig, model.quantity)
        rows.append((target, measured, drive_v))
        drive_v = servo.drive_v(target, measured)
    target, measured, drives_v = np.array(rows).T
    time_s = np.asarray(rig.sample_period_s * np.arange(1, len(rows) + 1), dtype=np.float64)
    return FollowedTargets(time_s, target, measured, drives_v)


def measured_by(sample: RawSample, rig: GuardedRig, quantity: str) -> float:
    """Return the quantity as the displacement sensor shows it. Raises CallerError without a sensor."""
    if quantity == "displacement" and sample.endpoint_displacement_m is not None:
        return sample.endpoint_displacement_m
    if sample.displacement_m is None:
        raise CallerError(f"this rig has no instrument for {quantity}, which a PI on a sensor needs")
    return sample.displacement_m if quantity == "displacement" else sample.displacement_m / rig.leg_length_m


class FollowedTargets(NamedTuple):
    """Targets, the measured quantity and the drive over the time since the first target counted, (n_times,) each."""

    time_s: FloatArray
    target: FloatArray
    measured: FloatArray
    drive_v: FloatArray

    def since_jump_s(self) -> FloatArray:
        """Return for how long each target has held [s]."""
        jumps = np.concatenate([[True], np.diff(self.target) != 0.0])
        return self.time_s - np.maximum.accumulate(np.where(jumps, self.time_s, -np.inf))

    def asked(self, case: TaskCase) -> npt.NDArray[np.bool_]:
        """Return the samples at which something was asked of a warm wire, in the condition of the case."""
        return np.asarray(self.time_s > COUNTS_FROM_S + (0.0 if case.condition == STILL else CHANGE_AT_S))

    def counts(self, case: TaskCase) -> npt.NDArray[np.bool_]:
        """Return those of them that count: where targets jump, from a second after each on."""
        return self.asked(case) & (self.since_jump_s() > SETTLE_S) if TASKS[case.task].held else self.asked(case)

    def errors_pct(self, rows: npt.NDArray[np.bool_]) -> tuple[float, float]:
        """Return mean and largest absolute error of some samples [% of the target]."""
        error = 100.0 * np.abs(self.measured - self.target)[rows] / np.abs(self.target[rows])
        return float(error.mean()), float(error.max())

    def swings(self, case: TaskCase) -> tuple[int, int]:
        """Return in how many holds the drive swings, and of how many; of a target that never stops none."""
        if not TASKS[case.task].held:
            return 0, 0
        starts = np.flatnonzero(np.concatenate([[True], np.diff(self.target) != 0.0]))
        swung = []
        for rows in np.split(np.arange(self.target.size), starts[1:]):
            held_s = self.time_s[rows] - self.time_s[rows[0]]
            if held_s[-1] >= QUIET_S:
                drive_v = self.drive_v[rows[held_s > QUIET_FROM_S]]
                length = min(round(SWINGS_WITHIN_S / float(held_s[1])), drive_v.size)
                swung.append(float(np.ptp(sliding_window_view(drive_v, length), axis=1).max()) > SWING_V)
        return sum(swung), len(swung)


def servo_score(followed: FollowedTargets, case: TaskCase) -> ScoredTask:
    """Return the score of a PI on the sensor, which estimates nothing."""
    blank = not_done("", 0)
    swinging, holds = followed.swings(case)
    mean_pct, largest_pct = followed.errors_pct(followed.counts(case))
    return blank._replace(mean_pct=mean_pct, largest_pct=largest_pct, swinging=swinging, holds=holds)


def loop_score(run: Recording, model: SensingModel, case: TaskCase) -> ScoredTask:
    """Return the score of a loop that senses by resistance."""
    measured = reference_quantity(run, model.quantity)
    assert measured is not None
    suffix, approach_s = COLUMN_SUFFIX[model.quantity], run.facts.approach_s
    target, estimate = run[f"target_{suffix}"], run[f"estimated_{suffix}"]
    followed = FollowedTargets(run["time_s"] - approach_s, target, measured, run["drive_voltage_v"])
    rows, asked, sensed = followed.counts(case), followed.asked(case), model.quantity_max - model.quantity_min
    tolerance = np.maximum(OF_TARGET * np.abs(target), OF_RANGE * sensed)
    half_width = np.where(run["valid"] > 0.0, DEVIATIONS * run["estimate_std"], 0.0)
    error, away = estimate - measured, np.abs(estimate - target)
    announced = np.abs(run.columns.get("announced_miss", np.zeros(target.size))) > tolerance
    lag = round(SETTLE_S / float(np.median(np.diff(run["time_s"]))))
    announced = np.convolve(announced, np.ones(lag + 1))[: target.size] > 0.0  # a loop may follow a second later
    mean_pct, largest_pct = followed.errors_pct(rows)
    swinging, holds = followed.swings(case)
    allowed_pct, away_pct = (100.0 * one / np.abs(target) for one in (tolerance + half_width, away))
    excess_pct = away_pct - allowed_pct
    unannounced = asked & ~announced
    alone = Recording({name: one for name, one in run.columns.items() if name not in OF_INSTRUMENTS}, run.metadata)
    return ScoredTask(
        mean_pct,
        largest_pct,
        100.0 * float(np.sqrt(np.mean(error[rows] ** 2))) / sensed,
        100.0 * float(np.median(half_width[rows])) / sensed,
        float(np.mean(np.abs(error)[rows] <= half_width[rows])),
        followed.errors_pct(asked)[0],
        float(np.mean(allowed_pct[asked])),
        float(np.mean(excess_pct[asked])),
        float(np.mean(excess_pct[unannounced])) if unannounced.any() else None,
        float(np.mean(announced[asked])),
        swinging,
        holds,
        tuple(one.key for one in judgement_of(alone).findings),
        1 if judgement_of(alone).does_not_hold else 0,
        "",
    )


# The whole answer of a case, as JSON text.
ANSWER = "answer"
SCORES = TypeAdapter(dict[str, ScoredTask])


class TaskOptions(KindOptions):
    """Keys of ``[run]`` with ``kind = "task"``. The rig is that of the plant.

    Parameters
    ----------
    case
        What is run, as "plant/task/condition/seed".
    folder
        Where the models of the plants are kept.
    sources
        What the sources were that computed it: the results of others are not taken for these.
    """

    case: str
    folder: str = str(FOLDER)
    sources: str = ""


def quantities(_options: TaskOptions) -> Mapping[str, Quantity]:
    """Return what a run yields."""
    return {ANSWER: Quantity("", "what each controller came to, as JSON", is_text=True)}


def evaluate(runs: StudyRuns[TaskOptions]) -> Sequence[Outcome]:
    """Return the scores of each run."""
    if runs.rig.keys:
        raise CallerError(f"{', '.join(runs.rig.keys)}: a task has its plant's own rig; let run.case vary")

    def outcome(options: TaskOptions) -> Outcome:
        case = case_of(options.case)
        file = Path(options.folder) / "models" / f"{case.plant}-{case.seed}-{options.sources}.json"
        scores = scores_of(case, PLANTS[case.plant].model_in(file, case.seed))
        return {ANSWER: SCORES.dump_json(scores).decode()}

    return each(outcome, [run.options for run in runs.runs])


TASK_RUNS = RunKind(TaskOptions, quantities, evaluate)
