"""The loop's own error: for how long its estimate is farther from the target than it may be, and why.

What a loop sees itself needs no instrument: where the estimate is away from the target by more than a tolerance and the
estimate's own 95 % interval, the wire was not where it was asked to be. The speed limits said before the run explain a
miss as far as the fastest wire missed, too, within the last second, and no farther.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.judge._known_strain import WITHIN_STD
from musclewire.judge._loop import Cause, DetectedRows, JudgedLoop, Mask, in_windows

# A target is missed if the error is larger, beyond the interval, than each of these:
OF_TARGET = 0.03  # of the target: a little more than the paper's largest error on its staircase
OF_RANGE = 0.01  # of the range in which the model senses: near a target of zero the other would allow nothing
# An interval hides a miss whose half-width is more than this part of the range: it would not be seen on any step.
WIDE = 0.1
# A run does not hold that missed its target for more than this part of the time with one; less is not said: the first
# step from cold, or steps after a change of supply or air, take some of it in runs that err by 1 to 2 % in the mean.
MAX_MISSED = 0.1
# [s] by which a loop may be later than the fastest wire, by its dead time and as it slows down before a target.
MAY_LAG_S = 1.0
# [s] for which a miss lasts before a running loop states it, so that it does not come and go on a page with each drag.
SAID_AFTER_S = 1.0


class SeenLoop(NamedTuple):
    """What a loop sees of itself, at one sample or at all of them, in the unit of its quantity."""

    target: FloatArray | float
    estimate: FloatArray | float
    std: FloatArray | float
    valid: Mask | float  # an estimate without it has no interval: the wire is cold of B, or beyond C
    # Between which distances from its target the fastest wire was within the last second.
    announced_low: FloatArray | float
    announced_high: FloatArray | float
    sensed_range: float  # how far the model senses

    def misses(self) -> tuple[Mask, Mask]:
        """Return where the target is missed, and where the interval is too wide to say whether it is."""
        away = np.subtract(self.estimate, self.target)
        above = away - np.maximum(self.announced_high, 0.0)
        beyond = np.maximum(above, np.minimum(self.announced_low, 0.0) - away)
        tolerance = np.maximum(OF_TARGET * np.abs(self.target), OF_RANGE * self.sensed_range)
        half_width = np.where(np.asarray(self.valid) > 0.0, WITHIN_STD * np.asarray(self.std), 0.0)
        seen = beyond > tolerance + half_width
        hidden = (beyond > tolerance) & ~seen & (half_width > WIDE * self.sensed_range)
        return np.asarray(seen), np.asarray(hidden)


class MissedTarget(NamedTuple):
    """Where the estimate of a closed loop was too far from its target; nowhere in an interrupted run."""

    rows: Mask  # the samples at which the target was missed, (n_times,); none if they are few
    hidden: Mask  # those at which it may have been, but the interval is too wide to say, likewise


def missed_target(loop: JudgedLoop) -> MissedTarget:
    """Return where the estimate was too far from its target, after the approach."""
    seen = SeenLoop(
        loop.target,
        loop.estimate,
        loop.std,
        loop.valid,
        *within_last(round(MAY_LAG_S / loop.period_s), loop.column("announced_miss", 0.0)),
        loop.facts.number_or_none("sensed_range") or float(np.abs(loop.target).max()),
    )
    whole, few = loop.facts.text_or_none("ended") != "interrupted", MAX_MISSED * loop.with_target.sum()
    found = (rows & loop.with_target & whole for rows in seen.misses())
    return MissedTarget(*(rows & (rows.sum() > few) for rows in found))


def target_missed(loop: JudgedLoop) -> DetectedRows:
    """Return the samples at which the target was missed, for how much of the time, by how much, and why, if known."""
    rows = loop.once(missed_target).rows
    return DetectedRows(rows, lambda: missed_in_words(loop, rows))


def interval_too_wide(loop: JudgedLoop) -> DetectedRows:
    """Return the samples at which the target may have been missed, and the interval is too wide to say."""
    return DetectedRows(loop.once(missed_target).hidden)


def missed_in_words(loop: JudgedLoop, rows: Mask) -> str:
    """Return in words for how much of the time and by how much a target was missed, and what caused most of it."""
    below = loop.away < 0.0
    known = {
        "the protection": below & loop.at_lower_limit,
        "no valid estimate": below & ~loop.valid,
        "the supply": below & loop.at_upper_limit,
        "the power that holds the highest temperature": below & loop.power_limited,
        "cooling": ~below & loop.at_lower_limit,
        "the air": loop.recorded(Cause.CHANGED_AIR),
    }
    why = next((f": {name}" for name, there in known.items() if (there & rows).sum() > 0.5 * rows.sum()), "")
    factor, unit = loop.shown_as
    missed_pct = 100.0 * rows.sum() / loop.with_target.sum()
    return f"{missed_pct:.0f} % of the time, by up to {factor * np.abs(loop.away[rows]).max():.2g} {unit}{why}"


def within_last(length: int, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and the largest of each value and so many before it, (n_times,) each."""
    seen = np.concatenate([np.full(length, values[0]), values])
    return in_windows(np.minimum, seen, length + 1), in_windows(np.maximum, seen, length + 1)


class MissWatch:
    """Says of a loop that runs for how long it has missed its target, once that has lasted."""

    def __init__(self, suffix: str, sensed_range: float, approach_s: float) -> None:
        """Begin with nothing missed, as all is before ``approach_s``; ``suffix`` ends the columns of the quantity."""
        self._suffix, self._sensed_range, self._approach_s = suffix, sensed_range, approach_s
        self._since_s = math.inf
        self._announced: deque[tuple[float, float]] = deque()

    def after(self, row: Mapping[str, float | None]) -> str:
        """Return what is to be said after a recorded row of the loop; "" while it is on its way, or there."""
        numbers = {name: math.nan if value is None else value for name, value in row.items()}
        self._announced.append((numbers["time_s"], numbers.get("announced_miss", 0.0)))
        while self._announced[0][0] < numbers["time_s"] - MAY_LAG_S:
            self._announced.popleft()
        announced = [miss for _, miss in self._announced]
        seen = SeenLoop(
            numbers[f"target_{self._suffix}"],
            numbers[f"estimated_{self._suffix}"],
            numbers.get("estimate_std", 0.0),
            numbers.get("valid", 1.0),
            min(announced),
            max(announced),
            self._sensed_range,
        )
        missed, _ = seen.misses()
        counts = bool(missed) and numbers["time_s"] > self._approach_s
        self._since_s = min(self._since_s, numbers["time_s"]) if counts else math.inf
        lasts = numbers["time_s"] - self._since_s > SAID_AFTER_S
        return f"target missed from {self._since_s:.1f} s on" if lasts else ""
