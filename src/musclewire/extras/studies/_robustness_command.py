"""The command that compares estimators and controllers under disturbance: robustness."""

from __future__ import annotations

import json as json_text
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app import (
    LIST,
    OUTPUT,
    QUICK,
    WORKERS,
    FigureOptions,
    Json,
    emit_json,
    run_bar,
    show,
    stop_if_asked,
    stops_between_samples,
)
from musclewire.extras.studies._options import CONDITION, CONTROLLERS, ESTIMATORS, TRACK, TUNING, resumable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from musclewire.extras.studies._robustness import Robustness, Selection


@dataclass(frozen=True)
class WhatIsRun:
    """Which wires, conditions, references, estimators and controllers are run."""

    quick: Annotated[bool, QUICK] = False
    tuning: Annotated[bool, TUNING] = False
    condition: Annotated[list[str] | None, CONDITION] = None
    track: Annotated[list[str] | None, TRACK] = None
    estimators: Annotated[list[str] | None, ESTIMATORS] = None
    controllers: Annotated[list[str] | None, CONTROLLERS] = None

    def selection(self) -> Selection:
        """Return what is run."""
        from musclewire.extras.studies._robustness import Selection, tuning_seeds

        def chosen(names: list[str] | None) -> tuple[str, ...] | None:
            return None if names is None else tuple(names)

        return Selection(
            seeds=tuning_seeds() if self.tuning else None,
            conditions=chosen(self.condition),
            references=chosen(self.track),
            estimators=chosen(self.estimators),
            controllers=() if self.controllers == ["none"] else chosen(self.controllers),
            quick=self.quick,
        )


def robustness(
    what: WhatIsRun,
    figure: FigureOptions,
    output: Annotated[Path | None, OUTPUT] = None,
    workers: Annotated[int | None, WORKERS] = None,
    list_all: Annotated[bool, LIST] = False,
    json: Json = False,
) -> None:
    """Compare estimators and controllers on a population of simulated wires under disturbance.

    The output is a folder, "robustness" by default, with a page, the rows as CSV and JSON, and all runs: the same
    command continues a run that was interrupted. It ends with 1 if a bar of the default estimator or loop is missed.
    """
    from musclewire.extras.studies._robustness import robustness as run_robustness
    from musclewire.extras.studies._robustness.store import FOLDER

    if list_all:
        show_known(json)
        return
    figure.check()
    folder = output or FOLDER
    with resumable(folder), stops_between_samples(), run_bar("parts", json) as on_progress:
        result = run_robustness(
            what.selection(), folder=folder, workers=workers, on_progress=on_progress, look=stop_if_asked
        )
    page = write_files(result, folder)
    figure.draw(partial(drawn, result))
    if json:
        from musclewire.extras.studies._robustness.table_text import document

        emit_json({**document(result), "report": str(page)})
    else:
        from musclewire.extras.studies._robustness.table_text import table_text

        show(table_text(result))
        show(f"{result.wall_s:.0f} s; open {page}")
    if result.missed:
        raise typer.Exit(1)


def drawn(result: Robustness, *, style: str) -> Figure:
    """Return the heat map of errors; loads what draws only now."""
    from musclewire.extras.studies._robustness.report_page import error_figure

    return error_figure(result, style=style)


def write_files(result: Robustness, folder: Path) -> Path:
    """Write rows and page into the folder; return the page."""
    from musclewire.extras.studies._robustness.report_page import write_report
    from musclewire.extras.studies._robustness.table_text import csv_text, document
    from musclewire.signals import write_text_whole

    page = folder / "report.html"
    write_report(result, page)
    write_text_whole(folder / "rows.csv", csv_text(result))
    write_text_whole(folder / "rows.json", json_text.dumps(document(result), indent=2, allow_nan=False) + "\n")
    return page


def show_known(json: bool) -> None:
    """Print the names of conditions, references, estimators and controllers."""
    from musclewire import controllers, sensing
    from musclewire.extras.studies._robustness.references import REFERENCES
    from musclewire.extras.studies._robustness.settings import settings

    known = {
        "conditions": [item.name for item in settings().condition],
        "tracks": list(REFERENCES),
        "estimators": list(sensing.ESTIMATORS.names()),
        "controllers": list(controllers.CONTROLLERS.names()),
    }
    if json:
        emit_json(known)
    else:
        show("\n".join(f"{kind}: {', '.join(names)}" for kind, names in known.items()))
