"""Warming of a wire from its electrical power and, by its resistance, its latent heat; which points of it are seen.

By the heat balance, less L dx/dt, with the transformed fraction x read from the resistance, which falls with it (Lan
and Fan 2010, Fig. 3b). Nothing else of the wire enters.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.judge import resistance_reading
from musclewire.sensing import ResistanceExtremes, find_resistance_extremes
from musclewire.signals import Recording
from musclewire.wire import HeatBalance

# Grid of a branch over its warming: finer than the error of the warming itself.
BRANCH_POINTS = 160
# A course is resampled to this fraction of the lag.
STEPS_PER_LAG = 6.0
MAX_GRID = 4000
MIN_SAMPLES = 40


class HeatCourse(NamedTuple):
    """A wire heated and cooled once: what its voltages show, sample by sample, each of shape (n_times,)."""

    time_s: FloatArray
    power_w: FloatArray
    resistance_ohm: FloatArray

    def evenly(self, step_s: float) -> HeatCourse:
        """Return the course on an even grid of times."""
        length_s = float(self.time_s[-1] - self.time_s[0])
        count = min(max(int(length_s / step_s), MIN_SAMPLES), MAX_GRID)
        grid = np.linspace(float(self.time_s[0]), float(self.time_s[-1]), count + 1)
        return HeatCourse(
            grid, np.interp(grid, self.time_s, self.power_w), np.interp(grid, self.time_s, self.resistance_ohm)
        )

    def warming_k(self, heat: HeatBalance, latent_k_per_ohm: float) -> FloatArray:
        """Return the wire's temperature above the air [K], (n_times,), by its nominal loss."""
        begins_k, heat_j_per_ohm = heat.steady_k(float(self.power_w[0])), -heat.capacity_j_per_k * latent_k_per_ohm
        return heat.along_k(self.time_s, self.power_w, self.resistance_ohm, heat_j_per_ohm, begins_k) - heat.air_k


def heating_branch(course: HeatCourse, warming_k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return warming [K] and resistance [ohm] of a course's way up, averaged over equal steps of warming."""
    turn = int(np.argmax(warming_k))
    coldest = int(np.argmin(warming_k[: turn + 1]))  # a loop's first samples may belong to the cooling before it
    return averaged(warming_k[coldest : turn + 1], course.resistance_ohm[coldest : turn + 1])


def averaged(warming_k: FloatArray, resistance_ohm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return means of both over equal steps of warming, steps without a sample left out."""
    low, high = float(warming_k.min()), float(warming_k.max())
    place = np.floor((warming_k - low) / max(high - low, 1e-9) * (BRANCH_POINTS - 1e-9)).astype(np.intp)
    count = np.bincount(place, minlength=BRANCH_POINTS)
    there = count > 0
    means = [np.bincount(place, values, BRANCH_POINTS)[there] / count[there] for values in (warming_k, resistance_ohm)]
    return means[0], means[1]


def course_of(recording: Recording) -> HeatCourse:
    """Return the heating course of a recording. Raises RecordingError without voltages or enough samples."""
    reading = resistance_reading(recording)
    if "wire_voltage_v" not in recording:
        raise RecordingError("a home move compares power, which needs wire_voltage_v next to the resistance: record it")
    there = reading.valid
    if int(there.sum()) < MIN_SAMPLES:
        raise RecordingError(f"{int(there.sum())} samples with current: a home move needs at least {MIN_SAMPLES}")
    resistance = reading.resistance_ohm[there]
    power = recording["wire_voltage_v"][there] ** 2 / resistance
    return HeatCourse(recording["time_s"][there], power, resistance)


# The resistance has levelled off where it falls with power by less than this fraction of its steepest fall. The shipped
# wire reaches 0.1 at the highest drive that its file allows.
LEVEL_FRACTION = 0.1
PIECES = 40  # intervals of equal power into which the way up is divided, to average the noise
SLOPE_PIECES = 4  # intervals over which the slope of the fall is taken


class SeenPoints(NamedTuple):
    """Points B and C of a course, None for one that it does not show."""

    heating_b_ohm: float | None  # on the way up
    cooling_b_ohm: float | None  # on the way down; on some wires there is no maximum
    c_ohm: float | None  # if the resistance rises again or has levelled off
    lowest_ohm: float  # on the way up, C or merely where the drive turned


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


def shows_c(recording: Recording) -> bool | None:
    """Return whether the last cycle's resistance rises again or levels off; None without transformation or power."""
    if "cycle" not in recording or "wire_voltage_v" not in recording:
        return None
    try:
        reading = resistance_reading(recording)
        last = reading.valid & (recording["cycle"] == recording["cycle"].max())
        resistance = reading.resistance_ohm[last]
        power = recording["wire_voltage_v"][last] ** 2 / resistance
        if not np.isfinite(power).all() or power.size == 0:
            return None
        return seen_points(HeatCourse(recording["time_s"][last], power, resistance)).c_ohm is not None
    except RecordingError:
        return None
