"""The table of tasks: which cases are run, what became of each row, and what was named of the runs that err."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from musclewire import CallerError, NumericsError
from musclewire.app import AnswerModel
from musclewire.extras.studies import Workers, read_study, sweep
from musclewire_robustness.store import FOLDER, sources
from musclewire_robustness.table_text import number
from musclewire_robustness.task_plants import PLANTS
from musclewire_robustness.task_runs import (
    ANSWER,
    CONTROLLERS,
    SCORES,
    SERVO,
    ScoredTask,
    TaskCase,
)
from musclewire_robustness.tasks import CHANGES, IN_CHANGES, STILL, TASKS

OnProgress = Callable[[int, int], None]
Scores = Mapping[TaskCase, Mapping[str, ScoredTask]]
# Seeds that are reported: of the drawn wires each has one run, and these five of them the long hold; of the others
# these five. Choose on wires 1 to 40 and 131 to 160.
WIRES, SEEDS = range(741, 771), range(741, 746)
LONG = "hold 10 min"
# A quick table has these.
QUICK_PLANTS, QUICK_SEEDS = ("simulated", "wires", "Liang-Rogers"), range(741, 743)
QUICK_TASKS, QUICK_CONDITIONS = ("staircase", "sine 30 s", "random steps"), (STILL, "draughts")
# Of an interrupted table no more than this many runs are lost in each process.
RUNS_PER_CHUNK = 11
# A run errs from this mean error on, and does its task below that [% of the target].
ERRS_PCT, DOES_PCT = 5.0, 2.0
# What is wrong of an estimate [% of what the model senses], and of an interval.
WRONG_PCT, WIDE_PCT, INSIDE = 5.0, 10.0, 0.75


class TaskRow(AnswerModel):
    """A controller at a task on a plant in a condition: medians over its seeds."""

    plant: str
    task: str
    condition: str
    controller: str
    seeds: tuple[int, ...]
    mae_mean_pct: float | None
    error_largest_pct: float | None
    estimate_rms_pct: float | None
    swing_share: float | None
    announced_share: float | None
    named: tuple[str, ...]
    exit: int
    exits: tuple[int, ...]
    ended: str


class NamedRuns(AnswerModel):
    """Of the runs of a controller: how many err and see it, how many of these are named or were announced, the others.

    ``does`` are the runs below 2 % in the mean, ``does_named`` those of them that are named for a missed target.
    """

    controller: str
    runs: int
    sees: int
    sees_named: int
    not_named: tuple[str, ...]
    others: int
    others_named: int
    interval_too_wide: int
    estimate_wrong: int
    interval_too_narrow: int
    within_tolerance: int
    none_of_these: int
    does: int
    does_named: int


@dataclass(frozen=True)
class TaskTable:
    """What the tasks came to.

    Parameters
    ----------
    rows
        A row for each plant, task, condition and controller.
    named
        What was named of the runs that err, for each loop without a sensor.
    quick
        Whether it was a quick table.
    wall_s
        How long it took [s].
    """

    rows: tuple[TaskRow, ...]
    named: tuple[NamedRuns, ...]
    quick: bool
    wall_s: float

    def __str__(self) -> str:
        """Return the table as text."""
        return "\n".join([*row_lines(self.rows), "", *map(named_line, self.named)])


class AskedRow(NamedTuple):
    """A plant, a task and a condition, in the order of the table."""

    plant: str
    task: str
    condition: str

    @property
    def name(self) -> str:
        """Its name, which ``--only`` takes a part of."""
        return "/".join(self)

    def cases(self, *, quick: bool) -> list[TaskCase]:
        """Return its runs, a seed each."""
        seeds = SEEDS if self.plant != "wires" or self.task == LONG else WIRES
        return [TaskCase(*self, seed) for seed in (QUICK_SEEDS if quick else seeds)]


def asked_rows(only: Sequence[str] = (), *, quick: bool = False) -> list[AskedRow]:
    """Return the rows of the table.

    Every task is done in still air, the staircase, a sine and random steps in every condition; a load changes where it
    can be changed while a plant runs. Raises CallerError for a part of a name that no row has.
    """
    found = [
        AskedRow(plant, task, condition)
        for plant, of in PLANTS.items()
        for condition, change in CHANGES.items()
        for task in (TASKS if condition == STILL else IN_CHANGES)
        if change.load == 0.0 or of.has_load
    ]
    for part in only:
        if not any(part in row.name for row in found):
            raise CallerError(f"no row has '{part}' in its name: rows are as '{found[0].name}'")
    if only:
        return [row for row in found if any(part in row.name for part in only)]
    if not quick:
        return found
    return [
        row
        for row in found
        if row.plant in QUICK_PLANTS and row.task in QUICK_TASKS and row.condition in QUICK_CONDITIONS
    ]


def study_of(cases: Iterable[TaskCase], folder: Path) -> dict[str, Any]:
    """Return the table as a study over its cases."""
    return {
        "format": "musclewire-study",
        "version": 1,
        "name": "tasks",
        "run": {"kind": "task", "keep": [ANSWER], "folder": str(folder), "sources": sources()},
        "parameters": {"run.case": {"values": [case.name for case in cases]}},
    }


def task_table(
    only: Sequence[str] = (),
    *,
    quick: bool = False,
    folder: str | Path = FOLDER,
    workers: int | None = None,
    on_progress: OnProgress = lambda *_: None,
    look: Callable[[], None] = lambda: None,
) -> TaskTable:
    """Let three controllers do tasks on many plants: the default, the paper's fuzzy PID, and a PI on a sensor.

    Each plant is characterized as its user would, from a slow loop of each seed. The loops are judged by the reference
    instrument; what is named of them is by what a user without one has. What was computed is kept, row by row, and a
    run that was interrupted goes on from there.

    Parameters
    ----------
    only
        Parts of the names of rows, such as "simulated/sine"; all rows if none is given.
    quick
        Three plants, three tasks and two conditions on two seeds.
    folder
        Folder for models and answers.
    workers
        Processes; by default one on each core.
    on_progress
        Called with the number of finished runs and of all.
    look
        Called several times a second; it may raise to stop.

    Returns
    -------
    The rows, and what was named of the runs that err.

    Raises
    ------
    CallerError
        For a part of a name that no row has, or plants of examples outside a checkout.
    NumericsError
        If a run has failed.

    Examples
    --------
    >>> from musclewire import task_table
    >>> task_table(["simulated/sine 30 s/still"], folder=folder, workers=1).rows[0].mae_mean_pct < 2.0  # doctest: +SKIP
    True
    """
    began_s = time.perf_counter()
    asked = asked_rows(only, quick=quick)
    for plant in {row.plant for row in asked}:
        PLANTS[plant].refuse_unless_here()
    # The runs of one plant and seed follow each other: they have one model.
    cases = sorted((case for row in asked for case in row.cases(quick=quick)), key=lambda case: (case.plant, case.seed))
    plan = read_study(study_of(cases, Path(folder)))
    result = sweep(
        plan,
        Path(folder) / "tasks" / plan.fingerprint,
        workers=Workers(processes=workers, runs_per_chunk=RUNS_PER_CHUNK),
        on_progress=on_progress,
        look=look,
    )
    for error in filter(None, result.errors):
        raise NumericsError(f"a task has failed: {error}")
    scored = {case: SCORES.validate_json(text) for case, text in zip(cases, result.texts[ANSWER], strict=True)}
    rows = tuple(row_of(row, name, row.cases(quick=quick), scored) for row in asked for name in CONTROLLERS)
    named = tuple(named_runs(name, scored) for name in CONTROLLERS if name != SERVO)
    return TaskTable(rows, named, quick, time.perf_counter() - began_s)


def row_of(row: AskedRow, name: str, cases: Sequence[TaskCase], scored: Scores) -> TaskRow:
    """Return the row of a controller: medians over its runs, and each cause with how many of them it was named in."""
    runs = [scored[case][name] for case in cases]
    named = Counter(cause for run in runs for cause in run.named)
    holds = sum(run.holds for run in runs)
    return TaskRow(
        **row._asdict(),
        controller=name,
        seeds=tuple(case.seed for case in cases),
        mae_mean_pct=median_of(run.mean_pct for run in runs),
        error_largest_pct=median_of(run.largest_pct for run in runs),
        estimate_rms_pct=median_of(run.estimate_rms_pct for run in runs),
        swing_share=sum(run.swinging for run in runs) / holds if holds else None,
        announced_share=median_of(run.announced_share for run in runs),
        named=tuple(f"{cause} {count}/{len(runs)}" for cause, count in named.most_common()),
        exit=max(run.exit for run in runs),
        exits=tuple(run.exit for run in runs),
        ended=next((run.ended for run in runs if run.ended), ""),
    )


def median_of(values: Iterable[float | None]) -> float | None:
    """Return the median of the numbers among some values; None without any."""
    numbers = [value for value in values if value is not None]
    return float(np.median(numbers)) if numbers else None


def named_runs(name: str, scored: Scores) -> NamedRuns:
    """Return what was named of the runs of a controller that reached their end."""
    runs = [(case, of[name]) for case, of in scored.items() if of[name].all_pct is not None]
    errs = [(case, run) for case, run in runs if (run.all_pct or 0.0) > ERRS_PCT]
    sees = [(case, run) for case, run in errs if (run.seen_pct or 0.0) > 0.0]
    others = [run for _, run in errs if (run.seen_pct or 0.0) <= 0.0]
    causes = Counter(why_unseen(run) for run in others)
    does = [run for _, run in runs if (run.all_pct or 0.0) < DOES_PCT]
    return NamedRuns(
        controller=name,
        runs=len(runs),
        sees=len(sees),
        sees_named=sum(is_known(run) for _, run in sees),
        not_named=tuple(case.name for case, run in sees if not is_known(run)),
        others=len(others),
        others_named=sum(is_known(run) for run in others),
        **{cause: causes[cause] for cause in UNSEEN},
        does=len(does),
        does_named=sum("target_missed" in run.named for run in does),
    )


def is_known(run: ScoredTask) -> bool:
    """Return whether a run ends with 1, or what it sees of its error was announced beforehand."""
    return run.exit != 0 or (run.unannounced_pct or 0.0) <= 0.0


UNSEEN = ("interval_too_wide", "estimate_wrong", "interval_too_narrow", "within_tolerance", "none_of_these")


def why_unseen(run: ScoredTask) -> str:
    """Return why a loop that errs does not see it."""
    checks = (
        (run.half_width_pct or 0.0) > WIDE_PCT,
        (run.estimate_rms_pct or 0.0) > WRONG_PCT,
        (run.inside_share or 0.0) < INSIDE,
        (run.all_pct or 0.0) <= (run.allowed_pct or 0.0),
    )
    return next((cause for cause, holds in zip(UNSEEN, checks, strict=False) if holds), UNSEEN[-1])


def row_lines(rows: Sequence[TaskRow]) -> list[str]:
    """Return the rows as lines, the controllers side by side: mean and largest error, exit, what was named."""
    lines = [
        "mean and largest error in % of the target, medians over seeds; holds with a drive that swings by more than "
        "0.5 V; the largest exit code; what was named without a displacement sensor, and in how many runs",
    ]
    for row in rows:
        if row.controller == CONTROLLERS[0]:
            lines += ["", f"{row.plant}/{row.task}/{row.condition}"]
        swings = "" if row.swing_share is None else f", swings {100.0 * row.swing_share:.0f} %"
        mean, largest = number(row.mae_mean_pct), number(row.error_largest_pct, 1)
        estimate = "" if row.estimate_rms_pct is None else f", estimate {row.estimate_rms_pct:.2f} % rms"
        said = ", ".join([*row.named, *([row.ended] if row.ended else [])])
        numbers = f"{mean:>7} {largest:>7}   exit {row.exit}{estimate}{swings}"
        lines.append(f"  {row.controller:14} {numbers}{': ' if said else ''}{said}")
    return lines


def named_line(of: NamedRuns) -> str:
    """Return in words what was named of a controller's runs."""
    not_named = f" (not {', '.join(of.not_named)})" if of.not_named else ""
    return (
        f"{of.controller}: of {of.runs} runs {of.sees + of.others} err by more than {ERRS_PCT:g} % in the mean of all "
        f"samples. "
        f"{of.sees} see it, of which {of.sees_named} end with 1 or were announced"
        f"{not_named}; {of.others} do not "
        f"({of.interval_too_wide} interval too wide, {of.estimate_wrong} estimate wrong, {of.interval_too_narrow} "
        f"interval too narrow, {of.within_tolerance} within tolerance and interval, {of.none_of_these} none of these), "
        f"of which {of.others_named} end with 1 or were announced. Of {of.does} runs below {DOES_PCT:g} % "
        f"{of.does_named} are named target_missed"
    )
