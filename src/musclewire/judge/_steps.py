"""What a loop does while a target holds: a drive that swings to and fro, a wire that goes well beyond and back.

A gap that takes less heat to cross than the slow loop says, or a wire that follows later than it did there, shows in
nothing else of a run: at the end of each step the target is reached.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.judge._known_strain import WITHIN_STD
from musclewire.judge._loop import DetectedRows, JudgedLoop

# A drive oscillates if it turns at one target this often, by this swing, in this time. A slow change or two gusts do
# not turn it that often.
MIN_TURNS = 3
SWING_V = 0.5  # [V] from one turn to the next
HALF_PERIOD_S = 1.5  # [s] from one turn to the next: dead times of up to 0.3 s give periods of 0.4 to 2 s
# A step takes the drive to and fro, too: what comes so soon after it [s] does not count.
SETTLING_S = 1.0
MAX_BEYOND = 0.1  # of the range of the wire's motion: a smaller overshoot, or one within the interval, does not count
MIN_STEPS = 3  # steps that overshoot: one or two are chance, or the first step from cold
# [s] for which a target holds to be a step; a reference that never stops changing has no steps.
HELD_S = 1.0


def overshoot(loop: JudgedLoop) -> DetectedRows:
    """Return the samples at which the estimate is too far beyond the target; none if steps with such are too few."""
    target, value, time_s = loop.target, loop.estimate, loop.time_s
    sensed = loop.sensed & np.isfinite(value) & loop.valid
    moved = float(np.ptp(value[sensed])) if sensed.any() else 0.0
    rows, beyond, n_steps = loop.since(None), [], 0
    for step in loop.holds:
        if time_s[step.stop - 1] - time_s[step.start] + loop.period_s < HELD_S:
            continue
        n_steps += 1
        past = np.sign(target[step.start] - value[step.start]) * (value[step] - target[step.start])
        # A wire that is on the far side still when the target comes has not gone there.
        counts = sensed[step] & np.logical_or.accumulate(past < 0.0)
        too_far = counts & (past > MAX_BEYOND * moved) & (past > WITHIN_STD * loop.std[step])
        if too_far.any():
            beyond.append(100.0 * float(past[too_far].max()) / moved)
            rows[step] = too_far
    if len(beyond) < MIN_STEPS:
        rows[:] = False
    return DetectedRows(
        rows, lambda: f"at {len(beyond)} of {n_steps} steps, by up to {max(beyond):.0f} % of the motion"
    )


def oscillation(loop: JudgedLoop) -> DetectedRows:
    """Return the samples between the turns of a drive that swings at a target that holds."""
    drive_v, time_s, rows = loop.drive_voltage_v, loop.time_s, loop.since(None)
    half_s: list[float] = []
    swings_v: list[float] = []
    for hold in loop.holds:
        first = hold.start + int(np.searchsorted(time_s[hold], time_s[hold.start] + SETTLING_S))
        held_v = drive_v[first : hold.stop]
        if held_v.size < MIN_TURNS or np.ptp(held_v) <= SWING_V:
            continue
        turns = first + turns_of(held_v, SWING_V)
        quick = np.diff(time_s[turns]) <= HALF_PERIOD_S
        for turn in np.flatnonzero(quick[1:] & quick[:-1]):
            among = turns[turn : turn + MIN_TURNS]
            rows[among[0] : among[-1] + 1] = True
            swings_v.append(float(np.ptp(drive_v[among])))
            half_s.extend(np.diff(time_s[among]).tolist())
    return DetectedRows(rows, lambda: f"{max(swings_v):.1f} V peak to peak, period {2.0 * np.mean(half_s):.1f} s")


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
