"""A worker: ``python -m`` this module answers jobs from its standard input until that ends.

The first line is the folder as JSON text, each further line a job as a JSON list; for each it writes a JSON line: the
answer, or a text if the code has failed.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any, TextIO

from musclewire.extras.studies._robustness.jobs import answer_of, job_of_plain
from musclewire.extras.studies._robustness.store import ResultStore

__all__ = ["main"]


def main() -> None:
    """Read the folder, then jobs; write a line for each."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # whatever a run prints must not come between the answers
    try:
        answer_all(sys.stdin, answers)
    except BrokenPipeError:
        return


def answer_all(requests: TextIO, answers: TextIO) -> None:
    """Answer each job until there are no more."""
    store = ResultStore(Path(json.loads(requests.readline() or '"."')))
    for line in requests:
        answers.write(json.dumps(plain_answer(json.loads(line), store)) + "\n")
        answers.flush()


def plain_answer(data: Any, store: ResultStore) -> dict[str, Any] | str:
    """Return what a job found as plain data, or the error in the code that the parent is to raise."""
    job = job_of_plain(data)
    try:
        return answer_of(job, store).plain()
    except Exception as problem:
        return f"seed {job.seed}, {job.condition}: {type(problem).__name__}: {problem}"


if __name__ == "__main__":
    main()
