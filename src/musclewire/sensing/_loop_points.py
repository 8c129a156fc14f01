"""Points A, B and C of one half cycle, and the fall of resistance from B to C that defines them (Fig. 3b)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.sensing._resistance_maximum import ResistanceMaximum, resistance_maximum
from musclewire.sensing._turning_points import HalfCycle, SmoothedRecording

# The maximum next to C is B if the resistance falls from it by this fraction of the largest fall: the cold end of a
# recording may read more than B does.
MAIN_FALL = 0.8
# A is the last sample before B whose resistance is within both of these of the coldest one:
COLD_NOISES = 3.0  # standard deviations of the noise
COLD_FRACTION = 0.02  # of the rise from the coldest sample to B


@dataclass(frozen=True)
class LoopPoints:
    """A, B, C of one half cycle as indices into the usable samples, from cold to hot, with B between samples."""

    a: int
    b: int
    c: int
    at_b: ResistanceMaximum
    returns_cold: bool
    complete: bool


def points_of(half: HalfCycle, measured_ohm: FloatArray, curves: SmoothedRecording) -> LoopPoints:
    """Return A, B, C of a half cycle: B and C span the main fall of resistance, A is the last cold sample before B.

    A cooling half cycle is read backwards. Where the half cycle does not return to cold, B is its turning point.
    """
    inside = slice(half.first, half.last + 1)
    step = 1 if half.rising else -1
    measured, resistance = measured_ohm[inside][::step], curves.resistance_ohm[inside][::step]
    b, c = fall_from_b_to_c(resistance, curves.min_bump_ohm)
    rise = float(resistance[b] - resistance[: b + 1].min())
    returns_cold = rise > curves.min_bump_ohm
    at_b = ResistanceMaximum(float(b), float(resistance[b]))
    if returns_cold:
        fall = float(resistance[b] - resistance[c])
        at_b = resistance_maximum(measured[:c], resistance[:c], b, fall, curves.resistance_noise_ohm)
        b = round(at_b.place)
    a = last_cold(resistance[: b + 1], curves.resistance_noise_ohm) if returns_cold else b
    complete = float(resistance[c:].max() - resistance[c]) > curves.min_bump_ohm
    origin = half.first if half.rising else half.last
    at_b = at_b._replace(place=origin + step * at_b.place)
    return LoopPoints(origin + step * a, origin + step * b, origin + step * c, at_b, returns_cold, complete)


def fall_from_b_to_c(resistance_ohm: FloatArray, min_bump_ohm: float) -> tuple[int, int]:
    """Return the samples of B and C on a half cycle from cold to hot, which span the largest fall of resistance.

    A maximum nearer to C, from which the resistance falls by nearly as much, is B, however much a cold wire reads.
    """
    highest = np.maximum.accumulate(resistance_ohm)
    c = int(np.argmax(highest - resistance_ohm))
    to_c = resistance_ohm[: c + 1]
    ahead = np.maximum.accumulate(to_c[::-1])[::-1]
    fall = float(highest[c] - to_c[c])
    colder = np.flatnonzero((ahead - to_c > min_bump_ohm) & (ahead - to_c[c] >= MAIN_FALL * fall))
    start = int(colder[-1]) if colder.size else 0
    return start + int(np.flatnonzero(to_c[start:] == ahead[start])[-1]), c


def last_cold(resistance_ohm: FloatArray, noise_ohm: float) -> int:
    """Return the last sample of resistances up to B that counts as coldest, in spite of the noise left in them."""
    coldest = float(resistance_ohm.min())
    tolerance = min(COLD_NOISES * noise_ohm, COLD_FRACTION * (float(resistance_ohm[-1]) - coldest))
    return int(np.flatnonzero(resistance_ohm <= coldest + tolerance)[-1])
