"""Jobs on the cores of this machine, by processes of our own; the caller's thread gets the answers as they come."""

from __future__ import annotations

import json
import queue
import subprocess
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from musclewire.errors import NumericsError
from musclewire.experiment import end_worker, start_worker
from musclewire.extras.studies._robustness.jobs import JobAnswer, RobustnessJob, answer_of
from musclewire.extras.studies._robustness.store import ResultStore

__all__ = ["answers_of"]

MODULE = "musclewire.extras.studies._robustness.worker"
# How often the caller looks whether it has been asked to stop.
LOOK_S = 0.2


def answers_of(
    jobs: Sequence[RobustnessJob], folder: Path, *, workers: int, look: Callable[[], None] = lambda: None
) -> Iterator[JobAnswer]:
    """Yield the answers of jobs in the order in which they are found.

    Parameters
    ----------
    jobs
        The jobs; those of one wire go to one process, which characterises it once.
    folder
        Where runs and answers are kept.
    workers
        Number of processes; 1 for this process alone, which knows estimators that only a script has registered.
    look
        Called several times a second or, without other processes, before each job; it may raise to stop.

    Yields
    ------
    An answer for each job.

    Raises
    ------
    NumericsError
        If a worker has died, or its code has failed.
    """
    if workers == 1:
        store = ResultStore(folder)
        for job in jobs:
            look()
            yield answer_of(job, store)
        return
    pool = WorkerPool(grouped(jobs), folder)
    pool.start(workers)
    try:
        for _ in jobs:
            yield pool.next_answer(look)
    finally:
        pool.end()


def grouped(jobs: Sequence[RobustnessJob]) -> list[list[RobustnessJob]]:
    """Return the jobs by wires, in their order."""
    found: dict[int, list[RobustnessJob]] = {}
    for job in jobs:
        found.setdefault(job.seed, []).append(job)
    return list(found.values())


class WorkerPool:
    """Processes, each with a thread that hands it the jobs of one wire after another."""

    def __init__(self, groups: Sequence[Sequence[RobustnessJob]], folder: Path) -> None:
        """Queue the groups."""
        self._folder = folder
        self._todo: queue.SimpleQueue[Sequence[RobustnessJob]] = queue.SimpleQueue()
        self._done: queue.SimpleQueue[JobAnswer | BaseException] = queue.SimpleQueue()
        self._processes: list[subprocess.Popen[bytes]] = []
        self._threads: list[threading.Thread] = []
        self._stopping = threading.Event()
        self._groups = len(groups)
        for group in groups:
            self._todo.put(group)

    def start(self, workers: int) -> None:
        """Start processes and their threads."""
        for _ in range(min(workers, self._groups)):
            process = start_worker(MODULE)
            self._processes.append(process)
            thread = threading.Thread(target=self._serve, args=(process,), daemon=True)
            self._threads.append(thread)
            thread.start()

    def _serve(self, process: subprocess.Popen[bytes]) -> None:
        """Hand a process one group after another; the body of a thread."""
        try:
            ask(process, json.dumps(str(self._folder)))
            while not self._stopping.is_set():
                try:
                    group = self._todo.get_nowait()
                except queue.Empty:
                    return
                for job in group:
                    ask(process, json.dumps(list(job)))
                    self._done.put(answered(process))
        except BaseException as problem:
            self._done.put(problem)

    def next_answer(self, look: Callable[[], None]) -> JobAnswer:
        """Return the next answer; raise what has ended a worker."""
        while True:
            look()
            try:
                found = self._done.get(timeout=LOOK_S)
            except queue.Empty:
                continue
            if isinstance(found, BaseException):
                raise found
            return found

    def end(self) -> None:
        """End all processes and threads."""
        self._stopping.set()
        for process in self._processes:
            process.kill()
        for thread in self._threads:
            thread.join()
        for process in self._processes:
            end_worker(process)


def ask(process: subprocess.Popen[bytes], line: str) -> None:
    """Send a line to a process."""
    assert process.stdin is not None
    try:
        process.stdin.write(line.encode() + b"\n")
        process.stdin.flush()
    except OSError:
        raise NumericsError("a worker of the benchmark has died: run it again, what was finished is kept") from None


def answered(process: subprocess.Popen[bytes]) -> JobAnswer:
    """Return a process's next answer. Raises NumericsError if it has died, or its code has failed."""
    assert process.stdout is not None
    line = process.stdout.readline()
    if not line:
        raise NumericsError(
            "a worker of the benchmark has died: is there enough memory? run it again, what was finished is kept"
        )
    data = json.loads(line)
    if isinstance(data, str):
        raise NumericsError(f"a worker of the benchmark has failed: {data}")
    return JobAnswer.of_plain(data)
