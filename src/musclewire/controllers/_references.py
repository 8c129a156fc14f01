"""Target trajectories as pure functions of time.

``staircase`` is the paper's step experiment (Fig. 11, Table 2): 1.5, 1.8, ... 3.0 % strain and back, six
seconds each. Targets are in the unit of the controlled quantity: strain as a fraction, metres or newtons.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError

Direction: TypeAlias = Literal["rise", "return"]
# A clock that adds up ticks may be a rounding error before the time of a step; that counts as the time of the step.
CLOCK_TOLERANCE_S = 1e-9


class Reference(Protocol):
    """A target over time, as a closed loop follows it."""

    @property
    def duration_s(self) -> float:
        """Duration [s]."""

    def target_at(self, time_s: float) -> float:
        """Return the target; before 0 and after the end the first and the last target hold."""

    def targets_at(self, time_s: ArrayLike) -> FloatArray:
        """Return the targets in the shape of the times."""


class HeldTargets:
    """Targets, each held from its time on until the next (zero-order hold); before the first time the first holds."""

    # Each reference sets them: rising times [s], and the targets that hold from them on.
    _starts_s: list[float]
    _held: list[float]

    def target_at(self, time_s: float) -> float:
        """Return the target at a finite time."""
        if not math.isfinite(time_s):
            raise CallerError(f"asked for the target at time {time_s} s; give a finite time")
        index = bisect_right(self._starts_s, time_s + CLOCK_TOLERANCE_S) - 1
        return self._held[index if index > 0 else 0]

    def targets_at(self, time_s: ArrayLike) -> FloatArray:
        """Return the targets in the shape of the times, all finite."""
        times = np.asarray(time_s, dtype=np.float64)
        if not np.isfinite(times).all():
            raise CallerError(f"asked for the target at {times[~np.isfinite(times)][0]} s; give finite times")
        places = np.searchsorted(self._starts_s, times + CLOCK_TOLERANCE_S, side="right") - 1
        return np.asarray(self._held, dtype=np.float64)[np.maximum(places, 0)]


@dataclass(frozen=True, slots=True)
class Step:
    """One level of a staircase, from ``start_s`` (included) to ``stop_s`` (not included)."""

    index: int  # from 0
    target: float  # strain as a fraction, displacement [m] or force [N]
    direction: Direction
    start_s: float
    stop_s: float


@dataclass(frozen=True)
class Staircase(HeldTargets):
    """Levels held for the same time each, from time zero on.

    Before time zero the target is the first level, after the end the last. Raises CallerError for no level, a level
    that is not finite, or a hold time that is not above zero.
    """

    levels: tuple[float, ...]  # targets: strain as a fraction, displacement [m] or force [N]
    hold_s: float  # duration of each

    def __post_init__(self) -> None:
        """Keep the levels as plain numbers and check them."""
        levels = np.asarray(self.levels, dtype=np.float64)
        if levels.ndim != 1 or levels.size == 0 or not np.isfinite(levels).all():
            raise CallerError(f"a staircase needs a list of finite levels, not {self.levels}")
        if not (math.isfinite(self.hold_s) and self.hold_s > 0.0):
            raise CallerError(f"hold_s is {self.hold_s} and must be above zero")
        starts_s = [index * self.hold_s for index in range(levels.size)]
        vars(self).update(levels=tuple(levels.tolist()), _held=levels.tolist(), _starts_s=starts_s)

    @property
    def duration_s(self) -> float:
        """The end of the last level [s]."""
        return len(self.levels) * self.hold_s

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        """Every level with its direction and times; a level equal to the one before keeps its direction."""
        steps: list[Step] = []
        direction: Direction = "rise"
        for index, level in enumerate(self.levels):
            if steps and level != steps[-1].target:
                direction = "rise" if level > steps[-1].target else "return"
            steps.append(Step(index, level, direction, index * self.hold_s, (index + 1) * self.hold_s))
        return tuple(steps)


@dataclass(frozen=True, eq=False)
class SampledReference(HeldTargets):
    """A target given at certain times and held until the next (zero-order hold).

    Before the first time the target is the first value, after the last time the last.
    """

    time_s: FloatArray  # rising times, shape (n,)
    target: FloatArray  # the target from each time on, shape (n,): strain as a fraction, displacement [m] or force [N]

    def __post_init__(self) -> None:
        """Keep the columns as plain numbers, too."""
        vars(self).update(_starts_s=self.time_s.tolist(), _held=self.target.tolist())

    @property
    def duration_s(self) -> float:
        """The last given time [s]."""
        return float(self.time_s[-1])


def as_shown(value: float, shown_as: tuple[float, str]) -> str:
    """Return a number in the factor and unit of a message."""
    factor, unit = shown_as
    return f"{factor * value:.6g} {unit}".rstrip()


def staircase(
    start: float = 0.015,
    stop: float = 0.030,
    increment: float = 0.003,
    hold_s: float = 6.0,
    return_trip: bool = True,
    *,
    shown_as: tuple[float, str] = (1.0, ""),
) -> Staircase:
    """Return the paper's staircase (Fig. 11): up in equal increments and back.

    The top belongs to the rise and appears once. Levels are rounded to 12 digits, so 0.018 is 0.018.

    Parameters
    ----------
    start
        First level: strain as a fraction, displacement [m] or force [N]. The paper's is 1.5 %.
    stop
        Top level, in the same unit; the paper's is 3.0 %.
    increment
        From level to level, in the same unit; the paper's is 0.3 %.
    hold_s
        Duration of each level [s]; 6 s in the paper.
    return_trip
        Whether it also returns to the first level, as in the paper.
    shown_as
        Factor and unit in which messages name levels, as 100 and "%".

    Returns
    -------
    The staircase.

    Raises
    ------
    CallerError
        For an increment or hold not above zero, a stop not above the start, or increments that miss ``stop``.

    References
    ----------
    Lan and Fan 2010, Fig. 11 and Table 2.

    Examples
    --------
    >>> import musclewire as mw
    >>> mw.staircase(start=0.015, stop=0.021).levels
    (0.015, 0.018, 0.021, 0.018, 0.015)
    """
    if not all(math.isfinite(value) for value in (start, stop, increment)):
        raise CallerError(f"staircase from {start} to {stop} by {increment}: every number must be finite")
    if increment <= 0.0 or stop <= start:
        first, last, step = (as_shown(value, shown_as) for value in (start, stop, increment))
        raise CallerError(
            f"staircase from {first} to {last} by {step}: stop must be above start and the increment above zero"
        )
    count = round((stop - start) / increment)
    if count < 1 or abs(start + count * increment - stop) > 1e-9 * (abs(start) + abs(stop)):
        nearest = (stop - start) / max(count, 1)
        first, last, step, near = (as_shown(value, shown_as) for value in (start, stop, increment, nearest))
        raise CallerError(f"staircase from {first} to {last}: increments of {step} miss the stop; try {near}")
    rise = [float(f"{start + index * increment:.12g}") for index in range(count + 1)]
    return Staircase(tuple(rise + rise[-2::-1] if return_trip else rise), float(hold_s))


def sampled_reference(time_s: ArrayLike, target: ArrayLike) -> SampledReference:
    """Return a reference from two columns, each target held until the next time.

    Parameters
    ----------
    time_s
        Increasing times [s], (n,), from 0 at the reference's start.
    target
        The target from each of these times on, (n,): strain as a fraction, displacement [m] or force [N].

    Returns
    -------
    The reference; it keeps copies.

    Raises
    ------
    CallerError
        For empty columns or columns of different length, a value that is not finite, or times that do not increase.

    Examples
    --------
    >>> import musclewire as mw
    >>> mw.sampled_reference([0.0, 5.0], [0.015, 0.02]).target_at(6.0)
    0.02
    """
    times = np.array(time_s, dtype=np.float64)
    targets = np.array(target, dtype=np.float64)
    if times.ndim != 1 or times.shape != targets.shape or times.size == 0:
        raise CallerError(f"a reference needs two columns of one length, not shapes {times.shape} and {targets.shape}")
    if not (np.isfinite(times).all() and np.isfinite(targets).all()):
        row = int(np.argmin(np.isfinite(times) & np.isfinite(targets)))
        raise CallerError(f"the reference holds a value that is not finite, first in row {row}; remove that row")
    if (np.diff(times) <= 0.0).any():
        row = int(np.argmax(np.diff(times) <= 0.0)) + 1
        raise CallerError(f"the times of the reference must increase; row {row} has {times[row]} s; sort the rows")
    return SampledReference(times, targets)
