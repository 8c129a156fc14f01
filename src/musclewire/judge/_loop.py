"""A closed loop as its judges see it: what follows from its columns, each worked out once, whoever asks."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.sensing import SHOWN_AS
from musclewire.signals import COLUMN_SUFFIX, Recording, reference_quantity

Mask = npt.NDArray[np.bool_]
Answer = TypeVar("Answer")
# Eq. 7 counts "sequentially after one second of each step (till the end of each step)".
SETTLE_S = 1.0
# [s] for which its estimates have been valid when a wire is sensed.
SENSED_S = 0.5
AT_LIMIT = 0.01  # of a limit of the drive: within it the drive is at the limit
NOT_REACHED = 0.05  # of the range of targets: a target that is off by more has not been reached


def in_windows(extreme: np.ufunc, values: FloatArray, length: int) -> FloatArray:
    """Return the minimum or maximum of each value and those after it, so many in total, (n_times - length + 1,)."""
    # In windows of twice the length each time: of a view of all windows NumPy takes ten times as long.
    reached = 1
    while reached < length:
        further = min(reached, length - reached)
        values, reached = extreme(values[:-further], values[further:]), reached + further
    return values


class Cause(IntEnum):
    """What an estimator may find wrong; the number is what it records in the column ``health``."""

    NONE = 0
    CHANGED_LOAD = 2
    """Force or stiffness of the load differ from those of the characterization."""
    CHANGED_AIR = 3
    """Temperature or flow of the air differ from those of the characterization."""
    OTHER_WIRE = 4
    """The resistance is not that of the wire of the model: another wire, or one that has aged."""


class DetectedRows(NamedTuple):
    """What a detector has found: the samples, (n_times,), and what says their numbers in words; "" for none."""

    rows: Mask
    in_words: Callable[[], str] = str


class JudgedLoop:
    """A recording of a closed loop, with all that several detectors need of it; what is no loop has no ``suffix``."""

    def __init__(self, recording: Recording) -> None:
        """Work nothing out yet."""
        self.recording, self.facts = recording, recording.facts
        self._answers: dict[Callable[[JudgedLoop], Any], Any] = {}

    def once(self, asked: Callable[[JudgedLoop], Answer]) -> Answer:
        """Return what a function says of this loop; it is asked once."""
        if asked not in self._answers:
            self._answers[asked] = asked(self)
        answer: Answer = self._answers[asked]
        return answer

    def column(self, name: str, without: float) -> FloatArray:
        """Return a column, or a number at each sample for a recording that lacks it, (n_times,)."""
        return self.recording[name] if name in self.recording else np.full(len(self.recording), without)

    @cached_property
    def suffix(self) -> str:
        """The ending of the columns of the quantity that was controlled; "" of what is no closed loop."""
        suffix = next((one for one in COLUMN_SUFFIX.values() if f"target_{one}" in self.recording), "")
        return suffix if len(self.recording) and f"estimated_{suffix}" in self.recording else ""

    @cached_property
    def quantity(self) -> str:
        """The quantity that was controlled."""
        return next(name for name, one in COLUMN_SUFFIX.items() if one == self.suffix)

    @property
    def shown_as(self) -> tuple[float, str]:
        """Factor and unit in which the quantity is shown."""
        return SHOWN_AS[self.quantity]

    @cached_property
    def time_s(self) -> FloatArray:
        """Time [s]."""
        return self.recording["time_s"]

    @cached_property
    def period_s(self) -> float:
        """Time between two samples [s]."""
        return float(np.median(np.diff(self.time_s))) if self.time_s.size > 1 else 1.0

    @cached_property
    def drive_voltage_v(self) -> FloatArray:
        """Drive [V]."""
        return self.recording["drive_voltage_v"]

    @cached_property
    def target(self) -> FloatArray:
        """The target, in the unit of the quantity, as the next three."""
        return self.recording[f"target_{self.suffix}"]

    @cached_property
    def estimate(self) -> FloatArray:
        """The estimate."""
        return self.recording[f"estimated_{self.suffix}"]

    @cached_property
    def std(self) -> FloatArray:
        """Its standard deviation; 0 without one."""
        return self.column("estimate_std", 0.0)

    @cached_property
    def error(self) -> FloatArray | None:
        """Its error against the instrument; None without an instrument or a stated deviation."""
        measured = reference_quantity(self.recording, self.quantity)
        if measured is None or "estimate_std" not in self.recording:
            return None
        return np.asarray(self.estimate - measured)

    @cached_property
    def valid(self) -> Mask:
        """Whether the estimate is valid; everywhere, where that is not recorded."""
        return np.asarray(self.column("valid", 1.0) > 0.0)

    @cached_property
    def sensed(self) -> Mask:
        """The samples from the first valid ``SENSED_S`` on, all if none: cold of B no strain is determined."""
        if "valid" not in self.recording:
            return self.since(0)
        length = max(round(SENSED_S / self.facts.sample_period_s), 1)
        valid = np.concatenate([[0], np.cumsum(self.valid)])
        begins = np.flatnonzero(valid[length:] - valid[:-length] == length)
        return self.since(int(begins[0]) if begins.size else 0)

    @cached_property
    def counted(self) -> Mask:
        """The samples after the approach, or after the first second if there was none."""
        # Of a recording of another program, too, which need not state them.
        approach_s, period_s = (self.facts.number_or_none(name) or 0.0 for name in ("approach_s", "sample_period_s"))
        elapsed_s = self.time_s - self.time_s[0] + period_s - approach_s
        return np.asarray(elapsed_s > (1e-9 if approach_s > 0.0 or elapsed_s[-1] <= SETTLE_S else SETTLE_S))

    @cached_property
    def valid_share(self) -> float:
        """The fraction of valid samples among those at which the loop should have been sensed."""
        return float(np.mean(self.valid[self.counted & self.sensed]))

    @cached_property
    def with_target(self) -> Mask:
        """The samples after the approach."""
        approach_s = self.facts.number_or_none("approach_s") or 0.0
        return np.asarray(self.time_s - self.time_s[0] > approach_s - 0.5 * self.period_s)

    @cached_property
    def holds(self) -> list[slice]:
        """The stretches with one target."""
        starts = np.flatnonzero(np.append(True, np.diff(self.target) != 0.0)).tolist()
        return [slice(*ends) for ends in zip(starts, [*starts[1:], self.target.size], strict=True)]

    @cached_property
    def away(self) -> FloatArray:
        """By how much the estimate is above the target."""
        return self.estimate - self.target

    @cached_property
    def off_target(self) -> FloatArray:
        """1 where the estimate is well above the target, -1 where well below, after approach and first B; else 0."""
        enough = NOT_REACHED * max(float(np.ptp(self.target)), 0.1 * float(np.abs(self.target).max()))
        return np.where(self.with_target & self.sensed & (np.abs(self.away) > enough), np.sign(self.away), 0.0)

    @cached_property
    def at_upper_limit(self) -> Mask:
        """The samples at which the drive is at its upper limit."""
        high_v = self.facts.number_or_none("limit_maximum_voltage_v")
        return np.asarray(self.drive_voltage_v >= (high_v or np.inf) * (1.0 - AT_LIMIT))

    @cached_property
    def at_lower_limit(self) -> Mask:
        """The samples at which it is at its lower limit."""
        low_v = self.facts.number_or_none("limit_sense_voltage_v")
        return np.asarray(self.drive_voltage_v <= (low_v or 0.0) * (1.0 + AT_LIMIT))

    @cached_property
    def power_limited(self) -> Mask:
        """The samples at which the controller gave no more, since that holds the highest temperature."""
        return np.asarray(self.column("power_limited", 0.0) > 0.0)

    def since(self, row: int | None) -> Mask:
        """Return the samples from a row on; none of None."""
        return np.arange(len(self.recording)) >= (len(self.recording) if row is None else row)

    def since_first(self, rows: npt.NDArray[np.intp]) -> Mask:
        """Return the samples from the first of some rows on; none of no rows."""
        return self.since(int(rows[0]) if rows.size else None)

    def recorded(self, cause: Cause) -> Mask:
        """Return the samples at which the estimator has recorded a cause."""
        return np.asarray(self.column("health", 0.0) == float(cause))
