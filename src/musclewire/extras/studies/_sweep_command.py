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
    OVERWRITE,
    WORKERS,
    FigureOptions,
    Result,
    own_help,
    run_bar,
    stop_if_asked,
    stops_between_samples,
    warn,
)
from musclewire.errors import CallerError, require_extra
from musclewire.extras.studies._options import PLAN, RETRIES, RUNS_PER_CHUNK, SCHEDULER, resumable

if TYPE_CHECKING:
    from musclewire.extras.studies._answers import QuantitySpread, SweepAnswer
    from musclewire.extras.studies._plan import Plan
    from musclewire.extras.studies._study import StudyResult, Workers

ZERO_CELSIUS_K = 273.15
# As many runs are named in a line; all are in the answer and in the data set.
SHOWN = 5


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
    output: Annotated[
        Path | None, own_help("--output", "Folder of the runs and their report; by default named like the study file.")
    ] = None,
    plan_only: Annotated[bool, PLAN] = False,
    list_all: Annotated[bool, LIST] = False,
    overwrite: Annotated[bool, OVERWRITE] = False,
) -> Result:
    """Run a study of many wires: on all cores, or on a Dask cluster.

    The output is a folder, by default named like the study file. The same command continues a study that was
    interrupted.
    """
    if list_all:
        return known_kinds()
    if study is None:
        raise CallerError("give a study file (.toml); --list shows what can be run, kept and varied")
    if not plan_only:
        require_extra("a study with data set and sensitivity table", "sweep")
    from musclewire.extras.studies._study import read_study

    figure.check()
    plan = read_study(study)
    if plan_only:
        return planned(plan)
    return run_study(plan, where.chosen(), output or Path(study.stem), figure, overwrite=overwrite)


def run_study(plan: Plan, workers: Workers, folder: Path, figure: FigureOptions, *, overwrite: bool) -> Result:
    """Run a study and write what it leaves."""
    from musclewire.extras.studies._answers import OverheatedRun, SweepAnswer
    from musclewire.extras.studies._study import sweep as run_sweep
    from musclewire.extras.studies._study_page import distributions, write_study

    started = time.perf_counter()
    with resumable(folder), stops_between_samples(), run_bar("runs") as on_progress:
        result = run_sweep(
            plan, folder, workers=workers, overwrite=overwrite, on_progress=on_progress, look=stop_if_asked
        )
    files = write_study(result, folder)
    if result.failed < len(result):
        figure.draw(partial(distributions, result))
    if result.failed:
        first = next(text for text in result.errors if text)
        warn([f"{result.failed} of {len(result)} runs failed; the first: {first}"])
    if result.overheated:
        warn([too_hot(result)])
    answer = SweepAnswer.read_from(
        result,
        plan,
        runs=len(result),
        quantities={name: spread(column) for name, column in result.columns.items() if column.ndim == 1},
        overheated=tuple(OverheatedRun(**one._asdict()) for one in result.overheated),
        wall_s=time.perf_counter() - started,
        files=[str(file) for file in files],
    )
    text = f"{result_text(answer, plan)}\n{answer.wall_s:.1f} s; open {files[-1]}"
    return Result(answer, text, holds=result.failed < len(result) and not result.overheated)


def too_hot(result: StudyResult) -> str:
    """Return which runs went beyond their limits, the hottest first, and what to give."""
    hottest = sorted(result.overheated, key=lambda one: one.limit_k - one.temperature_max_k)
    shown = [
        f"run {one.run} ({one.temperature_max_k - ZERO_CELSIUS_K:.0f} C, limit {one.limit_k - ZERO_CELSIUS_K:.0f} C)"
        for one in hottest[:SHOWN]
    ]
    more = f" and {len(hottest) - SHOWN} more" if len(hottest) > SHOWN else ""
    return (
        f"{len(hottest)} of {len(result)} wires went beyond their limit of temperature: {', '.join(shown)}{more}; "
        "a real wire is damaged there: leave the amplitude to each wire (no drive_amplitude, no run.amplitude), or "
        "give less"
    )


def planned(plan: Plan) -> Result:
    """Return what a study would run."""
    from musclewire.extras.studies._answers import PlannedSweep, VariedRange

    design = plan.design
    parameters = {
        name: VariedRange(unit=design.units[name], least=plain(column.min()), most=plain(column.max()))
        for name, column in ((name, design.column(name)) for name in design.names)
    }
    answer = PlannedSweep(runs=len(design), kind=plan.file.run["kind"], keep=tuple(plan.keep), parameters=parameters)
    lines = [f"{plan.file.name}: {answer.runs} runs of '{answer.kind}', {plan.kind.runs_per_chunk} in a chunk"]
    lines += [f"  {name}: {ends.least} to {ends.most} {ends.unit}".rstrip() for name, ends in parameters.items()]
    return Result(answer, "\n".join([*lines, f"kept: {', '.join(plan.keep)}"]))


def plain(value: Any) -> Any:
    """Return an end of a range as JSON knows it."""
    return value.item() if hasattr(value, "item") else value


def known_kinds() -> Result:
    """Return which kinds of runs there are, and what may vary on the simulated rig."""
    from musclewire.extras.studies._answers import SweepKinds
    from musclewire.extras.studies._run_kind import RUN_KINDS
    from musclewire.extras.studies._varied_rig import keys_of
    from musclewire.rigs import RigConfiguration

    kinds = {name: tuple(RUN_KINDS.find(name).options.model_fields) for name in RUN_KINDS.names()}
    keys = {name: key.unit for name, key in keys_of(RigConfiguration()).items()}
    lines = [f'kind = "{name}": {", ".join(options)}' for name, options in kinds.items()]
    lines += ["", "what may vary, besides run.KEY and, with [[load]] parts, load.PART.KEY:"]
    lines += [f"  {name} [{unit}]" if unit not in ("", "1") else f"  {name}" for name, unit in keys.items()]
    return Result(SweepKinds(kinds=kinds, parameters=keys), "\n".join(lines))


def spread(column: Any) -> QuantitySpread:
    """Return least, median and largest value of a quantity; None if every run failed."""
    import numpy as np

    from musclewire.extras.studies._answers import QuantitySpread

    finite = column[np.isfinite(column)]
    found = (finite.min(), np.median(finite), finite.max()) if finite.size else (None, None, None)
    return QuantitySpread(**dict(zip(("least", "median", "largest"), found, strict=True)))


def result_text(answer: SweepAnswer, plan: Plan) -> str:
    """Return the numbers of a study as lines."""
    lines = [f"{answer.runs} runs, {answer.evaluated} of them evaluated now"]
    if answer.overheated:
        numbers = ", ".join(str(one.run) for one in answer.overheated[:SHOWN])
        more = ", ..." if len(answer.overheated) > SHOWN else ""
        lines.append(f"{len(answer.overheated)} wires went beyond their limit of temperature: runs {numbers}{more}")
    for name, ends in answer.quantities.items():
        unit = plan.keep[name].unit
        if ends.least is not None:
            shown = f"{ends.least:.5g} to {ends.largest:.5g}, median {ends.median:.5g} {'' if unit == '1' else unit}"
            lines.append(f"{name}: {shown}".rstrip())
    return "\n".join(lines)
