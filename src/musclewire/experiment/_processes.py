"""The one pool of processes: whatever is computed on several cores of this machine is computed here.

The processes are loky's: none runs the caller's own script, so that nothing needs an ``if __name__`` around it, and
what a script defines can be sent to them. Each has an executor of its own, so that one that dies takes one item along.
"""

from __future__ import annotations

import os
import signal
import sys
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import contextmanager
from pathlib import Path
from pickle import PicklingError
from typing import Any, NamedTuple, TypeVar

from musclewire.errors import CallerError, NumericsError

Item = TypeVar("Item")
Result = TypeVar("Result")
# A process computes on one core; the numerical libraries' own threads would only compete.
ONE_THREAD = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
# With it Python, loky's own helper included, imports nothing from the folder where the user works.
SAFE_PATH = {"PYTHONSAFEPATH": "1"}
# How often the caller looks whether it has been asked to stop.
LOOK_S = 0.2
# A process without work ends after this time, also one whose parent was killed.
IDLE_S = 30
RETRIES = 1


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def evaluate_in_processes(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    on_result: Callable[[Item, Result], None],
    *,
    workers: int,
    named: Callable[[Item], str],
    retries: int = RETRIES,  # how often an item is begun again whose process has died
    look: Callable[[], None] = lambda: None,
) -> None:
    """Evaluate a function of each item on several cores of this machine, or here with one worker or a single item.

    The function must be of a module, or able to be pickled. ``on_result`` is called in this thread as items are
    finished; ``look``, before each item and several times a second, may raise to stop.
    """
    if min(workers, len(items)) <= 1:
        for item in items:
            look()
            on_result(item, function(item))
        return
    pool = Pool(function, min(workers, len(items)))
    waiting = deque((place, 0) for place in range(len(items)))
    try:
        while waiting or pool.running:
            look()
            while waiting and pool.idle:
                place, failures = waiting.popleft()
                pool.begin(Attempt(items[place], place, failures))
            for attempt, found in pool.finished():
                if found is DIED:
                    if attempt.failures >= retries:
                        raise NumericsError(
                            f"the process that evaluates {named(attempt.item)} has died {attempt.failures + 1} times: "
                            "is there enough memory? try again with fewer processes; what was kept is not repeated"
                        )
                    waiting.append((attempt.place, attempt.failures + 1))
                elif isinstance(found, FailedItem):
                    raise NumericsError(f"{named(attempt.item)}: {found.problem}")
                else:
                    on_result(attempt.item, found)
    finally:
        pool.end()


class Attempt(NamedTuple):
    """An item that is evaluated, its place, and how often its process has died."""

    item: Any
    place: int
    failures: int


class FailedItem(NamedTuple):
    """An error in the code of another process, in words: not every error can be sent."""

    problem: str


# What an attempt yields whose process has died.
DIED = object()


class Pool:
    """Processes with an executor each: those that compute, and those that wait."""

    def __init__(self, function: Callable[[Any], Any], workers: int) -> None:
        """Take the function; a process is started with its first item."""
        self._function = function
        self.idle = [executor() for _ in range(workers)]
        self.running: dict[Future[Any], tuple[Attempt, Any]] = {}

    def begin(self, attempt: Attempt) -> None:
        """Let a process that waits evaluate an item."""
        process = self.idle.pop()
        with clean_start():
            self.running[process.submit(result_or_failure, self._function, attempt.item)] = (attempt, process)

    def finished(self) -> Iterator[tuple[Attempt, Any]]:
        """Yield what is finished after a moment at most. Raises CallerError for what cannot be sent."""
        from loky.process_executor import TerminatedWorkerError

        for future in wait(self.running, timeout=LOOK_S, return_when=FIRST_COMPLETED).done:
            attempt, process = self.running.pop(future)
            try:
                found = future.result()
            except TerminatedWorkerError:
                found, process = DIED, executor()
            except (BrokenExecutor, PicklingError) as problem:
                raise CallerError(
                    f"this cannot be sent to another process ({' '.join(str(problem.__cause__ or problem).split())}): "
                    "put what it consists of into a module, or let one process do it all"
                ) from None
            self.idle.append(process)
            yield attempt, found

    def end(self) -> None:
        """End all processes, whatever they do."""
        with warnings.catch_warnings():
            # Without pgrep, loky says that a process's own children are not ended; ours have none.
            warnings.simplefilter("ignore", UserWarning)
            for process in [*self.idle, *(process for _, process in self.running.values())]:
                process.shutdown(wait=True, kill_workers=True)


def executor() -> Any:
    """Return an executor of one process."""
    from loky import ProcessPoolExecutor

    with clean_start():  # its queues already start a helper of loky's
        return ProcessPoolExecutor(1, timeout=IDLE_S, env={**ONE_THREAD, **SAFE_PATH}, initializer=print_to_errors)


def print_to_errors() -> None:
    """Let whatever this process prints appear among the errors: the output is the command's answer alone."""
    os.dup2(2, 1)


def result_or_failure(function: Callable[[Item], Result], item: Item) -> Result | FailedItem:
    """Return the result of an item, or the error in the code that the parent is to raise."""
    try:
        return function(item)
    except Exception as problem:
        return FailedItem(f"{type(problem).__name__}: {' '.join(str(problem).split())}")


@contextmanager
def clean_start() -> Iterator[None]:
    """Let processes that are started here look for modules as this one does, but not in the current folder.

    Ctrl-C is kept from them, too: it is for this process, which ends the others itself.
    """
    import_path, before = sys.path, {name: os.environ[name] for name in SAFE_PATH if name in os.environ}
    sys.path = [str(Path(entry).absolute()) for entry in import_path if entry not in ("", os.curdir)]
    os.environ.update(SAFE_PATH)
    masked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if hasattr(signal, "pthread_sigmask") else None
    try:
        yield
    finally:
        if masked is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, masked)
        sys.path = import_path
        for name in SAFE_PATH:
            del os.environ[name]
        os.environ.update(before)
