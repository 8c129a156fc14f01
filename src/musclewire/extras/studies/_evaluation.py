"""The evaluation of a chunk of runs: the one function that every core and every worker of a cluster calls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, MusclewireError
from musclewire.extras.studies._plan import RUN, Plan, engine
from musclewire.extras.studies._run_kind import (
    KindOptions,
    Outcome,
    Overheated,
    Quantity,
    RunKind,
    StudyRun,
    StudyRuns,
    column_of,
    each,
    overheated_of,
    texts_of,
)
from musclewire.extras.studies._varied_rig import Value, VariedRig
from musclewire.parameters import validated
from musclewire.rigs import RigConfiguration


@dataclass(frozen=True)
class StudyTask:
    """All that a worker must know of a study besides the values of its runs; it can be pickled."""

    kind: RunKind[Any]
    configuration: RigConfiguration
    where: str  # name of the study in messages
    names: tuple[str, ...]  # of the parameters, in the order of the values
    options: KindOptions  # before any of them varies
    keep: Mapping[str, Quantity]  # quantities that are kept
    seed: int
    engine: str  # what must compute the numbers, as ``plan.engine`` returns it


class Chunk(NamedTuple):
    """Some consecutive runs: the number of the first, and the values of each."""

    first: int
    values: Sequence[tuple[Value, ...]]

    @property
    def stop(self) -> int:
        """Number of the run after the last."""
        return self.first + len(self.values)


class ChunkResult(NamedTuple):
    """What a chunk's runs yielded."""

    first: int  # number of the first run
    # Kept quantities, (n_runs,), or (n_runs, n_samples) for a series; NaN for runs that failed.
    columns: Mapping[str, FloatArray]
    errors: tuple[str, ...]  # "" for a run that went well
    texts: Mapping[str, tuple[str, ...]]  # kept quantities that are texts
    overheated: tuple[Overheated, ...] = ()

    @property
    def stop(self) -> int:
        """Number of the run after the last."""
        return self.first + len(self.errors)


def task_of(plan: Plan) -> StudyTask:
    """Return what workers must know of a study."""
    return StudyTask(
        kind=plan.kind,
        configuration=plan.rig.configuration,
        where=plan.rig.where,
        names=plan.design.names,
        options=plan.options,
        keep=plan.keep,
        seed=plan.file.seed,
        engine=engine(),
    )


def evaluate_chunk(task: StudyTask, chunk: Chunk) -> ChunkResult:
    """Return the kept quantities of some runs. They depend on nothing else: not on other runs, cores or workers.

    A run that fails has NaN, and its error in words. Raises CallerError in a process of another version than the asking
    one.
    """
    if task.engine != engine():
        raise CallerError(f"this worker has {engine()}, the study is run by {task.engine}: install the same everywhere")
    rig = VariedRig(task.configuration, task.where, [name for name in task.names if not name.startswith(RUN)])
    runs = each(lambda place: run_of(task, chunk.first + place, chunk.values[place]), range(len(chunk.values)))
    possible = [run for run in runs if not isinstance(run, MusclewireError)]
    found = iter(task.kind.evaluate(StudyRuns(rig, possible, frozenset(task.keep))))
    outcomes: list[Outcome] = [run if isinstance(run, MusclewireError) else next(found) for run in runs]
    columns = {name: column_of(name, item, outcomes) for name, item in task.keep.items() if not item.is_text}
    texts = {name: texts_of(name, outcomes) for name, item in task.keep.items() if item.is_text}
    errors = tuple(message(one) if isinstance(one, MusclewireError) else "" for one in outcomes)
    return ChunkResult(chunk.first, columns, errors, texts, overheated_of(outcomes, chunk.first))


def run_of(task: StudyTask, number: int, values: Sequence[Value]) -> StudyRun[Any]:
    """Return one run with its values; those of ``run.KEY`` change its options."""
    named = dict(zip(task.names, values, strict=True))
    changed = {name.removeprefix(RUN): value for name, value in named.items() if name.startswith(RUN)}
    on_rig = {name: value for name, value in named.items() if not name.startswith(RUN)}
    options = task.options
    if changed:
        options = validated(type(options), {**dict(options), **changed}, f"{task.where}: run")
    return StudyRun(number, on_rig, options, task.seed)


def message(error: MusclewireError) -> str:
    """Return an error as one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"
