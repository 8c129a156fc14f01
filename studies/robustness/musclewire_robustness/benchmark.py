"""The benchmark: a population of wires, what disturbs them, every estimator, and the bars."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from musclewire import ESTIMATORS, CallerError, NumericsError
from musclewire.extras.studies import Workers, read_study, sweep
from musclewire_robustness.grips import GripRow, grip_rows
from musclewire_robustness.kind import ANSWER, JobAnswer, answer_of_text
from musclewire_robustness.population import held_out_seeds, tuning_seeds
from musclewire_robustness.references import REFERENCES, require_reference
from musclewire_robustness.rows import EstimatorRow, estimator_rows
from musclewire_robustness.settings import Condition, bars, known_misses, settings
from musclewire_robustness.store import FOLDER, sources
from musclewire_robustness.verdicts import BarVerdict, verdicts_of

OnProgress = Callable[[int, int], None]


@dataclass(frozen=True)
class Selection:
    """What is run; None stands for all.

    Parameters
    ----------
    seeds
        Seeds of the wires; those held out if None.
    conditions
        Names of the conditions.
    references
        Names of the references that are recorded for estimators.
    estimators
        Names of the estimators.
    quick
        Few wires and conditions, one reference: whatever is None is then a part of all.
    """

    seeds: tuple[int, ...] | None = None
    conditions: tuple[str, ...] | None = None
    references: tuple[str, ...] | None = None
    estimators: tuple[str, ...] | None = None
    quick: bool = False


class ChosenRuns(NamedTuple):
    """What a selection comes to: seeds, conditions, references and estimators."""

    seeds: tuple[int, ...]
    conditions: tuple[Condition, ...]
    references: tuple[str, ...]
    estimators: tuple[str, ...]


def chosen_by(selection: Selection) -> ChosenRuns:
    """Return what a selection comes to. Raises CallerError for an unknown name, suggesting the nearest."""
    quick = settings().quick
    seeds = settings().population.quick_seeds if selection.quick else held_out_seeds()
    conditions = settings().conditions(
        quick.conditions if selection.quick and selection.conditions is None else selection.conditions
    )
    references = quick.references if selection.quick and selection.references is None else selection.references
    for name in references or ():
        require_reference(name)
    for name in selection.estimators or ():
        ESTIMATORS.find(name)
    return ChosenRuns(
        seeds if selection.seeds is None else selection.seeds,
        conditions,
        tuple(REFERENCES) if references is None else references,
        tuple(ESTIMATORS.names()) if selection.estimators is None else selection.estimators,
    )


@dataclass(frozen=True)
class Robustness:
    """What the benchmark found.

    Parameters
    ----------
    seeds
        Seeds of the wires.
    conditions
        The conditions, in their order.
    references
        Names of the references.
    estimators
        Rows of estimators.
    verdicts
        The bars of the default, those that are known to be missed with their reasons.
    grips
        Rows of grips; none in a quick run, or in one of chosen conditions.
    answers
        What each wire gave under each condition.
    quick
        Whether it was a quick run.
    wall_s
        How long it took [s].
    """

    seeds: tuple[int, ...]
    conditions: tuple[Condition, ...]
    references: tuple[str, ...]
    estimators: tuple[EstimatorRow, ...]
    verdicts: tuple[BarVerdict, ...]
    grips: tuple[GripRow, ...]
    answers: tuple[JobAnswer, ...]
    quick: bool
    wall_s: float

    @property
    def missed(self) -> tuple[BarVerdict, ...]:
        """The bars that were missed."""
        return tuple(verdict for verdict in self.verdicts if not verdict.holds)

    @property
    def new_misses(self) -> tuple[BarVerdict, ...]:
        """Missed bars that the committed list does not have: the benchmark fails by these alone."""
        return tuple(verdict for verdict in self.missed if verdict.known_reason is None)

    @property
    def repaired(self) -> tuple[BarVerdict, ...]:
        """Bars of the committed list that hold."""
        return tuple(verdict for verdict in self.verdicts if verdict.holds and verdict.known_reason is not None)

    @property
    def seeds_text(self) -> str:
        """What the seeds are: held out, for tuning, or others."""
        kinds = {"held out": held_out_seeds(), "for tuning": tuning_seeds()}
        parts = [
            f"{text} {ranges([seed for seed in self.seeds if seed in known])}"
            for text, known in kinds.items()
            if any(seed in known for seed in self.seeds)
        ]
        others = [seed for seed in self.seeds if not any(seed in known for known in kinds.values())]
        return ", ".join([*parts, *([f"others {ranges(others)}"] if others else [])])


def study_of(chosen: ChosenRuns, folder: Path) -> dict[str, Any]:
    """Return the benchmark as a study: every condition on every wire."""
    return {
        "format": "musclewire-study",
        "version": 1,
        "name": "robustness",
        "run": {
            "kind": "robustness",
            "keep": [ANSWER],
            "references": list(chosen.references),
            "estimators": list(chosen.estimators),
            "folder": str(folder),
            "sources": sources(),
        },
        "parameters": {
            "run.wire": {"values": list(chosen.seeds)},
            "run.condition": {"values": [condition.name for condition in chosen.conditions]},
        },
    }


def ranges(seeds: Sequence[int]) -> str:
    """Return numbers as text, neighbours as a range: "1-3, 7"."""
    parts: list[list[int]] = []
    for seed in sorted(seeds):
        if parts and seed == parts[-1][-1] + 1:
            parts[-1].append(seed)
        else:
            parts.append([seed])
    return ", ".join(f"{part[0]}-{part[-1]}" if len(part) > 1 else str(part[0]) for part in parts)


def robustness(
    selection: Selection | None = None,
    *,
    folder: str | Path = FOLDER,
    workers: int | None = None,
    on_progress: OnProgress = lambda *_: None,
    look: Callable[[], None] = lambda: None,
) -> Robustness:
    """Run estimators on a population of simulated wires under disturbances.

    Every wire differs in structure from the models that an estimator has: other grains, several classes of barrier,
    and half of them in segments along their length. Each is characterized as its user would, from his own noisy
    recordings. What was computed is kept, and a run that was interrupted goes on from there.

    Parameters
    ----------
    selection
        What is run; all wires that are held out, all conditions, references and estimators if None.
    folder
        Folder for the recorded runs and answers.
    workers
        Processes; by default one on each core. With 1 everything runs in this process, where estimators that a
        script has registered are known.
    on_progress
        Called with the number of finished parts and of all.
    look
        Called several times a second; it may raise to stop.

    Returns
    -------
    The rows of the table, and which bars hold.

    Raises
    ------
    CallerError
        For an unknown name or no wire.
    NumericsError
        If a worker has died or failed.

    Examples
    --------
    >>> from musclewire import Selection, robustness
    >>> asked = Selection(seeds=(102,), conditions=("none",), references=("sines",))
    >>> robustness(asked, folder=folder, workers=1).estimators[0].score.rms_pct < 2.0  # doctest: +SKIP
    True
    """
    began_s = time.perf_counter()
    asked, known = selection or Selection(), bars()
    chosen = chosen_by(asked)
    seeds, conditions, references, estimators = chosen
    if not seeds or not estimators:
        raise CallerError("the benchmark needs a seed and an estimator or more")
    plan = read_study(study_of(chosen, Path(folder)))
    result = sweep(
        plan,
        Path(folder) / "runs" / plan.fingerprint,
        # The runs of one wire go to one process, which characterizes it once.
        workers=Workers(processes=workers, runs_per_chunk=len(conditions)),
        on_progress=on_progress,
        look=look,
    )
    for error in filter(None, result.errors):
        raise NumericsError(f"a run of the benchmark has failed: {error}")
    answers = tuple(answer_of_text(text) for text in result.texts[ANSWER])
    rows = estimator_rows(answers, conditions, known)
    verdicts = verdicts_of(rows, known, known_misses().reasons(quick=asked.quick))
    grips = () if asked.quick or asked.conditions is not None else grip_rows()
    wall_s = time.perf_counter() - began_s
    return Robustness(seeds, conditions, references, rows, verdicts, grips, answers, asked.quick, wall_s)
