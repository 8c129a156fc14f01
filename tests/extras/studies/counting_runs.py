"""A kind of run from outside of musclewire, which notes each run in a file: a test sees which were evaluated."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from musclewire.errors import NumericsError
from musclewire.extras.studies import KindOptions, Outcome, Quantity, RunKind, StudyRuns, each
from musclewire.extras.studies._run_kind import StudyRun


class CountingOptions(KindOptions):
    """Keys of ``[run]``: the file of notes, and how long a chunk takes."""

    notes: str
    takes_s: float = 0.0
    dies_at: int = -1
    always: bool = False
    fails_at: int = -1


def quantities(options: CountingOptions) -> Mapping[str, Quantity]:  # noqa: ARG001
    return {"number": Quantity("1", "the run's number"), "draw": Quantity("1", "a random number of the run's seed")}


def evaluate(runs: StudyRuns[CountingOptions]) -> Sequence[Outcome]:
    options = runs.runs[0].options
    numbers = [run.number for run in runs.runs]
    if options.takes_s:
        time.sleep(options.takes_s)
    # The first process that reaches this run dies, and leaves a note for the next one.
    note = Path(f"{options.notes}.died")
    if options.dies_at in numbers and (options.always or not note.exists()):
        note.write_text("", "utf-8")
        os._exit(1)
    with Path(options.notes).open("a", encoding="utf-8") as file:
        file.write("".join(f"{number}\n" for number in numbers))  # one write: lines of several processes do not mix
    return each(one, runs.runs)


def one(run: StudyRun[CountingOptions]) -> Outcome:
    if run.number == run.options.fails_at:
        raise NumericsError("this run fails on purpose")
    return {"number": float(run.number), "draw": run.own_seed / 2.0**32}


COUNTING = RunKind(CountingOptions, quantities, evaluate, runs_per_chunk=4)
