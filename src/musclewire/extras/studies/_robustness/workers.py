"""Jobs on the cores of this machine; those of one wire go to one process, which characterises it once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from musclewire.experiment import evaluate_in_processes
from musclewire.extras.studies._robustness.jobs import JobAnswer, RobustnessJob, answer_of
from musclewire.extras.studies._robustness.store import ResultStore

__all__ = ["answers_of"]


def answers_of(
    jobs: Sequence[RobustnessJob],
    folder: Path,
    on_answer: Callable[[JobAnswer], None],
    *,
    workers: int,
    look: Callable[[], None] = lambda: None,
) -> None:
    """Call back with the answers of jobs in the order in which they are found; ``look`` may raise to stop."""
    groups: dict[int, list[RobustnessJob]] = {}
    for job in jobs:
        groups.setdefault(job.seed, []).append(job)

    def on_result(_group: Sequence[RobustnessJob], answers: Sequence[JobAnswer]) -> None:
        for answer in answers:
            on_answer(answer)

    evaluate_in_processes(
        partial(answers_of_wire, folder),
        list(groups.values()),
        on_result,
        workers=workers,
        named=lambda group: f"wire {group[0].seed}",
        look=look,
    )


def answers_of_wire(folder: Path, jobs: Sequence[RobustnessJob]) -> list[JobAnswer]:
    """Return the answers of the jobs of one wire."""
    store = ResultStore(folder)
    return [answer_of(job, store) for job in jobs]
