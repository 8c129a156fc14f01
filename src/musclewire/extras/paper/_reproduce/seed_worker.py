"""A worker: ``python -m musclewire.extras.paper._reproduce.seed_worker`` measures rows on the seeds it is sent.

The first line of its standard input is a JSON list of the names of rows, each further line a seed. For each seed it
writes a JSON line: number and problem of each row, in the order of the names, or a text if the code has failed.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from typing import TextIO

from musclewire.extras.paper._reproduce.all_checks import all_checks
from musclewire.extras.paper._reproduce.paper_checks import PaperCheck, SeedResult, measured
from musclewire.extras.paper._reproduce.runs import RunCache

__all__ = ["main"]


def main() -> None:
    """Read names, then seeds; write a line for each seed."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # whatever a run prints must not come between the answers
    try:
        answer_all(sys.stdin, answers)
    except BrokenPipeError:
        return


def answer_all(requests: TextIO, answers: TextIO) -> None:
    """Answer each seed until there are no more."""
    names = json.loads(requests.readline() or "[]")
    known = {check.name: check for check in all_checks()}
    chosen = [known[name] for name in names]
    for line in requests:
        answers.write(json.dumps(answer_to(chosen, int(line)), allow_nan=False) + "\n")
        answers.flush()


def answer_to(chosen: Sequence[PaperCheck], seed: int) -> list[SeedResult] | str:
    """Return what a seed gives for each row, or the error in the code that the parent is to raise."""
    try:
        runs = RunCache(seed)
        return [measured(check, runs) for check in chosen]
    except Exception as problem:
        return f"{type(problem).__name__}: {problem}"


if __name__ == "__main__":
    main()
