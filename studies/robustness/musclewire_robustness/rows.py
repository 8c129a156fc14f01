"""The rows of the table, from the answers of all wires: a condition with an estimator."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from musclewire_robustness.kind import JobAnswer
from musclewire_robustness.scoring import ErrorSums, pooled
from musclewire_robustness.settings import Condition, RobustnessBars


@dataclass(frozen=True)
class WireError:
    """The error of one wire.

    Parameters
    ----------
    seed
        Its seed.
    segments
        Number of its segments.
    allowance
        By how much its bar is multiplied for the gap of its slow loop.
    rms_pct
        Its error [%]; None without a judged sample.
    """

    seed: int
    segments: int
    allowance: float
    rms_pct: float | None

    @property
    def counted_pct(self) -> float:
        """Its error over its allowance [%]; 0 without one."""
        return 0.0 if self.rms_pct is None else self.rms_pct / self.allowance


@dataclass(frozen=True)
class EstimatorRow:
    """An estimator under a condition, all wires together.

    Parameters
    ----------
    condition
        The condition.
    estimator
        Name of the estimator.
    score
        Sums over all wires.
    force
        Sums for the force at the known load, in percent of the spring's force at the full stroke.
    wires
        The error of each wire.
    problem
        Why it could not be run on some wire; "" if it could.
    ended
        Number of recorded runs that the protection has ended.
    refused
        Number of home moves that were refused.
    """

    condition: Condition
    estimator: str
    score: ErrorSums
    force: ErrorSums
    wires: tuple[WireError, ...]
    problem: str
    ended: int
    refused: int = 0

    @property
    def counted_pct(self) -> float | None:
        """Error of all wires with each wire's allowance taken into account [%], which is held to the bar."""
        return counted(self.wires)

    @property
    def one_segment_pct(self) -> float | None:
        """The same of the wires of one segment."""
        return counted([one for one in self.wires if one.segments == 1])

    @property
    def segmented_pct(self) -> float | None:
        """The same of the wires in segments."""
        return counted([one for one in self.wires if one.segments > 1])

    @property
    def worst(self) -> WireError | None:
        """The wire with the largest error for its allowance."""
        return max(self.wires, key=lambda one: one.counted_pct, default=None)


def counted(wires: Iterable[WireError]) -> float | None:
    """Return the root mean square of errors over their allowances [%], every wire alike; None without one."""
    errors = [one.counted_pct for one in wires if one.rms_pct is not None]
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else None


def estimator_rows(
    answers: Sequence[JobAnswer], conditions: Sequence[Condition], bars: RobustnessBars
) -> tuple[EstimatorRow, ...]:
    """Return a row for each condition and estimator, in their order."""
    names = tuple(dict.fromkeys(name for answer in answers for name in answer.job.all_estimators))
    return tuple(
        estimator_row(condition, name, [one for one in answers if one.job.condition == condition.name], bars)
        for condition in conditions
        for name in names
    )


def estimator_row(condition: Condition, name: str, answers: Sequence[JobAnswer], bars: RobustnessBars) -> EstimatorRow:
    """Return the row of an estimator under a condition."""
    scored = [one for one in answers if name in one.scores and one.scores[name].samples]
    wires = tuple(
        WireError(one.job.wire, one.segments, bars.allowance(one.gap_pct), one.scores[name].rms_pct) for one in scored
    )
    return EstimatorRow(
        condition,
        name,
        pooled(one.scores[name] for one in scored),
        pooled(one.force[name] for one in scored if name in one.force),
        wires,
        next((one.problems[name] for one in answers if name in one.problems), ""),
        sum(len(one.ended) for one in answers),
        sum(move.startswith("refused") for one in answers for move in one.home_moves.values()),
    )
