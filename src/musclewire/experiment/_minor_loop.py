"""The minor loop after a slow sine: by it a fit finds what a wire does that turns around between its branches.

From the cold wire the drive goes the slow sine's own way up, turns where the resistance had fallen by half in the last
cycle, turns again where it was back to a third of that fall on cooling, goes up to the first turn and down to the sense
voltage. The wire's own way is then about two thirds, back to a third, two thirds and nothing: a turned drive still
holds heat that goes on to transform the wire, and below the resistance's maximum it had already moved.

So the wire turns in the middle of its hysteresis both ways, where a play and scaled copies of the branches are furthest
apart. The turns follow from the last cycle and are no fixed parts of the amplitude, because those differ from wire to
wire: at two thirds of it one wire has not begun to transform and another is through. At the slow sine's own pace the
wire lags behind the drive as it did in that cycle, so that it is where it was then; and on a way that the drive has
already gone nothing gets warmer than it was. At the end the wire is as cold as at that of a cycle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.errors import RecordingError
from musclewire.experiment._known_drive import KnownDrive
from musclewire.experiment._run import Decision, FollowingPart, Waveform
from musclewire.judge import resistance_reading
from musclewire.sensing import centred_mean
from musclewire.signals import NO_CYCLE, Command, Drive, RawSample, Recording

# The minor loop turns where the resistance has fallen by these fractions of its fall from B to C:
TURN_BACK = 0.5  # from heating to cooling
TURN_UP = 1.0 / 3.0  # from cooling to heating
# What a minor loop takes, in cycles, before its turns are known: thin wires need less, thick ones half as much again.
MINOR_LOOP_CYCLES = 1
# The resistance of a cycle is read as means over this part of it, about 2 s of the paper's: noise moves no turn.
MEAN_PART = 0.02


class MinorLoopTurns(NamedTuple):
    """Where a minor loop turns, as times from the start of a slow sine's heating half [s]: the upper and the lower."""

    back_s: float
    up_s: float

    @property
    def corners_s(self) -> tuple[float, ...]:
        """Times of start, turns and end of the minor loop [s]."""
        between_s = self.back_s - self.up_s
        return tuple(np.cumsum([0.0, self.back_s, between_s, between_s, self.back_s]).tolist())

    def drive_on(self, waveform: Waveform) -> Waveform:
        """Return the drive [V] over time [s] from the start of the minor loop, by the slow sine's."""
        corners_s, along_s = self.corners_s, (0.0, self.back_s, self.up_s, self.back_s, 0.0)
        return lambda time_s: waveform(float(np.interp(time_s, corners_s, along_s)))


def turns_after(recording: Recording, period_s: float, fall: float) -> MinorLoopTurns | None:
    """Return where a minor loop after a slow sine turns; None if resistance falls too little, or does not come back."""
    time_s = recording["time_s"]
    begun_s = float(time_s[-1]) - period_s
    try:
        reading = resistance_reading(recording)
    except RecordingError:  # no current: there is nothing to turn by
        return None
    rows = np.flatnonzero(reading.valid & (time_s > begun_s))
    if rows.size == 0:
        return None
    resistance_ohm = centred_mean(reading.resistance_ohm[rows], max(round(MEAN_PART * rows.size), 1))
    hottest = int(np.argmin(resistance_ohm))
    coldest_ohm, hottest_ohm = float(resistance_ohm.max()), float(resistance_ohm[hottest])
    if coldest_ohm - hottest_ohm < fall * coldest_ohm:
        return None
    fallen = (coldest_ohm - resistance_ohm) / (coldest_ohm - hottest_ohm)
    heating, cooling = (np.flatnonzero(one) for one in (fallen[:hottest] < TURN_BACK, fallen[hottest:] < TURN_UP))
    if not (heating.size and cooling.size):
        return None
    since_s = time_s[rows] - begun_s
    back_s = min(float(since_s[heating[-1]]), 0.5 * period_s)
    up_s = period_s - float(since_s[hottest + cooling[0]])
    return MinorLoopTurns(back_s, up_s) if up_s < back_s else None


class MinorLoopPolicy:
    """Plays a minor loop without feedback; its rows are of no cycle."""

    columns = ("cycle",)

    def __init__(self, waveform: Waveform, begun_s: float) -> None:
        """Play ``waveform``, which begins with the minor loop, at this time of the run."""
        self._waveform = waveform
        self._begun_s = begun_s

    def first_command(self) -> Command:
        """Return the waveform's start."""
        return Drive(self._waveform(0.0))

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:  # noqa: ARG002
        """Return the waveform's next value."""
        return Decision(Drive(self._waveform(elapsed_s - self._begun_s)), (NO_CYCLE,))

    def known_drive(self, elapsed_s: tuple[float, ...]) -> KnownDrive:
        """Return the waveform at the beginning of each sample."""
        drives_v = [self._waveform(0.0), *(self._waveform(time_s - self._begun_s) for time_s in elapsed_s[:-1])]
        return KnownDrive(np.array(drives_v), np.full((len(elapsed_s), 1), NO_CYCLE))


def minor_loop_after(recording: Recording, waveform: Waveform, period_s: float, fall: float) -> FollowingPart | None:
    """Return the minor loop that follows a slow sine; None for a wire that shows no transformation in it."""
    turns = turns_after(recording, period_s, fall)
    if turns is None:
        return None
    policy = MinorLoopPolicy(turns.drive_on(waveform), float(recording["time_s"][-1]))
    return FollowingPart(policy, turns.corners_s[-1])
