"""A drive that swings to and fro while one target holds, whatever controls it: by its recording alone."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.signals import Recording

# The drive oscillates that turns so often at one target, each time by more than this swing [V] and within this time [s]
# of the turn before: dead times up to 0.3 s give periods of 0.4 to 2 s. A slow change and two gusts are none.
MIN_TURNS, SWING_V, HALF_PERIOD_S = 3, 0.5, 1.5
# A step takes the drive to and fro, too: what comes so soon after it [s] does not count.
SETTLING_S = 1.0


class Oscillation:
    """Where the drive of a closed loop swings at a target that holds.

    Parameters
    ----------
    recording
        A closed loop with drive and target.
    suffix
        The ending of the columns of its quantity.

    Attributes
    ----------
    rows
        The samples between the turns of such a drive, (n_times,).
    largest_v
        Its largest swing [V], peak to peak; 0 if there is none.
    period_s
        Its mean period [s]; 0 if there is none.
    """

    def __init__(self, recording: Recording, suffix: str) -> None:
        """Look at every hold."""
        target, drive_v, time_s = recording[f"target_{suffix}"], recording["drive_voltage_v"], recording["time_s"]
        starts = np.flatnonzero(np.append(True, np.diff(target) != 0.0))
        self.rows: npt.NDArray[np.bool_] = np.zeros(target.size, dtype=np.bool_)
        half_s: list[float] = []
        self.largest_v = 0.0
        for start, end in zip(starts, np.append(starts[1:], target.size), strict=True):
            first = start + int(np.searchsorted(time_s[start:end], time_s[start] + SETTLING_S))
            if end - first < MIN_TURNS or np.ptp(drive_v[first:end]) <= SWING_V:
                continue
            turns = first + turns_of(drive_v[first:end], SWING_V)
            quick = np.diff(time_s[turns]) <= HALF_PERIOD_S
            for turn in np.flatnonzero(quick[1:] & quick[:-1]):
                among = turns[turn : turn + MIN_TURNS]
                self.rows[among[0] : among[-1] + 1] = True
                self.largest_v = max(self.largest_v, float(np.ptp(drive_v[among])))
                half_s.extend(np.diff(time_s[among]).tolist())
        self.period_s = 2.0 * float(np.mean(half_s)) if half_s else 0.0

    def __str__(self) -> str:
        """Return it in words."""
        return f"{self.largest_v:.1f} V peak to peak, period {self.period_s:.1f} s"


def turns_of(values: FloatArray, swing: float) -> npt.NDArray[np.intp]:
    """Return the rows of the extremes from which values went back by more than a swing."""
    turns: list[int] = []
    lowest = highest = 0
    rises: bool | None = None  # not known until they have gone by more than a swing
    for row, value in enumerate(values):
        highest = row if value > values[highest] else highest
        lowest = row if value < values[lowest] else lowest
        if rises is not False and values[highest] - value > swing:
            turns += [highest] if rises else []
            rises, lowest = False, row
        elif rises is not True and value - values[lowest] > swing:
            turns += [lowest] if rises is False else []
            rises, highest = True, row
    return np.array(turns, dtype=np.intp)
