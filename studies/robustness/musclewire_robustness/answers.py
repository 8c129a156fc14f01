"""What the command ``robustness`` prints with --json."""

from __future__ import annotations

from typing import Annotated

from musclewire.app import AnswerModel, AnswerRecord
from musclewire_robustness.grips import GripRow
from musclewire_robustness.table_text import RobustnessRow
from musclewire_robustness.task_table import NamedRuns, TaskRow
from musclewire_robustness.verdicts import BarVerdict

Words = tuple[str, ...]


class RobustnessAnswer(AnswerModel):
    """Of ``robustness``; the file ``rows.json`` has all but ``report``."""

    rows: tuple[RobustnessRow, ...]
    grips: tuple[GripRow, ...]
    bars: tuple[Annotated[BarVerdict, AnswerRecord(holds=bool)], ...]
    missed: Words
    new_misses: Words
    repaired: Words
    seeds: tuple[int, ...]
    seeds_are: str
    references: Words
    quick: bool
    wall_s: float
    report: str


class RobustnessNames(AnswerModel):
    """Of ``robustness --list``."""

    conditions: Words
    tracks: Words
    estimators: Words


class TasksAnswer(AnswerModel):
    """Of ``robustness --tasks``; the file ``tasks.json`` has all of it."""

    rows: tuple[TaskRow, ...]
    named: tuple[NamedRuns, ...]
    quick: bool
    wall_s: float


RobustnessAnswers = RobustnessAnswer | RobustnessNames | TasksAnswer
