"""The numbers of the controller ``inverse-model``: what each of them moves, and what it comes to beside other loops.

Tasks of ``musclewire robustness --tasks`` on drawn wires, on rigs that ship, and on plants that are not ours, in still
and in changed air; each loop senses by the filter. Choose on seeds below 700, report on those from 741 on.

    python studies/controller_numbers.py table --seeds 741-743     beside the paper's fuzzy PID
    python studies/controller_numbers.py moves --seeds 1-3         each number halved and doubled

A line a row: medians over the seeds of mean and largest error in percent of the target, the error of the estimate in
percent of what the model senses, and the part of the holds that swing by more than half a volt; at the end the
geometric mean of all rows' mean errors. Models are kept in a folder, so that a second table takes minutes.
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

from musclewire_robustness.command import chosen_seeds
from musclewire_robustness.task_plants import PLANTS, changed
from musclewire_robustness.task_runs import CHANGE_AT_S, ScoredTask, TaskCase, loop_score, not_done
from musclewire_robustness.tasks import CHANGES, STILL, TASKS

from musclewire import control
from musclewire.controllers import INVERSE_MODEL, InverseModelController, InverseModelNumbers
from musclewire.errors import CallerError, MusclewireError
from musclewire.experiment import control_compiled
from musclewire.identify import gains_of
from musclewire.rigs import SimulatedDevice

FOLDER = Path("controller_runs")
# Two wires have no compiled loop, and take minutes.
ON = tuple(name for name in PLANTS if name != "gripper")
ROWS = (
    *((task, STILL) for task in ("staircase", "random steps", "small steps", "sine 10 s", "sine 60 s", "hold 10 min")),
    *(("random steps", change) for change in ("draughts", "twice the heat loss", "supply 15 % low")),
)
FACTORS = (0.5, 2.0)
Percent = float | None


class Loop(NamedTuple):
    """What controls, and what it senses by."""

    controller: Any
    estimator: str


def by_numbers(numbers: InverseModelNumbers) -> Loop:
    """Return the loop with these numbers."""
    return Loop(lambda setup: InverseModelController(setup, numbers), "filter")


LOOPS = {
    "inverse-model": Loop("inverse-model", "filter"),
    "fuzzy-pid": Loop("fuzzy-pid", "filter"),
}


def scored(case: TaskCase, loop: Loop) -> ScoredTask:
    """Return what a loop comes to in a case."""
    plant = PLANTS[case.plant]
    try:
        model = plant.model_in(FOLDER / f"{case.plant}-{case.seed}.json", case.seed)
        with plant.opened(case.seed, of_task=True) as rig:
            changed(rig, CHANGES[case.condition], CHANGE_AT_S, case.seed)
            gains = gains_of(model, rig.sample_period_s)
            compiled = isinstance(rig.device, SimulatedDevice) and not CHANGES[case.condition].of_the_supply
            run = (control_compiled if compiled else control)(
                rig,
                model,
                TASKS[case.task].reference(model, case.seed),
                estimator=loop.estimator,
                controller=loop.controller,
                settings=gains.settings if gains and callable(loop.controller) else None,
            )
        return loop_score(run, model, case)
    except MusclewireError as error:
        return not_done(" ".join(str(error).split()), 3)


def middle(values: Sequence[Percent]) -> float:
    """Return the median of what is there; NaN of nothing."""
    there = [one for one in values if one is not None]
    return statistics.median(there) if there else float("nan")


def row_line(name: str, by_loop: Mapping[str, Sequence[ScoredTask]]) -> str:
    """Return a row of the table."""
    parts = []
    for scores in by_loop.values():
        holds = sum(one.holds for one in scores)
        swings = f"{100.0 * sum(one.swinging for one in scores) / holds:3.0f} %" if holds else "    -"
        ended = sum(bool(one.ended) for one in scores)
        parts.append(
            f"{middle([one.mean_pct for one in scores]):6.2f} {middle([one.largest_pct for one in scores]):6.1f} "
            f"{middle([one.estimate_rms_pct for one in scores]):5.2f} {swings}{f' {ended} ended' if ended else ''}"
        )
    return f"{name:46s} {'  |  '.join(parts)}"


def print_table(loops: Mapping[str, Loop], plants: Sequence[str], seeds: Sequence[int]) -> None:
    """Run all rows, print each when it is done, and the geometric means."""
    print(f"{'mean, largest, estimate, swings':46s} {'  |  '.join(f'{name:25s}' for name in loops)}")
    means: dict[str, list[float]] = {name: [] for name in loops}
    with ThreadPoolExecutor() as pool:
        for plant, (task, condition) in itertools.product(plants, ROWS):
            cases = [TaskCase(plant, task, condition, seed) for seed in seeds]
            scored(cases[0], next(iter(loops.values())))  # the plant's module and models before its threads
            found = {
                name: list(pool.map(lambda case, loop=loop: scored(case, loop), cases)) for name, loop in loops.items()
            }
            print(row_line(cases[0].row, found), flush=True)
            for name, scores in found.items():
                means[name].append(middle([one.mean_pct for one in scores]))
    for name, values in means.items():
        there = [one for one in values if one > 0.0]  # not a row whose loops all ended early: it says so itself
        print(
            f"{name:26s} {statistics.geometric_mean(there):.3f} % in the geometric mean of {len(there)} of "
            f"{len(values)} rows"
        )


def moved() -> dict[str, Loop]:
    """Return the loop as it is, and with each number halved and doubled."""
    loops = {"as it is": by_numbers(INVERSE_MODEL)}
    for name, factor in itertools.product(InverseModelNumbers._fields, FACTORS):
        loops[f"{name} x{factor:g}"] = by_numbers(
            INVERSE_MODEL._replace(**{name: factor * getattr(INVERSE_MODEL, name)})
        )
    return loops


def main() -> int:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description="Numbers of the controller inverse-model.")
    parser.add_argument("what", choices=["table", "moves"])
    parser.add_argument("--seeds", default="1-3")
    parser.add_argument("--plants", nargs="*", default=list(ON))
    given = parser.parse_args()
    try:
        for name in given.plants:
            PLANTS[name].refuse_unless_here()
        seeds = chosen_seeds(given.seeds)
    except CallerError as error:
        parser.error(str(error))
    loops: Callable[[], Mapping[str, Loop]] = (lambda: LOOPS) if given.what == "table" else moved
    print_table(loops(), given.plants, seeds)
    return 0


if __name__ == "__main__":
    sys.exit(main())
