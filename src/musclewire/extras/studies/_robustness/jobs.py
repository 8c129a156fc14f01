"""One wire under one condition: its runs, every estimator over them, its closed loops. What a worker does at a time."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, NamedTuple

from musclewire.errors import MusclewireError
from musclewire.extras.studies._robustness.closed_loops import ScoredLoop, run_loop
from musclewire.extras.studies._robustness.estimating import estimated
from musclewire.extras.studies._robustness.forces import force_score
from musclewire.extras.studies._robustness.population import drawn_wire
from musclewire.extras.studies._robustness.scoring import ErrorSums, pooled, score_of
from musclewire.extras.studies._robustness.settings import settings
from musclewire.extras.studies._robustness.store import ResultStore, digest, known_wire, sources

__all__ = ["JobAnswer", "RobustnessJob", "answer_of", "job_of_plain"]


class RobustnessJob(NamedTuple):
    """A wire under a condition.

    Parameters
    ----------
    seed
        Seed of the wire.
    condition
        Name of the condition.
    references
        Names of the references that are recorded.
    estimators
        Names of the estimators that are run over the records.
    loops
        Estimator and controller of each closed loop.
    """

    seed: int
    condition: str
    references: tuple[str, ...]
    estimators: tuple[str, ...]
    loops: tuple[tuple[str, str], ...]


def job_of_plain(data: Any) -> RobustnessJob:
    """Return the job in a list of plain data."""
    seed, condition, references, estimators, loops = data
    return RobustnessJob(seed, condition, tuple(references), tuple(estimators), tuple((one, two) for one, two in loops))


class JobAnswer(NamedTuple):
    """What a job found.

    Parameters
    ----------
    job
        The job.
    gap_pct
        Gap of the user's slow loop [%].
    segments
        Number of segments of the wire.
    scores
        Score of each estimator by its name, over all references.
    problems
        Why an estimator could not be run, by its name.
    loops
        What each closed loop came to, in the order of the job's.
    ended
        Why recorded runs ended early, by the reference.
    force
        Score of the force at the known load over the first reference, by the estimator's name; the spring's force at
        the full stroke is 100 %.
    home_moves
        What became of each home move, by the reference.
    """

    job: RobustnessJob
    gap_pct: float
    segments: int
    scores: dict[str, ErrorSums]
    problems: dict[str, str]
    loops: tuple[ScoredLoop, ...]
    ended: dict[str, str]
    force: dict[str, ErrorSums]
    home_moves: dict[str, str]

    def plain(self) -> dict[str, Any]:
        """Return it as plain data, which ``of_plain`` reads."""
        return {
            **self._asdict(),
            "job": list(self.job),
            "scores": {name: asdict(score) for name, score in self.scores.items()},
            "loops": [list(loop) for loop in self.loops],
            "force": {name: asdict(score) for name, score in self.force.items()},
        }

    @staticmethod
    def of_plain(data: dict[str, Any]) -> JobAnswer:
        """Return the answer in plain data."""
        return JobAnswer(
            **{
                **data,
                "job": job_of_plain(data["job"]),
                "scores": {name: ErrorSums(**score) for name, score in data["scores"].items()},
                "loops": tuple(ScoredLoop(*loop) for loop in data["loops"]),
                "force": {name: ErrorSums(**score) for name, score in data["force"].items()},
            }
        )


def answer_of(job: RobustnessJob, store: ResultStore) -> JobAnswer:
    """Return what a job finds, computed now or before with the same sources.

    Parameters
    ----------
    job
        The job.
    store
        Where runs and answers are kept.

    Returns
    -------
    The answer.
    """
    name = digest(sources(with_estimators=True), repr(job))
    kept = store.kept_answer(drawn_wire(job.seed), name)
    if kept is not None:
        return JobAnswer.of_plain(kept)
    found = computed(job, store)
    store.keep_answer(drawn_wire(job.seed), name, found.plain())
    return found


def computed(job: RobustnessJob, store: ResultStore) -> JobAnswer:
    """Return what a job finds."""
    (condition,) = settings().conditions((job.condition,))
    wire, times = drawn_wire(job.seed), settings().run
    knowledge = store.knowledge(wire)
    own = known_wire(knowledge)
    recorded = [store.run(wire, condition, reference) for reference in job.references]
    runs = [(run, knowledge._replace(model=model)) for run, model in recorded if run.counts]
    scores: dict[str, ErrorSums] = {}
    problems: dict[str, str] = {}
    force: dict[str, ErrorSums] = {}
    for name in job.estimators:
        try:
            found = [estimated(run, users.model, name, own) for run, users in runs]
        except MusclewireError as error:
            problems[name] = " ".join(str(error).split())
            continue
        scores[name] = pooled(
            score_of(run, answers, condition, users, times) for (run, users), answers in zip(runs, found, strict=True)
        )
        if not condition.changes_load:  # otherwise the load is not known
            force[name] = pooled(force_score(run, name, condition, users, times, own) for run, users in runs[:1])
    loops = tuple(run_loop(wire, condition, knowledge.model, *pair, own) for pair in job.loops)
    ended = {run.reference: run.ended for run, _ in recorded if run.ended}
    moves = {run.reference: run.home for run, _ in recorded if run.home}
    return JobAnswer(job, knowledge.gap_pct, wire.segments, scores, problems, loops, ended, force, moves)
