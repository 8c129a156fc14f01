"""Rows that somebody put between the measured ones of a recording, by straight lines; measured rows alone are judged.

A loop of 71 readings that was drawn out to 1,420 rows holds no more than 71. Its noise does not scatter from row to
row, so that whatever learns noise from neighbouring rows takes it for a motion of the wire.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.identify._recordings import resistance_reading
from musclewire.signals import Recording

# A row is on the line between its neighbours within this part of its column's range: a file of seven digits or more
# shows it, and a converter's step is larger by far.
STRAIGHT_PART = 1e-6
# Interpolation puts about as many rows between any two measured ones, some at least: so large a part of the distances
# differs from their median by no more than this part of it, or by one row.
MIN_SPACING, REGULAR_PART, UNEVEN_PART = 5, 0.9, 0.25
# And none is farther than so many times their median: there rows would be left out that were measured.
MAX_SPACING_PART = 3.0
# Lines between measured readings bend by anything. A converter bends a steady slope by one step of its own, or by two:
# the bends of one curve, but for a tenth at either end, are at least so many times different.
OUTER_PERCENT, MIN_DIFFERENT = 10.0, 4.0
ELECTRICAL = ("wire_resistance_ohm", "wire_voltage_v", "shunt_voltage_v", "wire_current_a")
# Fewer measured rows than this show no rule.
MIN_MEASURED = 12


def measured_rows(recording: Recording) -> NDArray[np.intp] | None:
    """Return the rows of a recording whose electrical readings were measured; None if all were, or it does not show.

    Parameters
    ----------
    recording
        A recording with resistance, by any of its columns.

    Returns
    -------
    The rows, (n_measured,), rising, with the first and the last; None if rows are not interpolated by straight lines
    with a regular number of rows between two measured ones.
    """
    time_s = recording["time_s"]
    if time_s.size < MIN_SPACING * MIN_MEASURED:
        return None
    recorded = [bends_of(time_s, recording[name]) for name in ELECTRICAL if name in recording]
    bends = list(recorded)
    if "wire_resistance_ohm" not in recording:
        try:
            reading = resistance_reading(recording)
        except RecordingError:  # what is missing is said where it is needed, with all else that is missing
            return None
        bends.append(bends_of(time_s, np.where(reading.valid, reading.resistance_ohm, np.nan)))
    # Two of voltage, current and resistance may be on lines; the third is then their product or quotient.
    between = np.sum([bend <= STRAIGHT_PART for bend in bends], axis=0) >= min(2, len(bends))
    # A line whose bend lies between two rows bends at both: the first of them stands for the measured one.
    bent = ~between
    bent[1:] &= between[:-1]
    rows = np.union1d(np.flatnonzero(bent), time_s.size - 1)
    spacing = np.diff(rows)
    # Where measured rows follow each other, only a part was interpolated: all of it is taken as it is.
    if rows.size < MIN_MEASURED or np.median(spacing) < MIN_SPACING or np.sum(~between) > 2 * rows.size:
        return None
    if spacing.max() > MAX_SPACING_PART * np.median(spacing):
        return None
    uneven = max(1.0, UNEVEN_PART * float(np.median(spacing)))
    regular = np.mean(np.abs(spacing - np.median(spacing)) <= uneven) >= REGULAR_PART
    return rows if regular and any(bends_by_anything(bend, rows[1:-1]) for bend in recorded) else None


def bends_of(time_s: FloatArray, values: FloatArray) -> FloatArray:
    """Return how far each row lies off the line through its neighbours, as a part of the column's range, (n_times,).

    The ends are infinitely far off, as is a reading that stands still between its neighbours: a converter with coarse
    steps gives such, and it is on no line that anybody drew.
    """
    bends = np.full(values.size, np.inf)
    finite = values[np.isfinite(values)]
    span = float(np.ptp(finite)) if finite.size else 0.0
    if not span > 0.0:
        return bends
    step, after = np.diff(time_s)[:-1], np.diff(time_s)[1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        line = (values[:-2] * after + values[2:] * step) / (step + after)
    moves = np.abs(values[2:] - values[:-2]) > 2.0 * STRAIGHT_PART * span
    bends[1:-1] = np.where(moves & np.isfinite(line), np.abs(values[1:-1] - line) / span, np.inf)
    return np.where(np.isnan(bends), np.inf, bends)


def bends_by_anything(bends: FloatArray, rows: NDArray[np.intp]) -> bool:
    """Return whether a curve that is straight at most rows bends at the others by this and that."""
    there = bends[rows][np.isfinite(bends[rows])]
    if np.mean(bends <= STRAIGHT_PART) < 0.5 or there.size < MIN_MEASURED:
        return False
    small, large = np.percentile(there, [OUTER_PERCENT, 100.0 - OUTER_PERCENT])
    return bool(large > MIN_DIFFERENT * small and large > MIN_DIFFERENT * STRAIGHT_PART)


def kept_rows(recording: Recording, rows: NDArray[np.intp]) -> Recording:
    """Return a recording of some rows of another."""
    return Recording({name: values[rows] for name, values in recording.columns.items()}, recording.metadata)


def spread_over(recording: Recording, rows: NDArray[np.intp], columns: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Return columns of some rows of a recording for all its rows, on lines; valid is what lies between valid ones."""
    time_s = recording["time_s"]
    spread = {name: np.interp(time_s, time_s[rows], values) for name, values in columns.items()}
    return spread | {"valid": np.floor(spread["valid"])}


def said_of_interpolation(recording: Recording, rows: NDArray[np.intp]) -> str:
    """Return in words what was done about rows that nobody measured."""
    return (
        f"{len(recording) - rows.size} of {len(recording)} rows lie on straight lines between the {rows.size} that "
        "were measured, and say nothing of their own: all is judged at those that were measured"
    )
