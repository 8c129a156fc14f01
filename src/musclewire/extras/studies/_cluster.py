"""Evaluation on a Dask cluster. Workers may come, go and be killed; what has arrived is never computed again.

A result that stays on the cluster is computed again when its worker dies. So the client takes each result as soon as it
is there and releases it, and only a few chunks wait on the cluster at a time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from typing import Any

from musclewire.errors import CallerError, NumericsError, require_extra
from musclewire.extras.studies._evaluation import Chunk, ChunkResult, StudyTask, evaluate_chunk

# Chunks on the cluster for each of its threads: one is computed, the next waits there.
CHUNKS_PER_THREAD = 2
# While a cluster has no worker, as many chunks wait.
MIN_CHUNKS = 4
LOOK_S = 0.5
# A result that is there arrives in this time, or the client looks around before it waits for it again.
TAKE_S = 2.0
CONNECT_S = 30.0


def evaluate_on_cluster(
    task: StudyTask,
    chunks: Sequence[Chunk],
    on_result: Callable[[ChunkResult], None],
    *,
    scheduler: str,
    retries: int,
    look: Callable[[], None] = lambda: None,
) -> None:
    """Evaluate chunks on the Dask cluster of a scheduler, as "tcp://host:8786"; ``look`` may raise to stop.

    A chunk is begun again ``retries`` times if the cluster gives it up: after four deaths of workers
    (``distributed.scheduler.allowed-failures``). Raises CallerError for an unreachable scheduler or a worker of another
    version, NumericsError if a chunk has failed more often or the scheduler answers no more.
    """
    client = connected(scheduler)
    try:
        ClusterQueue(client, task, chunks, retries).run(on_result, look)
    except OSError as problem:
        raise NumericsError(
            f"the scheduler at {scheduler} answers no more ({' '.join(str(problem).split())}): start it and run the "
            "study again, finished runs are kept"
        ) from None
    finally:
        client.close()


def connected(scheduler: str) -> Any:
    """Return a client of a cluster. Raises CallerError if there is none."""
    require_extra("a Dask cluster", "sweep")
    from distributed import Client

    try:
        return Client(scheduler, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as problem:  # a time-out is an OSError
        raise CallerError(
            f"there is no Dask scheduler at {scheduler} ({' '.join(str(problem).split())}): start one with 'dask "
            "scheduler', and give the address that it prints"
        ) from None


class ClusterQueue:
    """The chunks of a study on a cluster: those that wait here, and those that are there."""

    def __init__(self, client: Any, task: StudyTask, chunks: Sequence[Chunk], retries: int) -> None:
        """Begin with all chunks here."""
        self._client, self._retries = client, retries
        self._chunks = chunks
        # Places of chunks, and how often each has failed: those that are still here, and those on the cluster.
        self._waiting = deque((place, 0) for place in range(len(chunks)))
        self._there: dict[Any, tuple[int, int]] = {}
        self._patience_s: dict[Any, float] = {}
        self._task = task

    def run(self, on_result: Callable[[ChunkResult], None], look: Callable[[], None]) -> None:
        """Keep the cluster busy until all chunks have arrived."""
        while self._waiting or self._there:
            look()
            self._submit()
            for future in self._finished():
                result = self._taken(future)
                if result is not None:
                    on_result(result)

    def _submit(self) -> None:
        """Send as many chunks as the cluster's threads need."""
        room = max(MIN_CHUNKS, CHUNKS_PER_THREAD * sum(self._client.nthreads().values()))
        while self._waiting and len(self._there) < room:
            place, failures = self._waiting.popleft()
            future = self._client.submit(evaluate_chunk, self._task, self._chunks[place], pure=False)
            self._there[future] = (place, failures)

    def _finished(self) -> list[Any]:
        """Return what is done on the cluster, well or not; none if nothing is after a moment."""
        from distributed import wait

        try:
            with self._client.as_current():
                return list(wait(list(self._there), timeout=LOOK_S, return_when="FIRST_COMPLETED").done)
        except TimeoutError:
            return []
        except CancelledError:  # one has lost its place on the cluster, and is not to hide the others
            return [future for future in self._there if future.status != "pending"]

    def _taken(self, future: Any) -> ChunkResult | None:
        """Return a result, which the cluster then forgets; None for a chunk that has to be begun or awaited again."""
        place, failures = self._there.pop(future)
        patience_s = self._patience_s.pop(future, TAKE_S)
        result: ChunkResult | None = None
        try:
            result = future.result(timeout=patience_s)
        except CallerError:
            raise
        except Exception as problem:
            if isinstance(problem, TimeoutError) and future.status != "error":
                # Its worker died before the result had left it, and it waits for another one; or the way is slow.
                self._there[future], self._patience_s[future] = (place, failures), 2.0 * patience_s
                return None
            self._failed(place, failures, problem)
        future.release()
        return result

    def _failed(self, place: int, failures: int, problem: BaseException) -> None:
        """Begin a chunk again, or raise what has failed too often."""
        if isinstance(problem, ImportError):
            raise CallerError(
                f"a worker of the cluster cannot import {problem.name or problem}: install the same musclewire, "
                "and the package of the kind of run, on every worker"
            ) from None
        if failures >= self._retries:
            text, chunk = " ".join(str(problem).split()), self._chunks[place]
            raise NumericsError(
                f"the runs {chunk.first} to {chunk.stop - 1} have failed {failures + 1} times on the cluster "
                f"({type(problem).__name__}: {text}): look there and run the study again, finished runs are kept"
            ) from None
        self._waiting.append((place, failures + 1))
