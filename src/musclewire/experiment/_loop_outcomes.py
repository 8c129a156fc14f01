"""What many closed loops have given: the outcome of each, medians and spreads over all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.experiment._metrics import APPROACHED, FROM_FIRST_TARGET, ControlMetrics
from musclewire.sensing import SHOWN_AS
from musclewire.signals import Recording

# The spread that is shown: nine tenths of the loops lie between.
LOW_PERCENTILE = 5.0
HIGH_PERCENTILE = 95.0


class LoopOutcome(NamedTuple):
    """The outcome of one closed loop."""

    seed: int
    ended: str  # "done", or the error that ended it, in one line
    compiled: bool
    metrics: ControlMetrics | None  # None if it did not reach its end
    run: Recording | None  # up to the error if there was one; None unless recordings are kept
    warnings: tuple[str, ...] = ()  # of a wire that pulled harder than allowed, or friction that held it
    does_not_hold: str = ""  # why its result does not hold, though it reached its end


class StepSpread(NamedTuple):
    """Errors of one step over all loops, against the reference instrument [%] (Eq. 7).

    From the first target on, and with ``approached`` in the name after the approach; the first step alone differs.
    """

    target: float  # in the unit of the quantity
    direction: str  # "rise" or "return"
    median_pct: float
    low_pct: float  # 5th and 95th percentile
    high_pct: float
    maximum_pct: float
    median_approached_pct: float
    low_approached_pct: float
    high_approached_pct: float
    maximum_approached_pct: float


@dataclass(frozen=True)
class ManyControlRuns:
    """The outcomes of many closed loops, in the order of their seeds."""

    outcomes: tuple[LoopOutcome, ...]  # one for each loop

    @property
    def metrics(self) -> tuple[ControlMetrics, ...]:
        """Errors of the loops that reached their end."""
        return tuple(outcome.metrics for outcome in self.outcomes if outcome.metrics is not None)

    @property
    def failed(self) -> tuple[LoopOutcome, ...]:
        """The loops that an error ended."""
        return tuple(outcome for outcome in self.outcomes if outcome.metrics is None)

    @property
    def doubtful(self) -> tuple[LoopOutcome, ...]:
        """The loops that reached their end, but whose results do not hold."""
        return tuple(outcome for outcome in self.outcomes if outcome.does_not_hold)

    @property
    def in_python(self) -> int:
        """How many loops ran in Python."""
        return sum(not outcome.compiled for outcome in self.outcomes)

    @property
    def warnings(self) -> tuple[str, ...]:
        """How many loops have warnings, with those of the first; none if no loop has one."""
        found = [outcome for outcome in self.outcomes if outcome.warnings]
        if not found:
            return ()
        where = f"in {len(found)} of {len(self.outcomes)} loops, the first of them that of seed {found[0].seed}: "
        return tuple(where + text for text in found[0].warnings)

    @property
    def mae_pct(self) -> FloatArray:
        """Mean absolute error of each step from the first target on (Eq. 7) [%], (n_loops, n_steps); NaN if unknown."""
        return as_numbers([[step.mae_pct for step in one.steps] for one in self.metrics])

    @property
    def mae_approached_pct(self) -> FloatArray:
        """Mean absolute error of each step after the approach (Eq. 7) [%], (n_loops, n_steps)."""
        return as_numbers([[step.mae_approached_pct for step in one.steps] for one in self.metrics])

    @property
    def mae_max_pct(self) -> FloatArray:
        """Largest step error from the first target on of each loop that reached its end [%], (n_loops,)."""
        return as_numbers([one.mae_max_pct for one in self.metrics])

    @property
    def mae_mean_pct(self) -> FloatArray:
        """Mean step error from the first target on of each loop that reached its end [%], (n_loops,)."""
        return as_numbers([one.mae_mean_pct for one in self.metrics])

    @property
    def mae_max_approached_pct(self) -> FloatArray:
        """Largest step error after the approach of each loop that reached its end [%], (n_loops,)."""
        return as_numbers([one.mae_max_approached_pct for one in self.metrics])

    @property
    def rms_pct(self) -> FloatArray:
        """Error of each loop that reached its end, rms over its largest target [%], (n_loops,)."""
        return as_numbers([one.rms_pct for one in self.metrics])

    @property
    def steps(self) -> tuple[StepSpread, ...]:
        """Median and spread of each step; none if the target was not a staircase or no loop reached its end."""
        if not self.metrics or not self.metrics[0].steps:
            return ()
        return tuple(
            StepSpread(step.target, step.direction, *spread_of(errors), *spread_of(approached))
            for step, errors, approached in zip(
                self.metrics[0].steps, self.mae_pct.T, self.mae_approached_pct.T, strict=True
            )
        )

    def __str__(self) -> str:
        """Return a small table."""
        lines = [f"{len(self.metrics)} of {len(self.outcomes)} loops reached their end; {self.in_python} ran in Python"]
        if self.steps:
            lines += self.step_table()
        elif self.metrics:
            lines.append(f"rms error in % of the largest target: {in_words(self.rms_pct)}")
        lines += [f"seed {outcome.seed}: {outcome.ended}" for outcome in self.failed]
        lines += [f"seed {outcome.seed} does not hold: {outcome.does_not_hold}" for outcome in self.doubtful]
        return "\n".join(lines)

    def step_table(self) -> list[str]:
        """Return the spread of each step's error as lines; the first step has two if the readings of Eq. 7 differ."""
        first = self.metrics[0]
        factor, unit = SHOWN_AS[first.quantity]
        lines = [
            f"mean of the steps: {in_words(self.mae_mean_pct)}",
            f"largest step error {FROM_FIRST_TARGET}: {in_words(self.mae_max_pct)}",
            "mean absolute error in % of the target over the loops, the first second of each step left out (Eq. 7)",
            first.approach,
            f"{'target':>10} {'':7} {'median':>8} {'5 %':>8} {'95 %':>8} {'largest':>8}",
        ]
        for step in self.steps:
            label = f"{step.target * factor:>7.3g} {unit:2} {step.direction:7}"
            counted, approached = (" ".join(f"{error:>8.3f}" for error in four) for four in (step[2:6], step[6:]))
            if counted == approached:
                lines.append(f"{label} {counted}")
            else:
                lines += [f"{label} {counted}  {FROM_FIRST_TARGET}", f"{label} {approached}  {APPROACHED}"]
        if first.approach_s != 0.0:
            lines.insert(2, f"largest step error {APPROACHED}: {in_words(self.mae_max_approached_pct)}")
        return lines


def as_numbers(errors_pct: Sequence[float | None] | Sequence[Sequence[float | None]]) -> FloatArray:
    """Return errors as an array, None as not a number."""
    return np.array(errors_pct, dtype=np.float64)


def spread_of(errors_pct: FloatArray) -> tuple[float, float, float, float]:
    """Return median, 5th and 95th percentile and maximum of errors; not a number if one of them is none."""
    low, median, high = np.percentile(errors_pct, [LOW_PERCENTILE, 50.0, HIGH_PERCENTILE])
    return float(median), float(low), float(high), float(errors_pct.max())


def in_words(errors_pct: FloatArray) -> str:
    """Return the spread of errors in one line."""
    median, low, high, largest = spread_of(errors_pct)
    return f"median {median:.3f}, 5 % {low:.3f}, 95 % {high:.3f}, largest {largest:.3f} %"
