"""Evaluation on the cores of this machine, by processes of our own: nothing to set up, and one that dies is replaced.

Each process reads pickled chunks from its standard input and writes pickled results to its standard output; a thread of
the parent waits for each. No process runs the caller's own script, so that a study needs no ``if __name__`` around it.
"""

from __future__ import annotations

import pickle
import queue
import subprocess
import threading
from collections.abc import Callable, Sequence
from typing import Any

from musclewire.errors import CallerError, NumericsError
from musclewire.experiment import end_worker, start_worker
from musclewire.extras.studies._evaluation import Chunk, ChunkResult, StudyTask, evaluate_chunk

__all__ = ["evaluate_here", "evaluate_locally"]

OnResult = Callable[[ChunkResult], None]
# How often the caller looks whether it has been asked to stop.
LOOK_S = 0.2


def evaluate_here(
    task: StudyTask, chunks: Sequence[Chunk], on_result: OnResult, *, look: Callable[[], None] = lambda: None
) -> None:
    """Evaluate chunks one after the other in this process.

    Parameters
    ----------
    task
        The study.
    chunks
        The chunks.
    on_result
        Called with each result.
    look
        Called before each chunk; it may raise to stop.
    """
    for chunk in chunks:
        look()
        on_result(evaluate_chunk(task, chunk))


def evaluate_locally(
    task: StudyTask,
    chunks: Sequence[Chunk],
    on_result: OnResult,
    *,
    workers: int,
    retries: int,
    look: Callable[[], None] = lambda: None,
) -> None:
    """Evaluate chunks on several cores of this machine.

    Parameters
    ----------
    task
        The study.
    chunks
        The chunks, in the order in which they are begun.
    on_result
        Called with each result in the calling thread, in the order in which they are finished.
    workers
        Number of processes.
    retries
        How often a chunk is begun again whose process has died.
    look
        Called at least five times a second; it may raise to stop.

    Raises
    ------
    CallerError
        For a kind of run that another process cannot import.
    NumericsError
        If a chunk has failed more often than that, or by an error in the code.
    """
    pool = ChunkPool(pickled(task), chunks, retries)
    threads = [threading.Thread(target=pool.serve, daemon=True) for _ in range(min(workers, len(chunks)))]
    for thread in threads:
        thread.start()
    try:
        for _ in chunks:
            on_result(pool.next_result(look))
    finally:
        pool.stop()
        for thread in threads:
            thread.join()
        pool.end()


def pickled(task: StudyTask) -> bytes:
    """Return a task as bytes. Raises CallerError for a kind of run that is known in this process only."""
    module = getattr(task.kind.evaluate, "__module__", "")
    try:
        data = pickle.dumps(task)
    except (pickle.PicklingError, AttributeError, TypeError) as problem:
        raise CallerError(
            f"this kind of run cannot be sent to another process ({problem}): one worker runs it"
        ) from None
    if module == "__main__":
        raise CallerError(
            "this kind of run is defined in the script itself, which no other process can import: put it into a "
            "module, or run the study with one worker"
        )
    return data


class ChunkPool:
    """Processes that take chunks from one queue and put results into another."""

    def __init__(self, task: bytes, chunks: Sequence[Chunk], retries: int) -> None:
        """Queue the chunks."""
        self._task, self._retries = task, retries
        self._chunks = chunks
        self._todo: queue.SimpleQueue[tuple[int, int]] = queue.SimpleQueue()  # place of a chunk, and its failures
        self._done: queue.SimpleQueue[ChunkResult | BaseException] = queue.SimpleQueue()
        self._processes: set[subprocess.Popen[bytes]] = set()
        self._stopping = threading.Event()
        for place in range(len(chunks)):
            self._todo.put((place, 0))

    def next_result(self, look: Callable[[], None]) -> ChunkResult:
        """Return the next finished chunk; raise what has ended a worker for good."""
        while True:
            look()
            try:
                found = self._done.get(timeout=LOOK_S)
            except queue.Empty:
                continue
            if isinstance(found, BaseException):
                raise found
            return found

    def stop(self) -> None:
        """End all processes, and with them the threads."""
        self._stopping.set()
        for process in list(self._processes):
            process.kill()

    def end(self) -> None:
        """Close what is left of the processes, once no thread waits for one."""
        for process in list(self._processes):
            self._end(process)

    def serve(self) -> None:
        """Keep one process busy until there is no chunk left or all is stopped; the body of a thread."""
        process: subprocess.Popen[bytes] | None = None
        try:
            while not self._stopping.is_set():
                try:
                    place, failures = self._todo.get_nowait()
                except queue.Empty:
                    return  # a chunk whose process dies is begun again by the thread that had it
                process = self._evaluated(process, place, failures)
        except BaseException as problem:
            self._done.put(problem)
        finally:
            if process is not None:
                self._end(process)

    def _evaluated(
        self, process: subprocess.Popen[bytes] | None, place: int, failures: int
    ) -> subprocess.Popen[bytes] | None:
        """Let a process evaluate a chunk and return the process; None if it has died, the chunk then waits again."""
        running = process if process is not None else self._start()
        chunk = self._chunks[place]
        try:
            answer: Any = asked(running, chunk)
        except (OSError, EOFError, pickle.UnpicklingError):
            self._end(running)
            if self._stopping.is_set():
                return None
            if failures >= self._retries:
                raise NumericsError(
                    f"the process that evaluates the runs {chunk.first} to {chunk.stop - 1} has died {failures + 1} "
                    "times: is there enough memory? run the study again, finished runs are kept"
                ) from None
            self._todo.put((place, failures + 1))
            return None
        if isinstance(answer, BaseException):
            raise answer
        self._done.put(answer)
        return running

    def _start(self) -> subprocess.Popen[bytes]:
        """Return a new process that knows the study."""
        process = start_worker("musclewire.extras.studies._worker")
        self._processes.add(process)
        if self._stopping.is_set():  # it may have been started just after all others were ended
            process.kill()
        assert process.stdin is not None
        process.stdin.write(self._task)
        process.stdin.flush()
        return process

    def _end(self, process: subprocess.Popen[bytes]) -> None:
        """End a process and forget it."""
        end_worker(process)
        self._processes.discard(process)


def asked(process: subprocess.Popen[bytes], chunk: Chunk) -> Any:
    """Return the answer of a process to a chunk. Raises EOFError or OSError if it has died."""
    assert process.stdin is not None
    assert process.stdout is not None
    pickle.dump(chunk, process.stdin)
    process.stdin.flush()
    return pickle.load(process.stdout)
