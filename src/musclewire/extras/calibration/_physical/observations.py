"""Observations of a wire, and their residuals against the simulation of a candidate.

An observation simulates a candidate through the recorded history and compares channel by channel, each normalised by
its uncertainty: the noise of the channel, and the error expected of a model of this kind. Noise is white; a model's
error is correlated. It counts once for a stretch of neighbouring points, as if they were one: otherwise the number of
points alone would make intervals too narrow.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from typing import NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.calibration._physical.candidates import WireValues, candidate_constants
from musclewire.identify import required_quantity
from musclewire.sensing import noise_level
from musclewire.signals import Recording
from musclewire.wire import ConnectorLoad, DrivenPath, WireConstants, WireState, drive_path, fixed_steps


@dataclass(frozen=True, eq=False)
class ObservedChannel:
    """One measured column, (n,), with its standard uncertainty, (n,), both in ``unit``, and the axis it runs over."""

    name: str
    unit: str
    axis: FloatArray
    measured: FloatArray
    uncertainty: FloatArray


@dataclass(frozen=True, eq=False)
class ChannelComparison:
    """A channel and its simulation with a candidate, (n,)."""

    channel: ObservedChannel
    predicted: FloatArray

    @property
    def rms(self) -> float:
        """Root mean square of the difference, in the channel's unit."""
        return float(np.sqrt(np.mean((self.predicted - self.channel.measured) ** 2)))

    @property
    def normalised_rms(self) -> float:
        """Root mean square of the difference over the channel's uncertainty."""
        return float(np.sqrt(np.mean(((self.predicted - self.channel.measured) / self.channel.uncertainty) ** 2)))


class Observation(Protocol):
    """A measurement on a wire that can be simulated: its title for people, and the channels that are compared."""

    title: str
    channels: Sequence[ObservedChannel]

    def refined(self) -> Observation:
        """Return the same observation, simulated with the finest time step."""
        ...

    def simulate(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return the simulated channels by name, (n,). Raises NumericsError if the wire cannot be simulated."""
        ...


def compare(observation: Observation, values: WireValues) -> list[ChannelComparison]:
    """Return every channel of an observation with the simulation of a candidate."""
    predicted = observation.simulate(values)
    return [ChannelComparison(channel, predicted[channel.name]) for channel in observation.channels]


def residuals_of(observation: Observation, values: WireValues) -> FloatArray:
    """Return (predicted - measured) / uncertainty of all channels in a row, (n,)."""
    parts = [
        (item.predicted - item.channel.measured) / item.channel.uncertainty for item in compare(observation, values)
    ]
    return np.concatenate(parts)


def binned(values: FloatArray, size: int) -> FloatArray:
    """Return means over groups of ``size`` rows, (n // size,); remaining rows at the end are dropped."""
    count = values.shape[0] // size
    return np.asarray(values[: count * size].reshape(count, size).mean(axis=1))


def with_model_error(noise: FloatArray | float, error: float, points: int, stretches: int) -> FloatArray:
    """Return the uncertainty of each of ``points`` points, (n,), with a model error that counts once for a stretch."""
    together = max(points / stretches, 1.0)
    return np.asarray(np.sqrt(np.square(noise) + error**2 * together) * np.ones(points))


MAX_BINS = 400
# Error expected of a model of this kind in addition to noise: fraction of the leg in displacement,
# fraction of the resistance, fraction of the largest contraction force, kelvins (a sensor on a thin wire cools it).
MODEL_ERROR = {"strain": 1e-4, "resistance": 3e-4, "force": 3e-3, "temperature": 0.5}
# In a monotonic curve, an isobar or a cooling curve, the model's error has about this many independent values.
CURVE_STRETCHES = 10
# Larger steps are as accurate on average, but they make residuals discontinuous, which misleads a descent.
MAX_STEP_S = 0.025
# The last descent and the derivative at the end are simulated with the step that a rig uses; a wire without current
# cools fast, and with larger steps it would warm for a moment as it transforms.
REFINED_STEP_S = 0.002
# A clock whose steps differ by more than this fraction of their median is resampled to an even one.
EVEN_CLOCK = 0.02
FIRST_ROWS = 9  # rows whose median is the force at the beginning
MIN_ROWS = 30  # rows of a recording from which a wire can be calibrated


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


class ClockedObservation:
    """A wire on an even clock and a known bench, driven or cooling; its channels are compared in bins."""

    def __init__(
        self, title: str, sample_period_s: float, samples: int, bench: Mapping[str, float], diameter_m: float | None
    ) -> None:
        """Take the clock; ``diameter_m`` is None for a wire of the candidate's diameter."""
        self.title = title
        self.channels: Sequence[ObservedChannel] = ()
        self.bench: Mapping[str, float] = dict(bench)
        self._period_s = sample_period_s
        self._diameter_m = diameter_m
        self._max_step_s = MAX_STEP_S
        self._bin = max(1, -(-samples // MAX_BINS))  # samples in a bin

    def refined(self) -> Self:
        """Return the same observation, simulated with the step that a rig uses."""
        finer = copy(self)
        finer._max_step_s = REFINED_STEP_S
        return finer

    def constants(
        self, values: WireValues, circuit: Mapping[str, float], load: ConnectorLoad | None = None
    ) -> WireConstants:
        """Return the constants of a candidate on this bench, with other numbers of its circuit, and another load."""
        wire = values.wire if self._diameter_m is None else {**values.wire, "diameter_m": self._diameter_m}
        return candidate_constants(values, wire, {**values.bench, **self.bench, **circuit}, load)

    def path(self, constants: WireConstants, drive_v: FloatArray, start: WireState | None = None) -> DrivenPath:
        """Return the simulated path under a drive on the clock, in even steps."""
        steps = max(1, math.ceil(self._period_s / self._max_step_s - 1e-9))
        stepping = fixed_steps(self._period_s / steps)
        return drive_path(constants, drive_v, sample_s=self._period_s, stepping=stepping, state=start)[0]
