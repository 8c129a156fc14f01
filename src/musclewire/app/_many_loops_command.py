"""The closed loop for many seeds at once: what ``control --runs`` does."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from musclewire.app._options import IN_PYTHON, RUNS, THREADS
from musclewire.app._output import emit_json, progress_bar, say, show, warn
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.controllers import Reference
    from musclewire.experiment import ControlMetrics, LoopOutcome, ManyControlRuns

__all__ = ["MIN_VALID_FRACTION", "ManyLoopsChoice", "refuse_single_run_options", "run_many_loops"]


# A closed loop with a smaller fraction of valid estimates was not closed.
MIN_VALID_FRACTION = 0.8


@dataclass(frozen=True)
class ManyLoopsChoice:
    """How many loops run at once, and how."""

    runs: Annotated[int | None, RUNS] = None
    in_python: Annotated[bool, IN_PYTHON] = False
    threads: Annotated[int | None, THREADS] = None


def refuse_single_run_options(many: ManyLoopsChoice, single: dict[str, bool]) -> None:
    """Raise CallerError for options of one run together with --runs, and for those of many runs without it.

    ``single`` holds which options of one run were given, by name.
    """
    if many.runs is None:
        given = [name for name, on in (("--in-python", many.in_python), ("--threads", many.threads)) if on]
        if given:
            raise CallerError(f"{given[0]} belongs to --runs: give the number of loops, or leave it out")
    elif any(single.values()):
        name = next(name for name, on in single.items() if on)
        raise CallerError(f"{name} belongs to a single run: leave it out, or --runs")


def run_many_loops(
    rig: str, seed: int | None, many: ManyLoopsChoice, loop: dict[str, Any], target: Reference, json: bool
) -> None:
    """Run the loops and show their errors; exit code 1 if an error ended one of them."""
    from musclewire.experiment import approach_of, control_many

    assert many.runs is not None
    first = 1 if seed is None else seed
    duration_s, done = approach_of(loop["controller"]) + target.duration_s, 0
    with progress_bar("Closed loops", many.runs * duration_s, quiet=json) as advance:

        def on_outcome(_: LoopOutcome) -> None:
            nonlocal done
            done += 1
            advance({"time_s": done * duration_s})

        found = control_many(
            rig,
            reference=target,
            seeds=range(first, first + many.runs),
            threads=many.threads,
            in_python=many.in_python,
            on_outcome=on_outcome,
            **loop,
        )
    warn(found.warnings)
    if json:
        emit_json(many_json(found))
    else:
        show(str(found))
    unsensed = sum(metrics.valid_share < MIN_VALID_FRACTION for metrics in found.metrics)
    if unsensed:
        say(f"musclewire: {unsensed} loops could sense less than {100 * MIN_VALID_FRACTION:.0f} % of their samples")
    if found.failed or unsensed:
        raise typer.Exit(1)


def many_json(found: ManyControlRuns) -> dict[str, Any]:
    """Return many closed loops under the keys of the interface."""
    first = next(iter(found.metrics), None)
    return {
        "approach_s": None if first is None else first.approach_s,
        "approach": None if first is None else first.approach,
        "steps": [{name: or_none(value) for name, value in step._asdict().items()} for step in found.steps],
        "runs": [
            {
                "seed": outcome.seed,
                "ended": outcome.ended,
                "compiled": outcome.compiled,
                **errors_json(outcome.metrics),
                "warnings": outcome.warnings,
            }
            for outcome in found.outcomes
        ],
    }


ERRORS = (
    "mae_max_pct",
    "mae_mean_pct",
    "mae_max_approached_pct",
    "mae_mean_approached_pct",
    "rms_pct",
    "valid_share",
)


def errors_json(metrics: ControlMetrics | None) -> dict[str, Any]:
    """Return the errors of one of the loops under the keys of the interface; None for each without metrics."""
    if metrics is None:
        return dict.fromkeys(("mae_pct", "mae_approached_pct", *ERRORS))
    return {
        "mae_pct": [step.mae_pct for step in metrics.steps],
        "mae_approached_pct": [step.mae_approached_pct for step in metrics.steps],
        **{name: getattr(metrics, name) for name in ERRORS},
    }


def or_none(value: float | str) -> float | str | None:
    """Return a value for JSON, which has no word for what is not a number."""
    return None if isinstance(value, float) and math.isnan(value) else value
