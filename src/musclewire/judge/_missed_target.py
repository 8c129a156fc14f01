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
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from musclewire.arrays import FloatArray
from musclewire.judge._scale_by_b import WITHIN_STD
from musclewire.signals import Recording

# A target is missed by more than this part of it, a little more than the paper's largest error on its staircase, and by
# more than this part of the range in which the model senses, beyond the interval.
OF_TARGET, OF_RANGE = 0.03, 0.01
# An interval hides a miss whose half-width is more than this part of the range: it would not be seen on any step.
WIDE = 0.1
# A run does not hold that missed its target for more than this part of the time with one; less is not said: the first
# step from cold, or steps after a change of supply or air, take some of it in runs that err by 1 to 2 % in the mean.
MAX_MISSED = 0.1
# A loop may be so much later than the fastest wire [s], by its dead time and as it slows down before a target; and
# while it runs a miss is said once it has lasted for so long, so that it does not come and go on a page with each drag.
MAY_LAG_S = SAID_AFTER_S = 1.0


class SeenLoop(NamedTuple):
    """What a loop sees of itself, at one sample or at all of them, in the unit of its quantity.

    Parameters
    ----------
    target, estimate, std
        Target, estimate and its standard deviation.
    valid
        Whether the estimate is valid; what could not be sensed has no interval: the wire is cold of B, or beyond C.
    announced_low, announced_high
        Between which distances from its target the fastest wire was within the last second.
    sensed_range
        How far the model senses.
    """

    target: FloatArray | float
    estimate: FloatArray | float
    std: FloatArray | float
    valid: FloatArray | float
    announced_low: FloatArray | float
    announced_high: FloatArray | float
    sensed_range: float

    def misses(self) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Return where the target is missed, and where the interval is too wide to say whether it is."""
        away = np.subtract(self.estimate, self.target)
        above = away - np.maximum(self.announced_high, 0.0)
        beyond = np.maximum(above, np.minimum(self.announced_low, 0.0) - away)
        tolerance = np.maximum(OF_TARGET * np.abs(self.target), OF_RANGE * self.sensed_range)
        half_width = np.where(np.asarray(self.valid) > 0.0, WITHIN_STD * np.asarray(self.std), 0.0)
        seen = beyond > tolerance + half_width
        hidden = (beyond > tolerance) & ~seen & (half_width > WIDE * self.sensed_range)
        return np.asarray(seen), np.asarray(hidden)


class MissedTarget:
    """Where the estimate of a closed loop was too far from its target.

    Parameters
    ----------
    recording
        A closed loop with target and estimate.
    suffix
        The ending of the columns of its quantity.
    judged
        The samples with a target, (n_times,): those after the approach.

    Attributes
    ----------
    away
        By how much the estimate is above the target, (n_times,), in the quantity's unit.
    rows
        The samples at which the target was missed, (n_times,); none of an interrupted run, or if they are few.
    hidden
        Those at which it may have been, but the interval is too wide to say, likewise.
    """

    def __init__(self, recording: Recording, suffix: str, judged: npt.NDArray[np.bool_]) -> None:
        """Look at every sample."""
        target, estimate = recording[f"target_{suffix}"], recording[f"estimated_{suffix}"]
        self.away: FloatArray = estimate - target
        sensed_range = recording.facts.number_or_none("sensed_range") or float(np.abs(target).max())
        time_s = recording["time_s"]
        per_s = 1.0 / float(np.median(np.diff(time_s))) if time_s.size > 1 else 1.0
        announced = recording.columns.get("announced_miss", np.zeros(target.size))
        seen = SeenLoop(
            target,
            estimate,
            recording.columns.get("estimate_std", 0.0),
            recording.columns.get("valid", 1.0),
            *within_last(round(MAY_LAG_S * per_s), announced),
            sensed_range,
        )
        whole = recording.facts.text_or_none("ended") != "interrupted"
        few = MAX_MISSED * judged.sum()
        found = (rows & judged & whole for rows in seen.misses())
        self.rows, self.hidden = (rows & (rows.sum() > few) for rows in found)


def within_last(length: int, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and the largest of each value and so many before it, (n_times,) each."""
    seen = sliding_window_view(np.concatenate([np.full(length, values[0]), values]), length + 1)
    return seen.min(axis=1), seen.max(axis=1)


class MissWatch:
    """Says of a loop that runs for how long it has missed its target, once that has lasted.

    Parameters
    ----------
    suffix
        The ending of the columns of its quantity.
    sensed_range
        How far the model senses, in the unit of the quantity.
    approach_s
        Time [s] before which nothing is missed.
    """

    def __init__(self, suffix: str, sensed_range: float, approach_s: float) -> None:
        """Begin with nothing missed."""
        self._suffix, self._sensed_range, self._approach_s = suffix, sensed_range, approach_s
        self._since_s = math.inf
        self._announced: deque[tuple[float, float]] = deque()

    def after(self, row: Mapping[str, float | None]) -> str:
        """Return what is to be said after a row of the loop; "" while it is on its way, or there.

        Parameters
        ----------
        row
            A recorded row, with its time.
        """
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
