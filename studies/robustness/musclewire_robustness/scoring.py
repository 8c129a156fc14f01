"""Scores of an estimator on a run, as sums: the scores of many runs and wires add up to that of a row."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from musclewire import FloatArray
from musclewire.judge import GRAVE
from musclewire_robustness.characterizing import UsersKnowledge
from musclewire_robustness.estimating import EstimatedRun
from musclewire_robustness.recorded_run import RecordedRun
from musclewire_robustness.settings import Condition, RunSettings

# A sample counts as wrong beyond this fraction of the full stroke; an interval is this many standard deviations wide.
WRONG, DEVIATIONS = 0.05, 1.96
# Samples around the maximum of resistance at which nobody could say on which side of B the wire is.
NEAR_B = 5
# The maximum is looked for in the resistance smoothed over this many samples.
SMOOTHED = 9
# A column of an estimator, or of what watches it, with the number of a cause; 0 while nothing is wrong.
HEALTH_COLUMN = "health"


@dataclass(frozen=True)
class ErrorSums:
    """Sums over judged samples; they add up.

    Parameters
    ----------
    samples
        Judged samples: in the usable range, from the time on from which the condition counts.
    squares, squares_new_zero
        Sums of squared errors in full strokes, with the instruments' zero kept and taken again.
    noted, flagged
        Judged samples at which only causes with which a run holds were named, and any with which it does not.
    half_widths_pct
        Median half-width of the 95 % interval over the valid samples of each run [% of the full stroke].
    valid
        Judged samples said to be valid.
    wrong
        Those of them that err by more than 5 % of the full stroke while nothing is flagged.
    within
        Those of them whose 95 % interval holds the truth.
    cold, valid_cold
        Samples before B, and those of them said to be valid.
    failures
        Runs in which the estimator asked to end.
    flag_runs, flags_in_time
        Runs in which a flag is asked for, and those in which it came in time.
    flag_times_s
        Sum of the times from the change to the first flag [s], over the runs that had one.
    flagged_runs
        Runs with a flag after the change.
    false_flags
        Flags that began while nothing had changed.
    quiet_s
        Time in which nothing had changed [s].
    """

    samples: int = 0
    squares: float = 0.0
    squares_new_zero: float = 0.0
    valid: int = 0
    wrong: int = 0
    within: int = 0
    cold: int = 0
    valid_cold: int = 0
    failures: int = 0
    flag_runs: int = 0
    flags_in_time: int = 0
    flag_times_s: float = 0.0
    flagged_runs: int = 0
    false_flags: int = 0
    quiet_s: float = 0.0
    noted: int = 0
    flagged: int = 0
    half_widths_pct: tuple[float, ...] = ()

    def __add__(self, other: ErrorSums) -> ErrorSums:
        """Return the sums of both."""
        return ErrorSums(*(getattr(self, item.name) + getattr(other, item.name) for item in fields(self)))

    @property
    def rms_pct(self) -> float | None:
        """Root mean square error [%] of the full stroke, with the zero kept; None without a judged sample."""
        return 100.0 * (self.squares / self.samples) ** 0.5 if self.samples else None

    @property
    def rms_new_zero_pct(self) -> float | None:
        """The same with the instruments' zero taken again [%]."""
        return 100.0 * (self.squares_new_zero / self.samples) ** 0.5 if self.samples else None

    @property
    def valid_share(self) -> float | None:
        """Fraction of the judged samples that are valid."""
        return self.valid / self.samples if self.samples else None

    @property
    def beyond_5_share(self) -> float | None:
        """Fraction of the judged samples that say valid, unflagged, and are more than 5 % of the full stroke wrong."""
        return self.wrong / self.samples if self.samples else None

    @property
    def coverage(self) -> float | None:
        """Fraction of the valid samples whose 95 % interval holds the truth."""
        return self.within / self.valid if self.valid else None

    @property
    def noted_share(self) -> float | None:
        """Fraction of the judged samples at which only causes with which a run holds were named."""
        return self.noted / self.samples if self.samples else None

    @property
    def flagged_share(self) -> float | None:
        """Fraction of the judged samples at which a cause was named with which a run does not hold."""
        return self.flagged / self.samples if self.samples else None

    @property
    def interval_half_width_pct(self) -> float | None:
        """Median over the runs of the half-width of the 95 % interval [% of the full stroke]."""
        return float(np.median(self.half_widths_pct)) if self.half_widths_pct else None

    @property
    def valid_cold_fraction(self) -> float | None:
        """Fraction of the samples before B that say valid."""
        return self.valid_cold / self.cold if self.cold else None

    @property
    def flags_in_time_fraction(self) -> float | None:
        """Fraction of the runs with a flag in time; None if none is asked for."""
        return self.flags_in_time / self.flag_runs if self.flag_runs else None

    @property
    def flagged_s(self) -> float | None:
        """Mean time from the change to the first flag [s], of the runs that had one."""
        return self.flag_times_s / self.flagged_runs if self.flagged_runs else None

    @property
    def false_flags_per_hour(self) -> float | None:
        """Flags an hour while nothing had changed."""
        return 3600.0 * self.false_flags / self.quiet_s if self.quiet_s else None


def pooled(scores: Iterable[ErrorSums]) -> ErrorSums:
    """Return the sums of many scores."""
    total = ErrorSums()
    for score in scores:
        total = total + score
    return total


