"""The kind of run ``robustness``: a wire of the population under a condition, and every estimator."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydantic import TypeAdapter

from musclewire import ESTIMATORS, CallerError, MusclewireError
from musclewire.extras.studies import KindOptions, Outcome, Quantity, RunKind, StudyRuns, each
from musclewire.sensing import KnownSpring, force_model
from musclewire.wire import WireConstants
from musclewire_robustness.characterizing import UsersKnowledge
from musclewire_robustness.estimating import estimated
from musclewire_robustness.population import drawn_wire
from musclewire_robustness.recorded_run import RecordedRun
from musclewire_robustness.references import REFERENCES
from musclewire_robustness.scoring import ErrorSums, judged_from_s, pooled, score_of, usable
from musclewire_robustness.settings import Condition, RunSettings, settings
from musclewire_robustness.store import FOLDER, ResultStore, known_wire

# Cold samples whose mean is the load cell's zero.
ZERO_SAMPLES = 4


def force_score(
    run: RecordedRun,
    estimator: str,
    condition: Condition,
    knowledge: UsersKnowledge,
    times: RunSettings,
    wire: WireConstants | None,
) -> ErrorSums:
    """Return the score of an estimator's force against the load cell, in forces of the spring at the full stroke.

    Parameters
    ----------
    run
        The run.
    estimator
        Name of the estimator.
    condition
        Its condition; where it changes the load, the user does not know: the force that he assumes is the old one's.
    knowledge
        What the wire's user knows, the stiffness that his rig states included.
    times
        Times of a run.
    wire
        Constants of the user's wire file.

    Returns
    -------
    Sums; without samples if the estimator has no force.
    """
    stiffness = float(knowledge.loop.metadata["spring_stiffness_n_per_m"] or 0.0)
    leg_m = run.facts["leg_length_m"]
    full_n = stiffness * leg_m * knowledge.stroke
    friction_n = float(knowledge.model.wire.get("guide_friction_n", 0.0))
    try:
        model = force_model(knowledge.model, stiffness, leg_m)
        found = estimated(run, model, estimator, wire, KnownSpring(stiffness, friction_n), zeroed=condition.zeroed)
    except MusclewireError:
        return ErrorSums()
    judged = usable(run.strain, knowledge, times) & (run.time_s >= judged_from_s(condition, times))
    measured = run.force_n - run.force_n[:ZERO_SAMPLES].mean()
    error = (found.value - measured)[judged] / full_n
    valid = found.valid[judged]
    return ErrorSums(
        samples=int(judged.sum()),
        squares=float(error @ error),
        valid=int(valid.sum()),
        wrong=int(np.sum(valid & (np.abs(error) > 0.05))),
    )


# The whole answer of a run, as JSON text.
ANSWER = "answer"


class RobustnessOptions(KindOptions):
    """Keys of ``[run]`` with ``kind = "robustness"``. The rig is that of the wire, which the population draws.

    Parameters
    ----------
    wire
        Seed of the wire.
    condition
        Name of the condition.
    references
        Names of the references that are recorded.
    estimators
        Names of the estimators that are run over the records.
    folder
        Where the wires' own recordings are kept.
    sources
        What the sources were that computed it: the results of others are not taken for these.
    """

    wire: int
    condition: str
    references: tuple[str, ...] = tuple(REFERENCES)
    estimators: tuple[str, ...] = ()
    folder: str = str(FOLDER)
    sources: str = ""

    @property
    def all_estimators(self) -> tuple[str, ...]:
        """The estimators; all that there are if none is given."""
        return self.estimators or tuple(ESTIMATORS.names())


class JobAnswer(NamedTuple):
    """What a run found.

    Parameters
    ----------
    job
        What was run.
    gap_pct
        Gap of the user's slow loop [%].
    segments
        Number of segments of the wire.
    scores
        Score of each estimator by its name, over all references.
    problems
        Why an estimator could not be run, by its name.
    ended
        Why recorded runs ended early, by the reference.
    force
        Score of the force at the known load over the first reference, by the estimator's name; the spring's force at
        the full stroke is 100 %.
    home_moves
        What became of each home move, by the reference.
    """

    job: RobustnessOptions
    gap_pct: float
    segments: int
    scores: dict[str, ErrorSums]
    problems: dict[str, str]
    ended: dict[str, str]
    force: dict[str, ErrorSums]
    home_moves: dict[str, str]

    def text(self) -> str:
        """Return it as JSON, which ``answer_of_text`` reads."""
        return TypeAdapter(JobAnswer).dump_json(self).decode()


def answer_of_text(text: str) -> JobAnswer:
    """Return the answer in JSON."""
    return TypeAdapter(JobAnswer).validate_json(text)


def quantities(options: RobustnessOptions) -> Mapping[str, Quantity]:
    """Return what a run yields."""
    return {
        **{f"rms_pct[{name}]": Quantity("1", f"error of {name}, in % of the full stroke")
           for name in options.all_estimators},
        ANSWER: Quantity("", "all that the run found, as JSON", is_text=True),
    }  # fmt: skip


def evaluate(runs: StudyRuns[RobustnessOptions]) -> Sequence[Outcome]:
    """Return the numbers and the answer of each run; the wires of one chunk are characterized once."""
    if runs.rig.keys:
        raise CallerError(
            f"{', '.join(runs.rig.keys)}: a wire of the population has its own rig; let run.wire and run.condition vary"
        )
    stores: dict[str, ResultStore] = {}

    def outcome(options: RobustnessOptions) -> Outcome:
        store = stores.setdefault(options.folder, ResultStore(Path(options.folder)))
        answer = answer_of(options, store)
        numbers = {f"rms_pct[{name}]": score.rms_pct for name, score in answer.scores.items()}
        known = {name: value for name, value in numbers.items() if value is not None}
        return {**dict.fromkeys(quantities(options), float("nan")), **known, ANSWER: answer.text()}

    return each(outcome, [run.options for run in runs.runs])


def answer_of(job: RobustnessOptions, store: ResultStore) -> JobAnswer:
    """Return what a run finds.

    Parameters
    ----------
    job
        What is run.
    store
        Where the wires' own recordings are kept.

    Returns
    -------
    The answer.
    """
    (condition,) = settings().conditions((job.condition,))
    wire, times = drawn_wire(job.wire), settings().run
    knowledge = store.knowledge(wire)
    own = known_wire(knowledge)
    recorded = [store.run(wire, condition, reference) for reference in job.references]
    runs = [(run, knowledge._replace(model=model)) for run, model in recorded if run.counts]
    scores: dict[str, ErrorSums] = {}
    problems: dict[str, str] = {}
    force: dict[str, ErrorSums] = {}
    for name in job.all_estimators:
        try:
            found = [estimated(run, users.model, name, own, zeroed=condition.zeroed) for run, users in runs]
        except MusclewireError as error:
            problems[name] = " ".join(str(error).split())
            continue
        scores[name] = pooled(
            score_of(run, answers, condition, users, times) for (run, users), answers in zip(runs, found, strict=True)
        )
        if not condition.changes_load:  # otherwise the load is not known
            force[name] = pooled(force_score(run, name, condition, users, times, own) for run, users in runs[:1])
    ended = {run.reference: run.ended for run, _ in recorded if run.ended}
    moves = {run.reference: run.home for run, _ in recorded if run.home}
    return JobAnswer(job, knowledge.gap_pct, wire.segments, scores, problems, ended, force, moves)


ROBUSTNESS = RunKind(RobustnessOptions, quantities, evaluate)
