"""A local worker: ``python -m`` this module evaluates chunks from its standard input until that ends."""

from __future__ import annotations

import os
import pickle
import sys
from typing import BinaryIO

from musclewire.errors import NumericsError
from musclewire.extras.studies._evaluation import Chunk, StudyTask, evaluate_chunk

__all__ = ["main"]


def main() -> None:
    """Read a task, then chunks; write a result, or an error, for each."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever a kind of run prints must not come between the answers
    requests = sys.stdin.buffer
    try:
        task = loaded(requests)
        while True:
            pickle.dump(answer_to(task, pickle.load(requests)), answers)
            answers.flush()
    except (EOFError, BrokenPipeError):
        return


def loaded(requests: BinaryIO) -> StudyTask | NumericsError:
    """Return the task of this worker, or why it cannot be read: its kind of run may not be importable here."""
    try:
        task: StudyTask = pickle.load(requests)
        return task
    except (ImportError, AttributeError) as problem:
        return NumericsError(f"a worker cannot import the kind of run: {problem}")


def answer_to(task: StudyTask | NumericsError, chunk: Chunk) -> object:
    """Return the result of a chunk, or the error that the parent is to raise."""
    if isinstance(task, NumericsError):
        return task
    try:
        return evaluate_chunk(task, chunk)
    except Exception as problem:
        return NumericsError(f"runs {chunk.first} to {chunk.stop - 1}: {type(problem).__name__}: {problem}")


if __name__ == "__main__":
    main()
