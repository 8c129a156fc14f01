"""A study of many wires: read, run on this machine's cores or on a Dask cluster, continued where it was stopped."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError
from musclewire.experiment import cores, evaluate_in_processes
from musclewire.extras.studies._evaluation import Chunk, ChunkResult, evaluate_chunk, task_of
from musclewire.extras.studies._folder import StudyFolder, unfinished
from musclewire.extras.studies._plan import Plan, plan_of
from musclewire.extras.studies._run_kind import Overheated
from musclewire.extras.studies._study_file import study_file
from musclewire.small_files import read_toml

if TYPE_CHECKING:
    import xarray as xr

    from musclewire.extras.studies._sensitivity import Sensitivity

# Called with the number of runs that are finished, and of all.
OnProgress = Callable[[int, int], None]
RETRIES = 5


@dataclass(frozen=True)
class Workers:
    """Where and how a study is evaluated; its numbers do not depend on it."""

    # Address of a Dask cluster's scheduler, as "tcp://host:8786"; None for the cores of this machine.
    scheduler: str | None = None
    processes: int | None = None  # None for one on each core; 1 is the calling process
    runs_per_chunk: int | None = None  # evaluated together and written as one file; None for what suits the kind of run
    retries: int = RETRIES  # how often a chunk is begun again whose worker has died


@dataclass(frozen=True, eq=False)
class StudyResult:
    """All runs of a study."""

    plan: Plan = field(repr=False)  # the study
    # Each kept quantity over the runs, (n_runs,), or (n_runs, n_samples) for a series; NaN for runs that failed.
    columns: Mapping[str, FloatArray] = field(repr=False)
    # The message of each run's error, "" for a run that went well, (n_runs,).
    errors: tuple[str, ...] = field(repr=False)
    evaluated: int = 0  # runs that were evaluated now; all others were finished before
    # Each kept quantity that is a text, over the runs.
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict, repr=False)
    # Runs whose wires went beyond the highest temperature that their protection allows: number, temperature, limit.
    overheated: tuple[Overheated, ...] = field(default=(), repr=False)

    @property
    def failed(self) -> int:
        """Number of runs that failed."""
        return sum(1 for text in self.errors if text)

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(self.errors)

    def parameter(self, name: str) -> np.ndarray[Any, Any]:
        """Return the values of a parameter over the runs, (n_runs,): numbers in SI, or names."""
        return self.plan.design.column(name)

    def dataset(self) -> xr.Dataset:
        """Return parameters and quantities as an xarray data set over the runs. Needs the extra ``sweep``."""
        from musclewire.extras.studies._data_set import data_set_of

        return data_set_of(self.plan, self.columns, self.errors, self.texts, self.overheated)

    def sensitivity(self) -> list[Sensitivity]:
        """Return how much each quantity depends on each parameter. Needs the extra ``sweep``."""
        from musclewire.extras.studies._sensitivity import sensitivity_of

        return sensitivity_of(self.plan.design, self.columns, self.plan.file.seed)


def read_study(study: str | Path | Mapping[str, Any]) -> Plan:
    """Return a study, checked completely.

    Parameters
    ----------
    study
        A study file (.toml), or its content; files that it names are then found in the working directory.

    Returns
    -------
    The study with all its runs.

    Raises
    ------
    CallerError
        For a file that is missing or wrong: the message names the key, and the nearest right one.
    """
    if isinstance(study, Mapping):
        return plan_of(study_file(dict(study), "study"), "study", Path())
    path = Path(study)
    where = f"study file {path}"
    return plan_of(study_file(read_toml(path, "study file"), where), where, path.parent)


def sweep(
    study: str | Path | Mapping[str, Any] | Plan,
    folder: str | Path | None = None,
    *,
    workers: Workers | None = None,
    overwrite: bool = False,
    on_progress: OnProgress | None = None,
    look: Callable[[], None] = lambda: None,
) -> StudyResult:
    """Run a study of many wires: every point of its grid with every sample of its distributions.

    Parameters
    ----------
    study
        A study file (.toml), its content, or what ``read_study`` has returned.
    folder
        Folder in which finished runs are kept, so that a study that was interrupted continues there; the data set, its
        page and its sensitivity table are written with ``write_study``. By default nothing is written.
    workers
        Where it is evaluated; by default on all cores of this machine. The numbers are the same everywhere.
    overwrite
        Whether the results of another study in the folder are deleted.
    on_progress
        Called with the number of finished runs and of all.
    look
        Called several times a second between chunks; it may raise to stop.

    Returns
    -------
    All runs. One that fails, because its wire does not transform for example, has NaN and its error in words.

    Raises
    ------
    CallerError
        For a wrong study, a folder of another one, or a cluster that is not there.
    NumericsError
        If a worker has died too often.

    Examples
    --------
    >>> import musclewire as mw
    >>> study = {
    ...     "format": "musclewire-study",
    ...     "version": 1,
    ...     "name": "pretension",
    ...     "run": {"kind": "characterize", "cycles": 1, "keep": ["strain_gap"]},
    ...     "parameters": {"pretension": {"values": ["1.2 N", "1.9 N"]}},
    ... }
    >>> result = mw.sweep(study)
    >>> len(result), result.failed
    (2, 0)
    """
    plan = study if isinstance(study, Plan) else read_study(study)
    chosen = workers or Workers()
    store = None if folder is None else StudyFolder(Path(folder), plan, overwrite)
    if store is not None and store.data.exists():  # it has been written, and its chunks were deleted
        from musclewire.extras.studies._data_set import read_columns

        columns, errors, texts, overheated = read_columns(store.data)
        return StudyResult(plan, columns, errors, texts=texts, overheated=overheated)
    kept = FinishedChunks(plan, store)
    chunks = unfinished(
        plan, kept.finished, positive(chosen.runs_per_chunk, "runs_per_chunk") or plan.kind.runs_per_chunk
    )
    before = kept.runs
    say = on_progress or (lambda _done, _total: None)
    say(before, len(plan.design))

    def on_result(result: ChunkResult) -> None:
        kept.keep_chunk(result)
        say(kept.runs, len(plan.design))

    evaluate(plan, chunks, on_result, chosen, look)
    results = kept.all()
    columns, errors, texts = kept.joined(results)
    overheated = tuple(one for result in results for one in result.overheated)
    return StudyResult(plan, columns, errors, len(plan.design) - before, texts, overheated)


def evaluate(
    plan: Plan,
    chunks: Sequence[Chunk],
    on_result: Callable[[ChunkResult], None],
    workers: Workers,
    look: Callable[[], None],
) -> None:
    """Evaluate chunks where the user wants them."""
    task = task_of(plan)
    processes = positive(workers.processes, "processes") or cores()
    if not chunks:
        return
    if workers.scheduler is not None:
        from musclewire.extras.studies._cluster import evaluate_on_cluster

        evaluate_on_cluster(task, chunks, on_result, scheduler=workers.scheduler, retries=workers.retries, look=look)
    else:
        evaluate_in_processes(
            partial(evaluate_chunk, task),
            chunks,
            lambda _, result: on_result(result),
            workers=processes,
            named=lambda chunk: f"the runs {chunk.first} to {chunk.stop - 1}",
            retries=workers.retries,
            look=look,
        )


def positive(number: int | None, name: str) -> int | None:
    """Return a number that is None or above 0. Raises CallerError for any other."""
    if number is not None and number < 1:
        raise CallerError(f"{name} is {number}: give 1 or more")
    return number


class FinishedChunks:
    """Finished chunks: in the folder of the study, or in memory if it has none."""

    def __init__(self, plan: Plan, folder: StudyFolder | None) -> None:
        """Look what is finished already."""
        self._plan, self._folder = plan, folder
        self._results: list[ChunkResult] = []
        self.finished = [] if folder is None else folder.finished()
        self.runs = sum(stop - first for first, stop in self.finished)

    def keep_chunk(self, result: ChunkResult) -> None:
        """Keep a finished chunk."""
        if self._folder is None:
            self._results.append(result)
        else:
            self._folder.write(result)
        self.runs += len(result.errors)

    def all(self) -> list[ChunkResult]:
        """Return all chunks in the order of the runs."""
        return sorted(self._results, key=lambda one: one.first) if self._folder is None else list(self._folder.read())

    def joined(
        self, results: Sequence[ChunkResult]
    ) -> tuple[dict[str, FloatArray], tuple[str, ...], dict[str, tuple[str, ...]]]:
        """Return all quantities over all runs, all errors and all texts."""
        numbers = [name for name, item in self._plan.keep.items() if not item.is_text]
        columns = {name: joined([one.columns[name] for one in results]) for name in numbers}
        errors = tuple(text for one in results for text in one.errors)
        texts = {
            name: tuple(text for one in results for text in one.texts[name])
            for name in self._plan.keep
            if name not in numbers
        }
        return columns, errors, texts


def joined(parts: list[FloatArray]) -> FloatArray:
    """Return columns one after the other; series of different lengths end with NaN."""
    if not parts or parts[0].ndim == 1:
        return np.concatenate(parts) if parts else np.empty(0)
    # At least one sample wide: if every run failed there is none, and a list of no length is none in a file.
    found = np.full((sum(len(part) for part in parts), max(1, *(part.shape[1] for part in parts))), np.nan)
    row = 0
    for part in parts:
        found[row : row + len(part), : part.shape[1]] = part
        row += len(part)
    return found
