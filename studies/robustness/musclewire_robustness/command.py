"""The command that compares estimators under disturbance, and controllers at tasks: robustness."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from musclewire.app import (
    LIST,
    QUICK,
    WORKERS,
    FigureOptions,
    Result,
    option,
    own_help,
    run_bar,
    stop_if_asked,
    stops_between_samples,
)
from musclewire.errors import CallerError
from musclewire.extras.studies import resumable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from musclewire_robustness.answers import RobustnessAnswer
    from musclewire_robustness.benchmark import Robustness, Selection

TUNING = option("--tuning", help="The wires that are for tuning, and not those whose figures are reported.")
# A seed, or two with all between them; none has more than six digits.
RANGE = re.compile(r"\s*(\d{1,6})(?:-(\d{1,6}))?\s*")
WIRES = option("--wires", help="Seeds of the wires, as '107-112' or '101, 107-109'.", metavar="SEEDS")
CONDITION = option("--condition", help="A condition by name; --list shows them. Repeatable.", metavar="NAME")
TRACK = option(
    "--track", help="A reference that the wire follows, by name; --list shows them. Repeatable.", metavar="NAME"
)
ESTIMATORS = option("--estimators", help="An estimator to compare, by name. Repeatable.", metavar="NAME")
TASKS = option(
    "--tasks", help="Tasks on many plants instead: the default loop, the fuzzy PID and a PI on a sensor, side by side."
)
ONLY = option("--only", help="Only rows of --tasks with this in their name.", metavar="ROW")


@dataclass(frozen=True)
class WhatIsRun:
    """Which wires, conditions, references and estimators are run."""

    quick: Annotated[bool, QUICK] = False
    tuning: Annotated[bool, TUNING] = False
    wires: Annotated[str | None, WIRES] = None
    condition: Annotated[list[str] | None, CONDITION] = None
    track: Annotated[list[str] | None, TRACK] = None
    estimators: Annotated[list[str] | None, ESTIMATORS] = None

    def refuse_all_but_quick(self) -> None:
        """Raise CallerError for a choice that the tasks do not have."""
        given = [f"--{one.name}" for one in fields(self) if one.name != "quick" and getattr(self, one.name)]
        if given:
            raise CallerError(f"--tasks has rows of its own, which --only chooses: leave out {', '.join(given)}")

    def selection(self) -> Selection:
        """Return what is run. Raises CallerError for wires that are no seeds, and for two choices of them."""
        if self.tuning and self.wires is not None:
            raise CallerError("--tuning chooses the wires: leave it or --wires out")
        from musclewire_robustness.benchmark import Selection
        from musclewire_robustness.population import tuning_seeds

        def chosen(names: list[str] | None) -> tuple[str, ...] | None:
            return None if names is None else tuple(names)

        return Selection(
            seeds=tuning_seeds() if self.tuning else chosen_seeds(self.wires),
            conditions=chosen(self.condition),
            references=chosen(self.track),
            estimators=chosen(self.estimators),
            quick=self.quick,
        )


def done_tasks(only: Sequence[str], folder: Path, workers: int | None, *, quick: bool) -> Result:
    """Run the tasks and write their rows into the folder."""
    from musclewire.signals import write_text_whole
    from musclewire_robustness.answers import TasksAnswer
    from musclewire_robustness.task_table import task_table

    with resumable(folder), stops_between_samples(), run_bar("runs") as on_progress:
        table = task_table(
            only, quick=quick, folder=folder, workers=workers, on_progress=on_progress, look=stop_if_asked
        )
    answer = TasksAnswer.read_from(table)
    text = json.dumps(answer.model_dump(mode="json"), indent=1, allow_nan=False)
    write_text_whole(folder / "tasks.json", text + "\n")
    return Result(answer, f"{table}\n{table.wall_s:.0f} s; {folder / 'tasks.json'}")


def chosen_seeds(text: str | None) -> tuple[int, ...] | None:
    """Return seeds in a text, as "101, 107-109"; None without one. Raises CallerError for what is none."""
    if text is None:
        return None
    seeds: list[int] = []
    for part in text.split(","):
        seen = RANGE.fullmatch(part)
        if seen is None:
            raise CallerError(f"--wires {text}: give seeds such as '107-112' or '101, 107-109'")
        first, last = int(seen[1]), int(seen[2] or seen[1])
        if last < first:
            raise CallerError(f"--wires {text}: {last} is before {first}: write the smaller one first")
        seeds += range(first, last + 1)
    return tuple(dict.fromkeys(seeds))


def robustness(
    what: WhatIsRun,
    figure: FigureOptions,
    output: Annotated[
        Path | None, own_help("--output", "Folder of the runs and their report; by default 'robustness'.")
    ] = None,
    workers: Annotated[int | None, WORKERS] = None,
    tasks: Annotated[bool, TASKS] = False,
    only: Annotated[str | None, ONLY] = None,
    list_all: Annotated[bool, LIST] = False,
) -> Result:
    """Compare estimators on a population of simulated wires under disturbance, or controllers at tasks.

    The output is a folder, "robustness" by default, with a page, the rows as CSV and JSON, and all runs: the same
    command continues a run that was interrupted. It ends with 1 if a bar of the default estimator is missed
    that is not on the committed list of known misses.
    """
    from musclewire_robustness.benchmark import robustness as run_robustness
    from musclewire_robustness.store import FOLDER
    from musclewire_robustness.table_text import table_text

    if list_all:
        return known_names()
    folder = output or FOLDER
    if tasks:
        what.refuse_all_but_quick()
        return done_tasks((only,) if only else (), folder, workers, quick=what.quick)
    if only:
        raise CallerError("--only chooses rows of --tasks: give both")
    figure.check()
    with resumable(folder), stops_between_samples(), run_bar("parts") as on_progress:
        result = run_robustness(
            what.selection(), folder=folder, workers=workers, on_progress=on_progress, look=stop_if_asked
        )
    answer = written(result, folder)
    figure.draw(partial(drawn, result))
    text = f"{table_text(result)}\n{result.wall_s:.0f} s; open {answer.report}"
    return Result(answer, text, holds=not result.new_misses)


def drawn(result: Robustness, *, style: str) -> Figure:
    """Return the heat map of errors; loads what draws only now."""
    from musclewire_robustness.report_page import error_figure

    return error_figure(result, style=style)


def written(result: Robustness, folder: Path) -> RobustnessAnswer:
    """Write rows and page into the folder; return the answer."""
    from musclewire.signals import write_text_whole
    from musclewire_robustness.answers import RobustnessAnswer
    from musclewire_robustness.report_page import write_report
    from musclewire_robustness.table_text import csv_text, rows_answer

    page = folder / "report.html"
    answer = RobustnessAnswer.read_from(
        result,
        rows=rows_answer(result),
        bars=result.verdicts,
        missed=[verdict.full_name for verdict in result.missed],
        new_misses=[verdict.full_name for verdict in result.new_misses],
        repaired=[verdict.full_name for verdict in result.repaired],
        seeds_are=result.seeds_text,
        report=str(page),
    )
    write_report(result, page)
    write_text_whole(folder / "rows.csv", csv_text(result))
    rows = answer.model_dump(mode="json", exclude={"report"})
    write_text_whole(folder / "rows.json", json.dumps(rows, indent=2, allow_nan=False) + "\n")
    return answer


def known_names() -> Result:
    """Return the names of conditions, references and estimators."""
    from musclewire import sensing
    from musclewire_robustness.answers import RobustnessNames
    from musclewire_robustness.references import REFERENCES
    from musclewire_robustness.settings import settings

    known = RobustnessNames(
        conditions=tuple(item.name for item in settings().condition),
        tracks=tuple(REFERENCES),
        estimators=tuple(sensing.ESTIMATORS.names()),
    )
    return Result(known, "\n".join(f"{kind}: {', '.join(names)}" for kind, names in known))
