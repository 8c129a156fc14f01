"""Points B and C of one heating sweep, from the resistance alone, and whether each was really seen."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.sensing._branches import MAX_WINDOW_FRACTION
from musclewire.sensing._loop_points import fall_from_b_to_c
from musclewire.sensing._resistance_maximum import ResistanceMaximum, resistance_maximum
from musclewire.sensing._smoothing import noise_level, smooth, smoothed_noise, smoothing_window

MIN_SAMPLES = 20
# A fall smaller than this fraction of the resistance is drift; the transformation takes about a tenth.
MIN_FALL_FRACTION = 0.01
MIN_FALL_NOISES = 10.0
BUMP_NOISES = 6.0
BUMP_FRACTION = 0.005
# Time after the maximum of the drive that still belongs to the sweep, as a fraction of the time up to it.
LAG_FRACTION = 0.15
# With more samples without a usable reading than this part, the readings come before the drive.
MAX_LEFT_OUT = 0.01


class ResistanceExtremes(NamedTuple):
    """Points B and C of a heating sweep, with their indices in the recording."""

    resistance_min_ohm: float
    resistance_max_ohm: float
    index_b: int  # sample next to B
    index_c: int
    # Whether the resistance rose before B: only then does the transformation begin there, and not merely the sweep.
    saw_b: bool
    saw_c: bool  # whether it rises again after C: only then does the transformation end there


def find_resistance_extremes(
    resistance_ohm: npt.ArrayLike,
    drive_voltage_v: npt.ArrayLike | None = None,
    valid: npt.ArrayLike | None = None,
) -> ResistanceExtremes:
    """Find R_max (B) and R_min (C) of one slow heating sweep: the ends of the main fall of its resistance.

    With the drive only samples up to shortly after its last maximum are read, so that the sweep may also cool again.
    Raises RecordingError for fewer than 20 usable samples, or no fall of resistance of 1 % and of ten times the noise.

    References
    ----------
    Lan and Fan 2010, Fig. 3(b) and Eq. 3.
    """
    place, measured = _heating(resistance_ohm, drive_voltage_v, valid)
    resistance, left = _smoothed(measured)
    rough = max(BUMP_NOISES * left, BUMP_FRACTION * float(np.ptp(resistance)))
    b, c = fall_from_b_to_c(resistance, rough)
    fall = float(resistance[b] - resistance[c])
    if fall < max(MIN_FALL_FRACTION * float(resistance[b]), MIN_FALL_NOISES * left):
        samples = np.size(resistance_ohm)
        cure = readings_first(samples if valid is None else int(np.sum(valid)), samples)
        raise RecordingError(
            f"no transformation: the resistance falls by {fall:.3g} ohm from {resistance[b]:.4g} ohm (noise "
            f"{left:.2g} ohm; {100 * MIN_FALL_FRACTION:g} % and ten times the noise are needed): "
            f"{cure or 'heat further'}"
        )
    bump = max(BUMP_NOISES * left, BUMP_FRACTION * fall)
    saw_b = float(resistance[b] - resistance[: b + 1].min()) > bump
    at_b = ResistanceMaximum(float(b), float(resistance[b]))
    if saw_b:
        at_b = resistance_maximum(measured[:c], resistance[:c], b, fall, left)
    return ResistanceExtremes(
        resistance_min_ohm=float(resistance[c]),
        resistance_max_ohm=at_b.resistance_ohm,
        index_b=int(place[round(at_b.place)]),
        index_c=int(place[c]),
        saw_b=saw_b,
        saw_c=float(resistance[c:].max() - resistance[c]) > bump,
    )


def _smoothed(measured: FloatArray) -> tuple[FloatArray, float]:
    """Return resistances smoothed as far as their noise requires, and the noise that is left [ohm]."""
    noise = noise_level(measured)
    window = smoothing_window(noise, float(np.ptp(measured)), int(MAX_WINDOW_FRACTION * measured.size))
    return smooth(measured, window), smoothed_noise(noise, window)


def _heating(
    resistance_ohm: npt.ArrayLike, drive_voltage_v: npt.ArrayLike | None, valid: npt.ArrayLike | None
) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Return the indices and values of usable samples up to the last maximum of the drive."""
    resistance = np.asarray(resistance_ohm, dtype=np.float64)
    mask = np.ones(resistance.shape, dtype=np.bool_) if valid is None else np.array(valid, dtype=np.bool_)
    drive = None if drive_voltage_v is None else np.asarray(drive_voltage_v, dtype=np.float64)
    if resistance.ndim != 1 or mask.shape != resistance.shape or (drive is not None and drive.shape != mask.shape):
        raise RecordingError(
            f"resistance {resistance.shape}, drive voltage {None if drive is None else drive.shape} and valid "
            f"{mask.shape} must be columns of equal length, of one wire"
        )
    if drive is not None and drive.size:
        hottest = np.flatnonzero(drive == drive.max())[-1]
        # Temperature follows the drive with a lag, so the minimum of resistance comes a little after the maximum of the
        # drive.
        mask = mask & (np.arange(drive.size) <= hottest * (1.0 + LAG_FRACTION))
    place = np.flatnonzero(mask)
    if place.size < MIN_SAMPLES:
        raise RecordingError(f"{place.size} usable samples in the sweep, at least {MIN_SAMPLES} are needed")
    bad = ~(np.isfinite(resistance[place]) & (resistance[place] > 0.0))
    if bad.any():
        raise RecordingError(
            f"{int(bad.sum())} of {bad.size} samples have no finite positive resistance, the first at index "
            f"{int(place[np.argmax(bad)])}: mark them in `valid`"
        )
    return place, resistance[place]


def readings_first(usable: int, samples: int) -> str:
    """Return advice on unusable readings, "" if sound: while they are missing, no more drive is known to help."""
    if usable > (1.0 - MAX_LEFT_OUT) * samples:
        return ""
    return f"{samples - usable} of {samples} samples cannot be used, mend the readings first"
