"""A row of the reproduction: the median of ours over seeds with its spread, and the verdict on it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from musclewire.extras.paper._reproduce.paper_checks import (
    ROUNDING,
    Compare,
    Kind,
    Origin,
    PaperCheck,
    SeedResult,
    bars,
    holds,
    subject_of,
)

Verdict = Literal["holds", "at the bar", "fails", "reported"]
JUDGED: tuple[Verdict, ...] = ("holds", "at the bar", "fails")
# In the order of what a row that holds says of the simulator, most first.
ORIGINS: tuple[Origin, ...] = (
    "predicted", "interpolated", "fitted", "chosen", "designed", "satisfied", "definition", "input",
)  # fmt: skip
# Rows of these cannot fail unless the code is wrong: they stand apart, and are not among those that hold.
CANNOT_FAIL: tuple[Origin, ...] = ("satisfied", "definition", "input")
# Probability that the median of a row over all seeds is outside the interval about that over ours.
OUTSIDE = 0.05
# A row fails, whatever its median, if this part of the seeds or more gives no number.
MISSING_FRACTION = 0.1
SPREAD = (0.05, 0.95)


@dataclass(frozen=True)
class ReproductionRow:
    """A check with its outcome over seeds."""

    name: str
    paper: float
    ours: float | None  # median over the seeds that have a number, None if none has
    low: float | None  # 5 and 95 % points of these
    high: float | None
    median_low: float | None  # 95 % interval of the median
    median_high: float | None
    seeds: int  # those that have a number
    unit: str
    tolerance: float
    compare: Compare
    verdict: Verdict
    known_failure: bool
    known_reason: str | None
    why: str
    kind: Kind
    origin: Origin
    problem: str | None  # why seeds have no number, and how many

    @property
    def ok(self) -> bool:
        """Whether the row does not fail; one at the bar does."""
        return self.verdict in {"holds", "reported"}

    @property
    def is_judged(self) -> bool:
        """Whether the row counts as holding or failing: all do but those that are reported only."""
        return self.verdict != "reported"

    @property
    def is_counted(self) -> bool:
        """Whether the row is among those that are counted: it is judged, and can fail."""
        return self.is_judged and self.origin not in CANNOT_FAIL

    @property
    def is_worse(self) -> bool:
        """Whether a one-sided row holds only by its tolerance: ours is worse than the paper's number."""
        if self.compare not in {"at most", "at least"} or not self.ok or self.ours is None:
            return False
        worse = self.ours - self.paper if self.compare == "at most" else self.paper - self.ours
        return worse > ROUNDING * max(1.0, abs(self.paper))

    @property
    def subject(self) -> str:
        """What the row belongs to: a figure, a table, an equation."""
        return subject_of(self.name)


class OriginCount(NamedTuple):
    """How many rows of an origin hold, are at the bar, and fail."""

    origin: Origin
    holds: int
    at_the_bar: int
    fails: int

    @property
    def rows(self) -> int:
        """Number of rows of this origin."""
        return self.holds + self.at_the_bar + self.fails


class MedianSpread(NamedTuple):
    """Median of numbers with their 5 and 95 % points, and the 95 % interval of the median."""

    ours: float
    low: float
    high: float
    median_low: float
    median_high: float


def row_of_check(check: PaperCheck, found: Sequence[SeedResult], known: Mapping[str, str]) -> ReproductionRow:
    """Return the row of a check from each seed's; it fails if a tenth of the seeds or more have no number."""
    values = [one.number for one in found if one.number is not None]
    missing = len(found) - len(values)
    spread = spread_of(values) if values else None
    return ReproductionRow(
        name=check.name,
        paper=float(check.paper),
        **(spread._asdict() if spread else dict.fromkeys(MedianSpread._fields)),
        seeds=len(values),
        unit=check.unit,
        tolerance=check.tolerance,
        compare=check.compare,
        verdict="fails" if spread is None or missing >= MISSING_FRACTION * len(found) else verdict_on(check, spread),
        known_failure=check.name in known,
        known_reason=known.get(check.name),
        why=check.why,
        kind=check.kind,
        origin=check.origin,
        problem=problem_of(found),
    )


def counts_by_origin(rows: Sequence[ReproductionRow]) -> list[OriginCount]:
    """Return how many rows of each origin hold, predictions first; origins without a judged row are left out."""
    counts = Counter((row.origin, row.verdict) for row in rows)
    found = [OriginCount(origin, *(counts[origin, verdict] for verdict in JUDGED)) for origin in ORIGINS]
    return [one for one in found if one.rows]


def spread_of(values: Sequence[float]) -> MedianSpread:
    """Return the median of numbers with their spread."""
    low, high = np.quantile(values, SPREAD)
    return MedianSpread(float(np.median(values)), float(low), float(high), *median_interval(values))


def median_interval(values: Sequence[float]) -> tuple[float, float]:
    """Return the interval that covers the median of what the numbers are drawn from with a probability of 95 %.

    Its ends are order statistics, so it holds for any distribution. Fewer than six numbers cannot say so much: theirs
    is from the smallest to the largest.

    References
    ----------
    David and Nagaraja, Order Statistics, 3rd edition (2003), section 7.1.
    """
    count, ordered = len(values), sorted(values)
    # The median lies below the k-th number with the probability that fewer than k of n fair coins show heads.
    rank, below = 0, 0
    while 2 * (below + math.comb(count, rank)) <= OUTSIDE * 2**count:
        below += math.comb(count, rank)
        rank += 1
    place = max(rank - 1, 0)
    return ordered[place], ordered[count - 1 - place]


def verdict_on(check: PaperCheck, spread: MedianSpread) -> Verdict:
    """Return whether the median holds, or a limit of the tolerance is inside the interval of the median."""
    if check.compare == "reported":
        return "reported"
    low, high = spread.median_low, spread.median_high
    if low < high and any(low <= bar <= high for bar in bars(check)):
        return "at the bar"
    return "holds" if holds(check, spread.ours) else "fails"


def problem_of(found: Sequence[SeedResult]) -> str | None:
    """Return why seeds have no number, with their count unless it is all of them; None if each has one."""
    problems = [one.problem for one in found if one.problem is not None]
    if not problems:
        return None
    if len(problems) == len(found):
        return problems[0]
    return f"{len(problems)} of {len(found)} seeds have no number: {problems[0]}"
