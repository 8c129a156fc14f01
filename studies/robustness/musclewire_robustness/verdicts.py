"""Which bars hold: each as one number against one bar, with the row that it belongs to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from musclewire_robustness.rows import EstimatorRow
from musclewire_robustness.settings import RobustnessBars, RowBar


class BarVerdict(NamedTuple):
    """One number and its bar.

    Parameters
    ----------
    name
        What it is.
    condition
        Name of the condition.
    value
        The number; None if it could not be found, which misses the bar.
    low, high
        The bar: the number must not be below or above; None without such an end.
    unit
        Unit of all three.
    wire
        Seed of the wire whose number it is; None for a number of several.
    known_reason
        Why the bar is known to be missed; None for one that the committed list does not have.
    """

    name: str
    condition: str
    value: float | None
    low: float | None
    high: float | None
    unit: str
    wire: int | None = None
    known_reason: str | None = None

    @property
    def full_name(self) -> str:
        """Condition and name, by which the committed list has it."""
        return f"{self.condition}: {self.name}"

    @property
    def holds(self) -> bool:
        """Whether the number keeps its bar."""
        if self.value is None:
            return False
        return (self.low is None or self.value >= self.low) and (self.high is None or self.value <= self.high)

    @property
    def bar_text(self) -> str:
        """The bar in words."""
        low = "" if self.low is None else f"at least {self.low:.3g}"
        high = "" if self.high is None else f"at most {self.high:.3g}"
        return " and ".join(end for end in (low, high) if end)

    def __str__(self) -> str:
        """Return it as a line."""
        value = "not found" if self.value is None else f"{self.value:.3g} {self.unit}".rstrip()
        wire = "" if self.wire is None else f" (wire {self.wire})"
        return f"{self.full_name} {value}{wire}, {self.bar_text}"


def effective_bar_pct(own_pct: float, baseline_pct: float | None, bars: RobustnessBars) -> float:
    """Return a bar [%] as it counts: one below a fraction of the baseline's row is that fraction."""
    return own_pct if baseline_pct is None else max(own_pct, bars.baseline_fraction * baseline_pct)


def verdicts_of(
    estimators: Sequence[EstimatorRow], bars: RobustnessBars, known: Mapping[str, str]
) -> tuple[BarVerdict, ...]:
    """Return every bar of the default estimator that the rows allow to judge.

    Parameters
    ----------
    estimators
        Rows of estimators.
    bars
        The bars.
    known
        Reasons of the bars that are known to be missed, by their full names.

    Returns
    -------
    The verdicts, in the order of the rows.
    """
    baseline = {row.condition.name: row for row in estimators if row.estimator == bars.baseline_estimator}
    found: list[BarVerdict] = []
    for row in estimators:
        if row.estimator == bars.default_estimator:
            found += estimator_verdicts(row, baseline.get(row.condition.name), bars)
    return tuple(one._replace(known_reason=known.get(one.full_name)) for one in found)


def estimator_verdicts(row: EstimatorRow, baseline: EstimatorRow | None, bars: RobustnessBars) -> Iterator[BarVerdict]:
    """Yield the verdicts on an estimator's row."""
    bar = bars.bar_named(row.condition.bar)
    yield from error_verdicts(row, baseline, bar, bars)
    if bar.honest:
        yield from honest_verdicts(row, bars)
    flags, name = row.score, row.condition.name
    if row.condition.flag_s is not None and flags.flag_runs:
        yield BarVerdict("flagged in time", name, flags.flags_in_time_fraction, bars.flags.in_time_fraction, None, "")
    if row.condition.undisturbed and flags.quiet_s:
        yield BarVerdict("false flags", name, flags.false_flags_per_hour, None, bars.flags.false_per_hour, "an hour")


def error_verdicts(
    row: EstimatorRow, baseline: EstimatorRow | None, bar: RowBar, bars: RobustnessBars
) -> Iterator[BarVerdict]:
    """Yield the verdicts on the errors of a row: pooled, and of the worst wire."""
    if bar.max_pct is None:
        return
    name = row.condition.name
    base_pct = None if baseline is None else baseline.counted_pct
    high_pct = effective_bar_pct(bar.max_pct, base_pct, bars)
    segmented_pct = effective_bar_pct(bar.segmented_max_pct or bar.max_pct, base_pct, bars)
    if bar.segmented_max_pct is None:
        yield BarVerdict("error", name, row.counted_pct, None, high_pct, "%")
    else:
        if row.one_segment_pct is not None:
            yield BarVerdict("error of wires of one segment", name, row.one_segment_pct, None, high_pct, "%")
        if row.segmented_pct is not None:
            yield BarVerdict("error of wires in segments", name, row.segmented_pct, None, segmented_pct, "%")
    if row.worst is not None:
        high_pct = segmented_pct if row.worst.segments > 1 else high_pct
        worst_pct = bars.worst_wire_ratio * high_pct
        yield BarVerdict("error of the worst wire", name, row.worst.counted_pct, None, worst_pct, "%", row.worst.seed)


def honest_verdicts(row: EstimatorRow, bars: RobustnessBars) -> Iterator[BarVerdict]:
    """Yield the verdicts on the intervals and the validity of a row."""
    score, honest, name = row.score, bars.honest, row.condition.name
    yield BarVerdict("95 % intervals hold", name, score.coverage, honest.coverage_low, honest.coverage_high, "")
    yield BarVerdict("valid and wrong by 5 %", name, score.beyond_5_share, None, honest.beyond_5_share, "")
    least = honest.valid_undisturbed if row.condition.undisturbed else honest.valid_changed
    yield BarVerdict("valid", name, score.valid_share, least, None, "")
    if score.cold:
        yield BarVerdict("valid before B", name, score.valid_cold_fraction, None, honest.valid_before_b, "")