def judged_from_s(condition: Condition, run: RunSettings) -> float:
    """Return the time from the reference's start from which a condition counts [s].

    After a slow drift once all of it is there, after another load ten seconds from the beginning of the change, in
    other air from the beginning of the change on; where nothing changes during the run, from the start.
    """
    if condition.zeroed:
        return 0.0
    if condition.drift:
        return run.change_at_s + run.drift_s
    if condition.changes_load:
        return run.change_at_s + run.judged_after_s
    return run.change_at_s if condition.changes_air and not condition.home else 0.0


def usable(strain: FloatArray, knowledge: UsersKnowledge, run: RunSettings) -> npt.NDArray[np.bool_]:
    """Return which samples lie in the usable range: a part of the full stroke, and where the model senses at all."""
    low = max(run.usable_low * knowledge.stroke, knowledge.model.quantity_min)
    high = min(run.usable_high * knowledge.stroke, knowledge.model.quantity_max)
    return np.asarray((strain >= low) & (strain <= high))


def score_of(
    run: RecordedRun, found: EstimatedRun, condition: Condition, knowledge: UsersKnowledge, times: RunSettings
) -> ErrorSums:
    """Return the score of an estimator on a run.

    Parameters
    ----------
    run
        The run.
    found
        The estimator's answers.
    condition
        Its condition.
    knowledge
        What the wire's user knows: the stroke that counts as 100 %, and the range of his model.
    times
        Times of a run.

    Returns
    -------
    The sums.
    """
    stroke = knowledge.stroke
    judged = usable(run.strain, knowledge, times) & (run.time_s >= judged_from_s(condition, times))
    error = (found.value - run.strain)[judged] / stroke
    new_zero = error + run.zero_shift[judged] / stroke
    valid, std = found.valid[judged], found.std[judged] / stroke
    cold = before_b(run) | cooled(run, condition, times)
    health = found.columns.get(HEALTH_COLUMN, np.zeros(run.time_s.size))
    flagged = (found.resistance_is_odd | np.isin(health, GRAVE))[judged]
    half_pct = half_width_pct(found.std[judged], valid, stroke)
    return ErrorSums(
        samples=int(judged.sum()),
        squares=float(error @ error),
        squares_new_zero=float(new_zero @ new_zero),
        valid=int(valid.sum()),
        wrong=int(np.sum(valid & ~flagged & (np.abs(error) > WRONG))),
        within=int(np.sum(valid & (np.abs(error) <= DEVIATIONS * std))),
        cold=int(cold.sum()),
        valid_cold=int(found.valid[cold].sum()),
        failures=int(bool(found.failure)),
        noted=int(np.sum((health != 0.0)[judged] & ~flagged)),
        flagged=int(flagged.sum()),
        half_widths_pct=() if half_pct is None else (half_pct,),
    ) + flags_of(run, found, condition, times)


def before_b(run: RecordedRun) -> npt.NDArray[np.bool_]:
    """Return the samples of the first heating before resistance is largest, less those at which it is."""
    rising = np.flatnonzero(run.time_s < 0.0)
    first = rising[: max(int(0.45 * rising.size), 1)]
    ohm = run.wire_voltage_v[first] / np.maximum(run.shunt_voltage_v[first], 1e-9)
    smooth = np.convolve(ohm, np.ones(SMOOTHED) / SMOOTHED, mode="valid")
    found = np.zeros(run.time_s.size, dtype=np.bool_)
    if smooth.size:
        found[: max(int(np.argmax(smooth)) + SMOOTHED // 2 - NEAR_B, 0)] = True
    return found


def cooled(run: RecordedRun, condition: Condition, times: RunSettings) -> npt.NDArray[np.bool_]:
    """Return the samples of the second half of a rest, in which the wire is cold."""
    since_s = run.time_s - times.change_at_s
    return np.asarray((since_s >= 0.5 * condition.rest_s) & (since_s < condition.rest_s))


def half_width_pct(std: FloatArray, valid: npt.NDArray[np.bool_], stroke: float) -> float | None:
    """Return the median half-width of 95 % intervals over valid samples [% of a stroke]; None without any."""
    return 100.0 * DEVIATIONS * float(np.median(std[valid])) / stroke if valid.any() else None


def flags_of(run: RecordedRun, found: EstimatedRun, condition: Condition, times: RunSettings) -> ErrorSums:
    """Return what there is to say of flags, if the estimator or what watches it records its health."""
    health = found.columns.get(HEALTH_COLUMN)
    if health is None:
        return ErrorSums()
    named = health != 0.0
    begins = named & ~np.concatenate([[False], named[:-1]])
    if condition.undisturbed:
        quiet = run.time_s >= 0.0
        period_s = run.facts["sample_period_s"]
        return ErrorSums(false_flags=int(begins[quiet].sum()), quiet_s=float(quiet.sum()) * period_s)
    if condition.flag_s is None:
        return ErrorSums()
    after = np.flatnonzero(named & (run.time_s >= times.change_at_s))
    if not after.size:
        return ErrorSums(flag_runs=1)
    needed_s = float(run.time_s[after[0]]) - times.change_at_s
    return ErrorSums(
        flag_runs=1, flags_in_time=int(needed_s <= condition.flag_s), flag_times_s=needed_s, flagged_runs=1
    )
