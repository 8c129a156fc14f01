"""A recording of a wire driven by a voltage: loops, steps, cooling after a pulse, whatever the drive was."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from copy import copy
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.errors import CallerError, RecordingError
from musclewire.identify.physical.candidates import WireValues
from musclewire.identify.physical.observations import Channel, binned, with_model_error
from musclewire.identify.recordings import reference_quantity, resistance_reading
from musclewire.sensing.smoothing import noise_level
from musclewire.signals.recording import Recording
from musclewire.simulate.paths import DrivenPath, drive_path
from musclewire.simulate.wire import constants_of

__all__ = ["DrivenObservation", "bench_of", "observe_drive"]

FloatArray = NDArray[np.float64]


class RawChannel(NamedTuple):
    """A column as recorded, sample by sample: unit, values, noise of each, and which of them can be used, (n,)."""

    unit: str
    values: FloatArray
    noise: FloatArray
    usable: NDArray[np.bool_]

    def at(self, rows: NDArray[np.intp]) -> RawChannel:
        """Return the channel at some rows."""
        return RawChannel(self.unit, self.values[rows], self.noise[rows], self.usable[rows])


MOST_BINS = 400
# What a model of this kind is not expected to get right, whatever the noise: share of the leg in
# displacement, share of the resistance, share of the largest contraction force, kelvins.
MODEL_ERROR = {"strain": 1e-4, "resistance": 3e-4, "force": 3e-3, "temperature": 0.5}
# Larger steps are as right on the whole, but the edges they leave in the residuals mislead a descent.
LARGEST_STEP_S, REFINED_STEP_S = 0.005, 0.002
# A recording has about this many stretches over which a model is wrong in one way.
STRETCHES = 20
# A clock whose steps differ by more than this share of their median is laid on an even one.
EVEN_CLOCK = 0.02
# What a recording may say of the bench it was made on.
BENCH_KEYS = ("wire_length_m", "pretension_n", "spring_stiffness_n_per_m", "shunt_resistance_ohm", "sample_period_s")


class DrivenObservation:
    """A wire that rested cold, then was driven: resistance, and whatever instruments the recording has."""

    def __init__(
        self,
        title: str,
        drive_voltage_v: FloatArray,
        sample_period_s: float,
        bench: Mapping[str, float],
        diameter_m: float | None,
        channels: Mapping[str, RawChannel],
    ) -> None:
        """Take a drive on an even clock, (n,), and channels on the same clock."""
        self._title = title
        self._drive = drive_voltage_v
        self._period_s = sample_period_s
        self._bench = dict(bench)
        self._diameter_m = diameter_m
        self._largest_step_s = LARGEST_STEP_S
        self._bin = max(1, -(-drive_voltage_v.shape[0] // MOST_BINS))
        self._keep: dict[str, NDArray[np.bool_]] = {}
        self._channels = [self._binned_channel(name, raw) for name, raw in channels.items()]

    def _binned_channel(self, name: str, raw: RawChannel) -> Channel:
        keep = binned(raw.usable.astype(float), self._bin) > 0.999
        self._keep[name] = keep
        time_s = binned(self._period_s * np.arange(1, self._drive.shape[0] + 1), self._bin)
        deviation = np.sqrt(binned(raw.noise**2, self._bin) / self._bin)
        return Channel(
            name,
            raw.unit,
            "time_s",
            time_s[keep],
            binned(np.where(raw.usable, raw.values, 0.0), self._bin)[keep],
            with_model_error(deviation[keep], model_error(name, raw.values), int(keep.sum()), STRETCHES),
        )

    @property
    def title(self) -> str:
        """What this is, in a few words."""
        return self._title

    @property
    def channels(self) -> Sequence[Channel]:
        """The channels that are compared, in bins."""
        return self._channels

    @property
    def bench(self) -> Mapping[str, float]:
        """What is known of the bench the recording was made on."""
        return self._bench

    def refined(self) -> DrivenObservation:
        """Return the same observation, simulated with the step that a rig uses."""
        finer = copy(self)
        finer._largest_step_s = REFINED_STEP_S
        return finer

    def path(self, values: WireValues) -> DrivenPath:
        """Return the simulated wire through the recording's drive, sample by sample."""
        wire = values.wire if self._diameter_m is None else {**values.wire, "diameter_m": self._diameter_m}
        constants = constants_of(values.alloy, wire, {**values.bench, **self._bench})
        steps = max(1, math.ceil(self._period_s / self._largest_step_s - 1e-9))
        path, _ = drive_path(constants, self._drive, dt_s=self._period_s / steps, steps=steps)
        return path

    def simulate(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return each channel as this wire would have given it, in bins."""
        path = self.path(values)
        bench = {**values.bench, **self._bench}
        leg_m = bench["wire_length_m"] / bench["legs"]
        # Without a current there is no resistance to compare, and the recording has none there either.
        current_a = np.maximum(path.shunt_voltage_v / bench["shunt_resistance_ohm"], 1e-9)
        columns = {
            "resistance": path.wire_voltage_v / current_a,
            "strain": path.displacement_m / leg_m,
            "force": path.force_n - bench["pretension_n"],
            "temperature": path.temperature_k,
        }
        return {name: binned(columns[name], self._bin)[keep] for name, keep in self._keep.items()}


def observe_drive(recording: Recording, bench: Mapping[str, float], title: str) -> DrivenObservation:
    """Return a driven recording as an observation; ``bench`` holds what the user says of it beyond the recording.

    Raises RecordingError where nothing was driven or measured, CallerError where the bench is not known.
    """
    drive = drive_of(recording)
    even, period_s = even_clock(recording["time_s"])
    known = bench_of(recording, bench)
    known["sample_period_s"] = period_s
    channels = {name: raw.at(even) for name, raw in channels_of(recording).items()}
    if not channels:
        raise RecordingError(
            f"{title}: neither resistance nor strain, force or temperature was recorded: there is nothing to compare"
        )
    refuse_idle(drive, channels, title)
    diameter = recording.metadata.get("wire_diameter_m")
    return DrivenObservation(
        title, drive[even], period_s, known, float(diameter) if isinstance(diameter, (int, float)) else None, channels
    )


def refuse_idle(drive_v: FloatArray, channels: Mapping[str, RawChannel], title: str) -> None:
    """Raise RecordingError where the wire was not heated, or nothing moved by more than its noise."""
    if float(drive_v.max()) <= 0.0:
        raise RecordingError(
            f"{title}: the drive never rises above 0 V: a wire at rest tells nothing of its parameters"
        )
    moved = [
        name
        for name, raw in channels.items()
        if raw.usable.any() and np.ptp(raw.values[raw.usable]) > 20.0 * np.median(raw.noise[raw.usable]) + 1e-12
    ]
    if not set(moved) & {"resistance", "strain", "force"}:
        raise RecordingError(
            f"{title}: nothing moves by more than its noise ({', '.join(channels)}): the wire did not transform; "
            "drive it higher, so that it contracts"
        )


def drive_of(recording: Recording) -> FloatArray:
    """Return the voltage across wire and shunt, (n,)."""
    if "drive_voltage_v" in recording:
        return recording["drive_voltage_v"]
    if "wire_voltage_v" in recording and "shunt_voltage_v" in recording:
        return np.asarray(recording["wire_voltage_v"] + recording["shunt_voltage_v"])
    raise RecordingError(
        "the recording does not say what drove the wire: give drive_voltage_v, or wire_voltage_v and shunt_voltage_v"
    )


def even_clock(time_s: FloatArray) -> tuple[NDArray[np.intp], float]:
    """Return which row stands for each tick of an even clock, and its period [s]."""
    steps = np.diff(time_s)
    period_s = float(np.median(steps))
    if np.abs(steps - period_s).max() <= EVEN_CLOCK * period_s:
        period_s = float((time_s[-1] - time_s[0]) / steps.size)
        return np.arange(time_s.size), period_s
    ticks = time_s[0] + period_s * np.arange(int((time_s[-1] - time_s[0]) / period_s) + 1)
    return np.clip(np.searchsorted(time_s, ticks - 1e-12), 0, time_s.size - 1), period_s


def channels_of(recording: Recording) -> dict[str, RawChannel]:
    """Return what a recording measured, by the names that a simulation knows too."""
    everywhere = np.ones(len(recording), dtype=bool)
    found = {}
    if {"wire_voltage_v", "shunt_voltage_v"} <= set(recording.names) or "wire_resistance_ohm" in recording:
        reading = resistance_reading(recording)
        found["resistance"] = RawChannel("ohm", reading.resistance_ohm, resistance_noise(recording), reading.valid)
    for name, unit, values in (
        ("strain", "1", reference_quantity(recording, "strain")),
        ("force", "N", reference_quantity(recording, "force")),
        ("temperature", "K", recording.columns.get("wire_temperature_k")),
    ):
        if values is not None:
            found[name] = RawChannel(unit, values, np.full(len(recording), noise_level(values)), everywhere)
    return found


def resistance_noise(recording: Recording) -> FloatArray:
    """Return the standard deviation of each resistance [ohm], (n,): noise of both voltages over their size."""
    if "wire_voltage_v" not in recording or "shunt_voltage_v" not in recording:
        return np.full(len(recording), noise_level(recording["wire_resistance_ohm"]))
    share = np.zeros(len(recording))
    for name in ("wire_voltage_v", "shunt_voltage_v"):
        share += (noise_level(recording[name]) / np.maximum(np.abs(recording[name]), 1e-9)) ** 2
    return np.asarray(np.sqrt(share) * np.abs(resistance_reading(recording).resistance_ohm))


def model_error(name: str, measured: FloatArray) -> float:
    """Return what the model is not expected to get right in a channel, in its unit."""
    if name == "resistance":
        return MODEL_ERROR[name] * float(np.median(measured[measured > 0.0]))
    if name == "force":
        return MODEL_ERROR[name] * float(np.ptp(measured))
    return MODEL_ERROR[name]


def bench_of(recording: Recording, given: Mapping[str, float]) -> dict[str, float]:
    """Return what is known of a recording's bench: what the user gave, then what the recording says.

    Without a stiffness it is read off force and displacement. Raises CallerError where it cannot be known.
    """
    known: dict[str, float] = {}
    for key in BENCH_KEYS:
        value = recording.metadata.get(key)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            known[key] = float(value)
    leg = recording.metadata.get("leg_length_m")
    if isinstance(leg, (int, float)) and leg > 0.0 and "wire_length_m" in known:
        known["legs"] = float(round(known["wire_length_m"] / leg))
    if "ambient_temperature_k" in recording:
        known["ambient_temperature_k"] = float(np.mean(recording["ambient_temperature_k"]))
    known |= given
    missing = {"spring_stiffness_n_per_m", "pretension_n"} - known.keys()
    if missing:
        known = {**load_line(recording, missing), **known}
    return known


def load_line(recording: Recording, missing: set[str]) -> dict[str, float]:
    """Return stiffness and pretension as the straight line of force over displacement."""
    if "force_n" not in recording or "displacement_m" not in recording:
        raise CallerError(
            f"the load is not known: give {' and '.join(sorted(missing))} (--set NAME=VALUE), or record force_n and "
            "displacement_m"
        )
    slope, start = np.polyfit(recording["displacement_m"], recording["force_n"], 1)
    return {"spring_stiffness_n_per_m": max(float(slope), 0.0), "pretension_n": max(float(start), 0.0)}
