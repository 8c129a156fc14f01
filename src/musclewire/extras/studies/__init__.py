"""Studies of many wires: what varies, what is run, where it is evaluated, and what becomes of the results."""

from musclewire.extras.studies.data_set import on_grid, read_study_data
from musclewire.extras.studies.run_kind import (
    RUN_KINDS,
    KindOptions,
    Outcome,
    Quantity,
    RunKind,
    StudyRun,
    StudyRuns,
    each,
)
from musclewire.extras.studies.study import StudyResult, Workers, read_study, sweep

__all__ = [
    "RUN_KINDS",
    "KindOptions",
    "Outcome",
    "Quantity",
    "StudyRun",
    "RunKind",
    "StudyRuns",
    "StudyResult",
    "Workers",
    "each",
    "on_grid",
    "read_study",
    "read_study_data",
    "sweep",
]
