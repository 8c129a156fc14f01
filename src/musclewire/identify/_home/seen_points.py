"""Which of the points B and C a course really shows, on the way up and on the way down."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.identify._home.warming import HeatCourse
from musclewire.sensing import ResistanceExtremes, find_resistance_extremes

# The resistance has levelled off where it falls with power by less than this fraction of its steepest fall. The shipped
# wire reaches 0.1 at the highest drive that its file allows.
LEVEL_FRACTION = 0.1
# Pieces of equal power into which the way up is divided to see how it falls, and how many of them make a slope.
PIECES, SLOPE_PIECES = 40, 4


class SeenPoints(NamedTuple):
    """Points B and C of a course, None for one that it does not show.

    Parameters
    ----------
    heating_b_ohm
        Resistance at B on the way up [ohm].
    cooling_b_ohm
        Resistance at B on the way down [ohm]; on some wires there is no maximum.
    c_ohm
        Resistance at C [ohm], if it rises again or has levelled off.
    lowest_ohm
        Lowest resistance on the way up [ohm], C or merely where the drive turned.
    """

    heating_b_ohm: float | None
    cooling_b_ohm: float | None
    c_ohm: float | None
    lowest_ohm: float


def seen_points(course: HeatCourse) -> SeenPoints:
    """Return what a course from cold to hot and back shows. Raises RecordingError without any transformation."""
    turn = int(np.argmax(course.power_w))
    up = find_resistance_extremes(course.resistance_ohm[: turn + 1])
    levelled = has_levelled(course.power_w[: turn + 1], course.resistance_ohm[: turn + 1])
    return SeenPoints(
        heating_b_ohm=up.resistance_max_ohm if up.saw_b else None,
        cooling_b_ohm=b_on_the_way_down(course.resistance_ohm[turn:]),
        c_ohm=up.resistance_min_ohm if up.saw_c or levelled else None,
        lowest_ohm=up.resistance_min_ohm,
    )


def b_on_the_way_down(resistance_ohm: FloatArray) -> float | None:
    """Return the resistance at B of a cooling wire [ohm], None if there is no such maximum."""
    try:
        down: ResistanceExtremes = find_resistance_extremes(resistance_ohm[::-1])
    except RecordingError:
        return None
    return down.resistance_max_ohm if down.saw_b else None


def has_levelled(power_w: FloatArray, resistance_ohm: FloatArray, fraction: float = LEVEL_FRACTION) -> bool:
    """Return whether the resistance of a heating wire, (n_times,), has stopped falling at its hottest.

    Slopes are of means over pieces of equal power, so that noise and a dwell count little; the last one is compared
    with ``fraction`` of the steepest.
    """
    span_w = float(np.ptp(power_w))
    if power_w.size < PIECES or span_w <= 0.0:
        return False
    piece = np.floor((power_w - power_w.min()) / span_w * (PIECES - 1e-9)).astype(np.intp)
    count = np.bincount(piece, minlength=PIECES)
    there = count > 0
    mean = np.bincount(piece, resistance_ohm, PIECES)[there] / count[there]
    if mean.size <= 2 * SLOPE_PIECES:
        return False
    falls = mean[:-SLOPE_PIECES] - mean[SLOPE_PIECES:]
    steepest = float(falls.max())
    return bool(steepest > 0.0 and falls[-1] < fraction * steepest and np.argmax(falls) < falls.size - 1)
