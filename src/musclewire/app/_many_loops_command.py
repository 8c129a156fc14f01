"""The closed loop for many seeds at once: what ``control --runs`` does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from musclewire.app._options import IN_PYTHON, RUNS, THREADS
from musclewire.app._output import Result, progress_bar, say, warn
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.controllers import Reference
    from musclewire.experiment import ControlMetrics, LoopOutcome

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
    rig: str, seed: int | None, many: ManyLoopsChoice, loop: dict[str, Any], target: Reference
) -> Result:
    """Run the loops and return their errors, which do not hold if an error ended one of them."""
    from musclewire.app._answers import LoopRunAnswer, ManyLoopsAnswer
    from musclewire.experiment import approach_of, control_many

    assert many.runs is not None
    first = 1 if seed is None else seed
    duration_s, done = approach_of(loop["controller"]) + target.duration_s, 0
    with progress_bar("Closed loops", many.runs * duration_s) as advance:

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
    unsensed = sum(metrics.valid_share < MIN_VALID_FRACTION for metrics in found.metrics)
    if unsensed:
        say(f"musclewire: {unsensed} loops could sense less than {100 * MIN_VALID_FRACTION:.0f} % of their samples")
    ended = next(iter(found.metrics), None)
    answer = ManyLoopsAnswer.read_from(
        approach_s=None if ended is None else ended.approach_s,
        approach=None if ended is None else ended.approach,
        steps=found.steps,
        runs=[LoopRunAnswer.read_from(one, one.metrics, **step_errors(one.metrics)) for one in found.outcomes],
    )
    return Result(answer, str(found), holds=not (found.failed or unsensed))


def step_errors(metrics: ControlMetrics | None) -> dict[str, list[float | None]]:
    """Return the errors of each step of a loop in both readings; nothing without metrics."""
    names = () if metrics is None else ("mae_pct", "mae_approached_pct")
    return {name: [getattr(step, name) for step in metrics.steps] for name in names if metrics is not None}
