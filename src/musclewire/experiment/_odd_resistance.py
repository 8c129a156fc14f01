"""Resistance that no wire of the model has once it is sensed: one that jumps, or is above all of the slow loop.

A contact that comes loose raises the resistance within one sample. A wire that cools takes many for as much, and one
that is heated lowers it. Above B no wire comes back, unless leads, load or the resistance itself have changed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from musclewire.arrays import FloatArray
from musclewire.experiment._first_heating import LIMIT_STDS, NOISY, KnownB
from musclewire.experiment._metrics import since_first_sensed
from musclewire.signals import Recording

# A rise within one sample, beyond those of its neighbours, is a jump from this part of the span from B to C on, and
# from so many standard deviations of a reading at its drive.
JUMP_PART, JUMP_NOISES = 0.04, 9.0
# It counts while the drive of so many samples lies within this factor: a wire that is switched turns, and a reading at
# another current may have another error.
STEADY_SAMPLES, STEADY_PART = 6, 0.8
# Above B counts what the mean of so many readings is: a moment's.
MEAN_SAMPLES = 5
# Of normally distributed noise the median size of a second difference of readings is so many standard deviations.
BEND_PER_STD = 0.6745 * 6.0**0.5


class OddResistance(NamedTuple):
    """Where a run's resistance is none of the model's wire.

    Parameters
    ----------
    jumps
        The rows before which it jumped, (n_jumps,).
    largest_jump_pct
        The largest of these jumps, in % of the span from B to C.
    above
        The rows at which it is above all that the slow loop showed, (n_above,).
    above_pct
        By how much at most, in % of the span.
    """

    jumps: npt.NDArray[np.intp]
    largest_jump_pct: float
    above: npt.NDArray[np.intp]
    above_pct: float


def odd_in(known: KnownB, resistance_ohm: FloatArray, drive_voltage_v: FloatArray) -> OddResistance:
    """Return where a wire that is past B has a resistance that none of the model's has.

    Parameters
    ----------
    known
        What the model's slow loop showed.
    resistance_ohm, drive_voltage_v
        Resistance [ohm] and drive [V] of the wire, (n_times,) each.

    Returns
    -------
    The rows.
    """
    span_ohm = known.b_ohm - known.c_ohm
    jumps, by_ohm = jumps_in(resistance_ohm, drive_voltage_v, span_ohm)
    read_well = drive_voltage_v > NOISY * known.sense_voltage_v
    above_ohm = running_mean(resistance_ohm, MEAN_SAMPLES) - known.highest_ohm
    above = running_mean(read_well.astype(np.float64), MEAN_SAMPLES) > 1.0 - 0.5 / MEAN_SAMPLES
    above &= above_ohm > LIMIT_STDS * known.std_ohm
    percent = 100.0 / span_ohm
    return OddResistance(
        jumps,
        percent * float(by_ohm[jumps].max(initial=0.0)),
        np.flatnonzero(above),
        percent * float(above_ohm[above].max(initial=0.0)),
    )


def jumps_in(
    resistance_ohm: FloatArray, drive_voltage_v: FloatArray, span_ohm: float
) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Return the rows before which the resistance of a wire at a steady drive has jumped up, and by how much all rise.

    A rise counts beyond those before and after it: a wire that moves goes on moving. What a voltage's noise is in
    resistance falls with the drive.
    """
    if resistance_ohm.size <= STEADY_SAMPLES:
        return np.zeros(0, dtype=np.intp), np.zeros(resistance_ohm.size)
    rise_ohm = np.diff(resistance_ohm, prepend=resistance_ohm[:1])
    beside_ohm = np.maximum(np.roll(rise_ohm, 1), np.roll(rise_ohm, -1))
    by_ohm = rise_ohm - np.maximum(beside_ohm, 0.0)
    bends_v = np.abs(np.diff(resistance_ohm, 2)) * drive_voltage_v[1:-1]
    noise_ohm = float(np.median(bends_v)) / BEND_PER_STD / np.maximum(drive_voltage_v, 1e-9)
    limit_ohm = np.maximum(JUMP_PART * span_ohm, JUMP_NOISES * noise_ohm)
    drives_v = sliding_window_view(drive_voltage_v, STEADY_SAMPLES)[:-1]  # each up to a row that has one after it
    rows = np.flatnonzero(drives_v.min(axis=1) >= STEADY_PART * drives_v.max(axis=1)) + STEADY_SAMPLES - 1
    return rows[by_ohm[rows] > limit_ohm[rows]], by_ohm


def running_mean(values: FloatArray, length: int) -> FloatArray:
    """Return the mean of each value and of those before it, of as many as there are up to a length, (n_times,)."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    last = np.arange(1, values.size + 1)
    first = np.maximum(last - length, 0)
    return np.asarray((sums[last] - sums[first]) / (last - first))


def odd_resistance(recording: Recording) -> OddResistance:
    """Return where a run's resistance is none of the model's wire, once it is sensed; nowhere if it states no B."""
    known = KnownB.stated_in(recording.facts)
    if known is None or "wire_resistance_ohm" not in recording:
        nowhere = np.zeros(0, dtype=np.intp)
        return OddResistance(nowhere, 0.0, nowhere, 0.0)
    rows = np.flatnonzero((recording["wire_resistance_ohm"] > 0.0) & since_first_sensed(recording))
    found = odd_in(known, recording["wire_resistance_ohm"][rows], recording["drive_voltage_v"][rows])
    return found._replace(jumps=rows[found.jumps], above=rows[found.above])
