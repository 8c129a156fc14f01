"""The command that runs a study of many wires: sweep."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app import (
    LIST,
    OUTPUT,
    OVERWRITE,
    WORKERS,
    FigureOptions,
    Json,
    emit_json,
    run_bar,
    show,
    stop_if_asked,
    stops_between_samples,
    warn,
)
from musclewire.errors import CallerError
from musclewire.extras.studies._options import PLAN, RETRIES, RUNS_PER_CHUNK, SCHEDULER, resumable

if TYPE_CHECKING:
    from musclewire.extras.studies._plan import Plan
    from musclewire.extras.studies._study import StudyResult, Workers


@dataclass(frozen=True)
class WorkerOptions:
    """Where a study is evaluated."""

    scheduler: Annotated[str | None, SCHEDULER] = None
    workers: Annotated[int | None, WORKERS] = None
    runs_per_chunk: Annotated[int | None, RUNS_PER_CHUNK] = None
    retries: Annotated[int, RETRIES] = 5

    def chosen(self) -> Workers:
        """Return where it is evaluated. Raises CallerError for processes of this machine together with a cluster."""
        from musclewire.extras.studies._study import Workers

        if self.scheduler is not None and self.workers is not None:
            raise CallerError("--workers counts processes of this machine, and --scheduler has workers of its own: "
                              "leave one out")  # fmt: skip
        return Workers(self.scheduler, self.workers, self.runs_per_chunk, self.retries)


def sweep(
    where: WorkerOptions,
    figure: FigureOptions,
    study: Annotated[Path | None, typer.Argument(metavar="STUDY", help="Study file (.toml).")] = None,
    output: Annotated[Path | None, OUTPUT] = None,
    plan_only: Annotated[bool, PLAN] = False,
    list_all: Annotated[bool, LIST] = False,
    overwrite: Annotated[bool, OVERWRITE] = False,
    json: Json = False,
) -> None:
    """Run a study of many wires: on all cores, or on a Dask cluster.

    The output is a folder, by default named like the study file. The same command continues a study that was
    interrupted.
    """
    from musclewire.extras.studies._study import read_study

    if list_all:
        show_known(json)
        return
    if study is None:
        raise CallerError("give a study file (.toml); --list shows what can be run, kept and varied")
    figure.check()
    plan = read_study(study)
    if plan_only:
        show_plan(plan, json)
        return
    run_study(plan, where.chosen(), output or Path(study.stem), figure, overwrite=overwrite, json=json)


def run_study(
    plan: Plan, workers: Workers, folder: Path, figure: FigureOptions, *, overwrite: bool, json: bool
) -> None:
    """Run a study and write what it leaves."""
    from musclewire.extras.studies._study import sweep as run_sweep
    from musclewire.extras.studies._study_figures import distributions
    from musclewire.extras.studies._study_page import require_packages, write_study

    require_packages()
    started = time.perf_counter()
    with resumable(folder), stops_between_samples(), run_bar("runs", json) as on_progress:
        result = run_sweep(
            plan, folder, workers=workers, overwrite=overwrite, on_progress=on_progress, look=stop_if_asked
        )
    files = write_study(result, folder)
    if result.failed < len(result):
        figure.draw(partial(distributions, result))
    if json:
        emit_json({**document(result), "wall_s": time.perf_counter() - started, "files": [str(file) for file in files]})
    else:
        show(result_text(result))
        show(f"{time.perf_counter() - started:.1f} s; open {files[-1]}")
    if result.failed:
        first = next(text for text in result.errors if text)
        warn([f"{result.failed} of {len(result)} runs failed; the first: {first}"])
    if result.failed == len(result):
        raise typer.Exit(1)


def show_plan(plan: Plan, json: bool) -> None:
    """Print what a study would run."""
    design = plan.design
    parameters = {
        name: {"unit": design.units[name], "from": plain(column.min()), "to": plain(column.max())}
        for name, column in ((name, design.column(name)) for name in design.names)
    }
    if json:
        emit_json(
            {"runs": len(design), "kind": plan.file.run["kind"], "keep": list(plan.keep), "parameters": parameters}
        )
        return
    show(f"{plan.file.name}: {len(design)} runs of '{plan.file.run['kind']}', {plan.kind.runs_per_chunk} in a chunk")
    for name, ends in parameters.items():
        show(f"  {name}: {ends['from']} to {ends['to']} {ends['unit']}".rstrip())
    show(f"kept: {', '.join(plan.keep)}")


def plain(value: Any) -> Any:
    """Return an end of a range as JSON knows it."""
    return value.item() if hasattr(value, "item") else value


def show_known(json: bool) -> None:
    """Print which kinds of runs there are, and what may vary on the simulated rig."""
    from musclewire.extras.studies._run_kind import RUN_KINDS
    from musclewire.rigs import RigConfiguration, keys_of

    kinds = {name: list(RUN_KINDS.find(name).options.model_fields) for name in RUN_KINDS.names()}
    keys = {name: key.unit for name, key in keys_of(RigConfiguration()).items()}
    if json:
        emit_json({"kinds": kinds, "parameters": keys})
        return
    for name, options in kinds.items():
        show(f'kind = "{name}": {", ".join(options)}')
    show("\nwhat may vary, besides run.KEY and, with [[load]] parts, load.PART.KEY:")
    for name, unit in keys.items():
        show(f"  {name} [{unit}]" if unit not in ("", "1") else f"  {name}")


def document(result: StudyResult) -> dict[str, Any]:
    """Return the numbers of a study under the keys of the interface."""
    return {
        "runs": len(result),
        "evaluated": result.evaluated,
        "failed": result.failed,
        "fingerprint": result.plan.fingerprint,
        "quantities": {name: spread(column) for name, column in result.columns.items() if column.ndim == 1},
    }


def spread(column: Any) -> dict[str, float | None]:
    """Return least, median and largest value of a quantity; None if every run failed."""
    import numpy as np

    finite = column[np.isfinite(column)]
    found = (finite.min(), np.median(finite), finite.max()) if finite.size else (None, None, None)
    return dict(zip(("least", "median", "largest"), map(plain, found), strict=True))


def result_text(result: StudyResult) -> str:
    """Return the numbers of a study as lines."""
    lines = [f"{len(result)} runs, {result.evaluated} of them evaluated now"]
    for name, ends in document(result)["quantities"].items():
        unit = result.plan.keep[name].unit
        unit = "" if unit == "1" else unit
        if ends["least"] is not None:
            shown = f"{ends['least']:.5g} to {ends['largest']:.5g}, median {ends['median']:.5g} {unit}"
            lines.append(f"{name}: {shown}".rstrip())
    return "\n".join(lines)
