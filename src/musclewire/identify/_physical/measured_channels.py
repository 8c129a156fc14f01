"""Columns of a recording as channels of an observation: on an even clock, in bins, with noise and model error."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.identify._physical.observations import ObservedChannel, binned, with_model_error
from musclewire.identify._recordings import required_quantity
from musclewire.sensing import noise_level
from musclewire.signals import Recording

MAX_BINS = 400
# Error expected of a model of this kind in addition to noise: fraction of the leg in displacement,
# fraction of the resistance, fraction of the largest contraction force, kelvins (a sensor on a thin wire cools it).
MODEL_ERROR = {"strain": 1e-4, "resistance": 3e-4, "force": 3e-3, "temperature": 0.5}
# In a monotonic curve, an isobar or a cooling curve, the model's error has about this many independent values.
CURVE_STRETCHES = 10
# Larger steps are as accurate on average, but they make residuals discontinuous, which misleads a descent.
MAX_STEP_S = 0.025
# A clock whose steps differ by more than this fraction of their median is resampled to an even one.
EVEN_CLOCK = 0.02
FIRST_ROWS, MIN_ROWS = 9, 30


class RawChannel(NamedTuple):
    """A column as recorded, sample by sample: unit, values, noise of each, and which of them can be used, (n,)."""

    unit: str
    values: FloatArray
    noise: FloatArray
    usable: NDArray[np.bool_]

    def selected_rows(self, rows: NDArray[np.intp]) -> RawChannel:
        """Return the channel at some rows."""
        return RawChannel(self.unit, self.values[rows], self.noise[rows], self.usable[rows])

    def grouped(self, size: int) -> RawChannel:
        """Return means over groups of ``size`` samples."""
        return RawChannel(
            self.unit,
            binned(np.where(self.usable, self.values, 0.0), size),
            np.sqrt(binned(self.noise * self.noise, size) / size),
            binned(self.usable.astype(float), size) > 0.999,
        )


def require_rows(recording: Recording) -> None:
    """Raise RecordingError for a recording too short to calibrate from."""
    if len(recording) < MIN_ROWS:
        raise RecordingError(f"has {len(recording)} rows, a calibration needs {MIN_ROWS} or more")


def even_clock(time_s: FloatArray) -> tuple[NDArray[np.intp], float]:
    """Return the row for each tick of an even clock, and its period [s]."""
    steps = np.diff(time_s)
    period_s = float(np.median(steps))
    if np.abs(steps - period_s).max() <= EVEN_CLOCK * period_s:
        period_s = float((time_s[-1] - time_s[0]) / steps.size)
        return np.arange(time_s.size), period_s
    ticks = time_s[0] + period_s * np.arange(int((time_s[-1] - time_s[0]) / period_s) + 1)
    return np.clip(np.searchsorted(time_s, ticks - 1e-12), 0, time_s.size - 1), period_s


def bin_size(samples: int) -> int:
    """Return the number of samples in a bin, such that there are at most 400 bins."""
    return max(1, -(-samples // MAX_BINS))


def binned_channel(
    name: str, raw: RawChannel, time_s: FloatArray, size: int, stretches: int
) -> tuple[ObservedChannel, NDArray[np.bool_]]:
    """Return a channel in bins of ``size`` samples, and which bins it keeps: those whose samples are all usable.

    ``time_s`` is the clock of the samples, (n,), ``stretches`` the number of independent values of the model's error.
    """
    keep = binned(raw.usable.astype(float), size) > 0.999
    deviation = np.sqrt(binned(raw.noise**2, size) / size)
    channel = ObservedChannel(
        name,
        raw.unit,
        "time_s",
        binned(time_s, size)[keep],
        binned(np.where(raw.usable, raw.values, 0.0), size)[keep],
        with_model_error(deviation[keep], model_error(name, raw.values), int(keep.sum()), stretches),
    )
    return channel, keep


def model_error(name: str, measured: FloatArray) -> float:
    """Return the error expected of the model in a channel, in its unit."""
    if name == "resistance":
        return MODEL_ERROR[name] * float(np.median(measured[measured > 0.0]))
    if name == "force":
        return MODEL_ERROR[name] * float(np.ptp(measured))
    return MODEL_ERROR[name]


def instruments_of(recording: Recording) -> dict[str, RawChannel]:
    """Return those of strain, contraction force and temperature that a recording has."""
    found = {}
    if "reference_strain" in recording or "displacement_m" in recording:
        found["strain"] = raw_channel("1", required_quantity(recording, "strain"))
    if "force_n" in recording:
        found["force"] = raw_channel("N", contraction_force_n(recording))
    if "wire_temperature_k" in recording:
        found["temperature"] = raw_channel("K", recording["wire_temperature_k"])
    return found


def raw_channel(unit: str, values: FloatArray) -> RawChannel:
    """Return a column of an instrument with the noise estimated from it; all samples are usable."""
    return RawChannel(unit, values, np.full(values.size, noise_level(values)), np.ones(values.size, dtype=bool))


def contraction_force_n(recording: Recording) -> FloatArray:
    """Return force in excess of the pretension [N], (n,), which a tared load cell measures directly."""
    force, pretension = recording["force_n"], recording.facts.pretension_n
    first = float(np.median(force[:FIRST_ROWS]))
    tared = abs(first - pretension) > abs(first)
    return np.asarray(force - (first if tared else pretension))
