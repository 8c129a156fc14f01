"""The rows of the table, from the answers of all wires: a condition with an estimator, or with a closed loop."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from musclewire_robustness.closed_loops import ScoredLoop
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


@dataclass(frozen=True)
class LoopRow:
    """A closed loop under a condition, all wires together; errors by Eq. 7 in percent of the target.

    Parameters
    ----------
    condition
        The condition.
    estimator, controller
        Their names.
    outcomes
        What it came to, a wire each.
    allowances
        By how much each wire's bar is multiplied.
    seeds
        Seeds of the wires.
    """

    condition: Condition
    estimator: str
    controller: str
    outcomes: tuple[ScoredLoop, ...]
    allowances: tuple[float, ...]
    seeds: tuple[int, ...]

    @property
    def mae_mean_pct(self) -> float | None:
        """Mean over wires of the mean over steps [%]."""
        return mean_of([one.mae_mean_pct for one in self.outcomes])

    @property
    def mae_max_pct(self) -> float | None:
        """Largest error of any step of any wire [%]."""
        found = [self.largest(name) for name in ("mae_first_pct", "mae_other_max_pct")]
        return max((one for one in found if one is not None), default=None)

    @property
    def interval_half_width_pct(self) -> float | None:
        """Median over wires of the half-width of the 95 % interval [% of the stroke]."""
        found = [one.half_width_pct for one in self.outcomes if one.half_width_pct is not None]
        return float(np.median(found)) if found else None

    @property
    def noted_share(self) -> float | None:
        """Mean over wires of the fraction of samples at which only causes with which a run holds were named."""
        return mean_of([one.noted_share for one in self.outcomes])

    @property
    def flagged_share(self) -> float | None:
        """Mean over wires of the fraction of samples at which a cause was named with which a run does not hold."""
        return mean_of([one.flagged_share for one in self.outcomes])

    @property
    def ended(self) -> int:
        """Number of wires whose run has ended early; one that a refused home move kept from beginning is none."""
        return sum(bool(one.ended) and not one.ended.startswith("refused") for one in self.outcomes)

    def largest(self, name: str) -> float | None:
        """Return the largest of one number over the wires; None without any."""
        return max((value for one in self.outcomes if (value := getattr(one, name)) is not None), default=None)

    def counted(self, name: str) -> tuple[float | None, float | None]:
        """Return mean and largest of a number over the wires, each over the wire's allowance."""
        pairs = zip(self.outcomes, self.allowances, strict=True)
        found = [value / allowed for one, allowed in pairs if (value := getattr(one, name)) is not None]
        return mean_of(found), max(found, default=None)


def mean_of(values: Sequence[float | None]) -> float | None:
    """Return the mean of the numbers among some values; None without any."""
    numbers = [value for value in values if value is not None]
    return float(np.mean(numbers)) if numbers else None


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


def loop_rows(
    answers: Sequence[JobAnswer], conditions: Sequence[Condition], bars: RobustnessBars
) -> tuple[LoopRow, ...]:
    """Return a row for each condition and closed loop, in their order."""
    pairs = tuple(dict.fromkeys(pair for answer in answers for pair in answer.job.loops))
    found: list[LoopRow] = []
    for condition in conditions:
        of = [one for one in answers if one.job.condition == condition.name]
        for pair in pairs:
            having = [one for one in of if pair in one.job.loops]
            outcomes = tuple(one.loops[one.job.loops.index(pair)] for one in having)
            allowances = tuple(bars.allowance(one.gap_pct) for one in having)
            found.append(LoopRow(condition, *pair, outcomes, allowances, tuple(one.job.wire for one in having)))
    return tuple(found)
