"""Turning points of a recording: the cold and hot ends of its branches."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.sensing._branches import MAX_WINDOW_FRACTION
from musclewire.sensing._smoothing import noise_level, smooth, smoothed_noise, smoothing_window

# A swing of less than this fraction of the whole stroke is a ripple of a branch and not a cycle.
MIN_SWING = 0.2
# Samples within this fraction of the stroke from an end may belong to the dwell there.
END_FRACTION = 0.02
# A bump of the resistance counts from this many times the noise and from this fraction of the whole range.
BUMP_NOISES = 6.0
BUMP_FRACTION = 0.005


@dataclass(frozen=True, eq=False)
class SmoothedRecording:
    """A smoothed recording: columns of shape (n,), the noise that remains, and the minimum height of a bump."""

    resistance_ohm: FloatArray
    strain: FloatArray
    resistance_noise_ohm: float
    strain_noise: float
    min_bump_ohm: float


@dataclass(frozen=True)
class HalfCycle:
    """Samples ``first`` to ``last`` (both included) between two turning points; ``rising`` is heating."""

    first: int
    last: int
    rising: bool


def smoothed(resistance_ohm: FloatArray, strain: FloatArray, branches: int) -> SmoothedRecording:
    """Smooth both columns over at most 3 % of one of ``branches`` equal branches."""
    max_window = int(MAX_WINDOW_FRACTION * resistance_ohm.size / max(branches, 1))
    columns, noises = [], []
    for column in (resistance_ohm, strain):
        noise = noise_level(column)
        window = smoothing_window(noise, float(np.ptp(column)), max_window)
        columns.append(smooth(column, window))
        noises.append(smoothed_noise(noise, window))
    bump = max(BUMP_NOISES * noises[0], BUMP_FRACTION * float(np.ptp(columns[0])))
    return SmoothedRecording(columns[0], columns[1], noises[0], noises[1], bump)


def turning_points(values: FloatArray, min_swing: float) -> tuple[list[int], bool]:
    """Return indices of alternating extremes that differ by ``min_swing``, and whether the first is low."""
    # Plain numbers in a list: those of an array take three times as long to look at.
    samples: list[float] = np.asarray(values, dtype=np.float64).tolist()
    found: list[int] = []
    rising = starts_low = False
    low = high = 0
    for index, value in enumerate(samples):
        if value > samples[high]:
            high = index
        if value < samples[low]:
            low = index
        if (rising or not found) and samples[high] - value > min_swing:
            rising, low = False, index
            found.append(high)
        elif (not rising or not found) and value - samples[low] > min_swing:
            rising, high = True, index
            starts_low = starts_low or not found
            found.append(low)
    if found:
        found.append(high if rising else low)
    return found, starts_low


def half_cycles(curves: SmoothedRecording, turns: list[int], starts_low: bool) -> list[HalfCycle]:
    """Cut the recording into heating and cooling half cycles at turning points of strain, refined by resistance.

    Strain saturates at the hot end, rests in a dwell or sticks in the guide while resistance keeps changing: within 2 %
    of the stroke of each extreme the turning point is that of the resistance.
    """
    refined = [_refined_turn(curves, turns, k, starts_low ^ bool(k % 2)) for k in range(len(turns))]
    return [
        HalfCycle(first, last, starts_low ^ bool(k % 2))
        for k, (first, last) in enumerate(pairwise(refined))
        if last > first
    ]


def _refined_turn(curves: SmoothedRecording, turns: list[int], k: int, cold: bool) -> int:
    """Return turning point ``k`` by the resistance, or at an end of the recording the far side of its dwell."""
    sign = 1.0 if cold else -1.0
    inner_first = turns[k - 1] + 1 if k > 0 else 0
    inner_last = turns[k + 1] - 1 if k + 1 < len(turns) else curves.strain.size - 1
    # Mirrored for a hot end, so that every end is a low one.
    height = sign * curves.strain[inner_first : inner_last + 1]
    extreme = height[turns[k] - inner_first]
    neighbours = [sign * curves.strain[turns[j]] for j in (k - 1, k + 1) if 0 <= j < len(turns)]
    tolerance = max(END_FRACTION * (min(neighbours) - extreme), 4.0 * curves.strain_noise)
    near = np.flatnonzero(height <= extreme + tolerance) + inner_first
    if k == 0:
        return int(near[0])
    if k == len(turns) - 1:
        return int(near[-1])
    first, last = int(near[0]), int(near[-1])
    inside = -sign * curves.resistance_ohm[first : last + 1]
    (passed, excursion), (turned, dip) = _highest_bump(inside), _highest_bump(-inside)
    # An excursion beyond C (or back to A) separates the two passes; without one the dip is the turning point.
    if excursion > curves.min_bump_ohm or excursion > dip:
        return first + passed
    return first + (turned if dip > 0.0 else int(np.argmin(inside)))


def _highest_bump(values: FloatArray) -> tuple[int, float]:
    """Return the index of the maximum with the largest height above the minima on both sides, and that height.

    At a hot end, given the resistance, this is the hottest moment between the two passes of C; given the
    negative resistance it is C itself, where a minor loop turns. At a cold end the signs are swapped.
    """
    above_left = values - np.minimum.accumulate(values)
    above_right = values - np.minimum.accumulate(values[::-1])[::-1]
    bump = np.minimum(above_left, above_right)
    index = int(np.argmax(bump))
    return index, float(bump[index])
