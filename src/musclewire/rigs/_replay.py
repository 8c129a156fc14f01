"""A recording played back as a rig: sample by sample, exact to the bit, through the same protection."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import Field

from musclewire.controllers import ProtectionLimits
from musclewire.errors import RecordingError, RigError
from musclewire.files import read_hdf5, read_recording
from musclewire.parameters import validated
from musclewire.rigs._device import SWITCHED_OFF, Answer, DeviceFacts, Metadata
from musclewire.rigs._kinds import DeviceConfiguration, DeviceKind
from musclewire.rigs._mounted_wire import (
    DriveAmplitude,
    Legs,
    LimitsTable,
    MaximumVoltage,
    MountedWire,
    Pretension,
    SenseVoltage,
    Shunt,
    Volts,
    WireLength,
    may_be_left_out,
)
from musclewire.signals import REFERENCE_COLUMNS, Command, Drive, RawSample, Recording, drive_voltage_of

# Metadata that describe a recording's own run and not its rig: the run on the replay sets its own.
OF_THE_RUN = {"experiment", "ended", "start_time", "software_version", "pace", "scheduling", "deadline_misses"}
PREFIXES_OF_THE_RUN = ("limit_", "drift_", "compute_", "latency_", "jitter_", "replay_")
# If a recording does not state its channels' ranges, saturation cannot be detected.
UNKNOWN_RANGE_V = 1e6


class ReplayConfiguration(DeviceConfiguration):
    """A rig file with ``kind = "replay"``: a recording, and the facts of its rig that it does not contain.

    ``wire``, ``wire_length``, ``legs``, ``shunt``, ``sense_voltage``, ``maximum_voltage``, ``drive_amplitude`` and
    ``pretension`` are those of any rig file of real hardware; they are needed if the recording's metadata lack them,
    and replace the metadata otherwise.

    Attributes:
        recording: a recording file, next to the rig file.
        on_difference: response to a drive other than the recorded one: an error, or a report in the metadata of the
            new recording.
        drive_tolerance: allowed difference from the recorded drive, which was rounded to the output's steps.
        limits: limits of the protection that differ from those of the recorded rig.
    """

    kind: Literal["replay"]
    recording: str = Field(min_length=1)
    on_difference: Literal["error", "report"] = "error"
    drive_tolerance: Volts = 1e-3
    wire: str | None = None
    wire_length: WireLength | None = may_be_left_out(WireLength)
    legs: Legs | None = may_be_left_out(Legs)
    shunt: Shunt | None = may_be_left_out(Shunt)
    sense_voltage: SenseVoltage | None = may_be_left_out(SenseVoltage)
    maximum_voltage: MaximumVoltage | None = may_be_left_out(MaximumVoltage)
    drive_amplitude: DriveAmplitude | None = may_be_left_out(DriveAmplitude)
    pretension: Pretension | None = may_be_left_out(Pretension)
    limits: LimitsTable = LimitsTable()

    def with_files_in(self, folder: Path) -> Self:
        """Return the configuration with recording and wire file found next to the rig file."""
        return super().with_files_in(folder).model_copy(update={"recording": str(folder / self.recording)})


class ReplayDevice:
    """Returns a recording's samples in their order; it heats nothing, and a drive decides whether they still apply."""

    def __init__(self, configuration: ReplayConfiguration) -> None:
        """Read the recording and its rig's limits. Raises RecordingError if either cannot be read."""
        self._configuration = configuration
        self._path = Path(configuration.recording)
        read = read_hdf5 if self._path.suffix.lower() in (".h5", ".hdf5") else read_recording
        # With its errors: gaps and clocks that run backwards are for the protection to detect.
        recording = read(self._path).with_minor_loop
        self._known = recorded_facts(recording, configuration)
        self._samples = samples_of(recording, self._path, float(self._of_rig("shunt_resistance_ohm", "shunt")))
        period_s = float(self._of_rig("sample_period_s", "nothing: a recording of two samples or more"))
        amplitude_v = float(self._of_rig("drive_amplitude_v", "drive_amplitude"))
        limits = self._limits(period_s, amplitude_v)
        self._facts = DeviceFacts(
            sample_period_s=period_s,
            paced=False,  # no clock: samples come as fast as they are asked for
            leg_length_m=float(self._of_rig("leg_length_m", "wire_length and legs")),
            drive_amplitude_v=amplitude_v,
            limits=limits,
            reference_columns=tuple(name for name in REFERENCE_COLUMNS if name in recording),
            wire_temperature_k=limits.ambient_temperature_k,
        )
        self._off = False
        self._next = 0
        self._drive_voltage_v = 0.0
        self._differences = 0
        self._largest_difference_v = 0.0
        self._first_difference_s: float | None = None

    def _of_rig(self, key: str, name: str) -> float | str:
        """Return a fact of the recorded rig that is required; ``name`` is its key in the rig file."""
        value = self._known.get(key)
        if value is None:
            raise RecordingError(f"{self._path} does not say its {key}: give {name} in the rig file of the replay")
        return value

    def _limits(self, sample_period_s: float, drive_amplitude_v: float) -> ProtectionLimits:
        """Return the limits of the recorded rig; if it recorded none, those that follow from wire and circuit."""
        given = self._configuration.limits.changed()
        # What a file of before does not state has a default.
        names = [name for name in ProtectionLimits._fields if f"limit_{name}" in self._known]
        if {*names, *ProtectionLimits._field_defaults} == {*ProtectionLimits._fields}:
            known = {name: float(self._of_rig(f"limit_{name}", f"limits.{name}")) for name in names}
            return ProtectionLimits(**{**known, **given})
        facts = {
            "wire": self._of_rig("wire", "wire"),
            "wire_length": self._of_rig("wire_length_m", "wire_length"),
            "shunt": self._of_rig("shunt_resistance_ohm", "shunt"),
            "sense_voltage": self._of_rig("limit_sense_voltage_v", "sense_voltage"),
            "maximum_voltage": self._of_rig("limit_maximum_voltage_v", "maximum_voltage"),
            "drive_amplitude": drive_amplitude_v,
            "sample_period": sample_period_s,
            "limits": self._configuration.limits.model_dump(),
            "beyond_catalogue": True,  # a replay heats nothing
        }
        mounted = validated(MountedWire, facts, f"replay of {self._path}")
        return mounted.protection_limits(
            wire_range_v=UNKNOWN_RANGE_V, shunt_range_v=UNKNOWN_RANGE_V, readings_noisy=False
        )

    @property
    def facts(self) -> DeviceFacts:
        """Facts of the recorded rig, from the recording and the rig file."""
        return self._facts

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage that was out in the recording at this place."""
        return self._drive_voltage_v

    @property
    def samples_left(self) -> int:
        """Samples that have not been handed out yet."""
        return len(self._samples) - self._next

    def __repr__(self) -> str:
        """Name the recording, and the samples that have been replayed."""
        return f"ReplayDevice({self._path}, {self._next} of {len(self._samples)} samples)"

    def metadata(self) -> Metadata:
        """Return the recording's metadata of its rig, and the differences in drive that the replay has counted."""
        known = {
            key: value
            for key, value in self._known.items()
            if key not in OF_THE_RUN and not key.startswith(PREFIXES_OF_THE_RUN)
        }
        return {
            **known,
            "rig": "replay",
            "replayed_rig": self._known.get("replayed_rig", self._known.get("rig")),
            "replayed_recording": self._path.name,
            "replay_differences": self._differences,
            "replay_largest_difference_v": self._largest_difference_v,
            "replay_first_difference_s": self._first_difference_s,
        }

    def exchange(self, command: Command) -> Answer:
        """Return the next sample of the recording. Raises RigError at its end, and for another drive than recorded."""
        if self._next == len(self._samples):
            ended = str(self._known.get("ended", "for a reason it does not say"))
            raise RigError(
                f"the recording {self._path} ends after {self._next} samples (it ended '{ended}'): run no longer"
            )
        sample = self._samples[self._next]
        # While readings are missing the protection decides the drive, here as on the recorded rig.
        if not (isinstance(command, Drive) and command.by_protection):
            self._compare(drive_voltage_of(command), sample)
        self._next += 1
        self._drive_voltage_v = sample.drive_voltage_v
        if self._off:  # looked at after it was applied, so that 0 V is the last word whichever thread comes first
            self._drive_voltage_v = 0.0
            return SWITCHED_OFF
        return sample

    def _compare(self, drive_voltage_v: float, sample: RawSample) -> None:
        """Count a drive that is not the recorded one, or raise RigError for it."""
        difference_v = abs(drive_voltage_v - sample.drive_voltage_v)
        if difference_v <= self._configuration.drive_tolerance:
            return
        if self._configuration.on_difference == "error":
            raise RigError(
                f"{drive_voltage_v:.4f} V is asked at {sample.time_s:.3f} s of {self._path}, where "
                f"{sample.drive_voltage_v:.4f} V was recorded: replay with the same model, target and settings, or set "
                "on_difference = 'report'"
            )
        self._differences += 1
        self._largest_difference_v = max(self._largest_difference_v, difference_v)
        if self._first_difference_s is None:
            self._first_difference_s = sample.time_s

    def sense(self) -> bool:
        """Let the sense voltage be out."""
        self._drive_voltage_v = self._facts.limits.sense_voltage_v
        return True

    def off(self) -> bool:
        """Let 0 V be out."""
        self._off = True
        self._drive_voltage_v = 0.0
        return True


def recorded_facts(recording: Recording, given: ReplayConfiguration) -> Metadata:
    """Return the facts of the recorded rig, by the keys of metadata; the rig file replaces those of the recording."""
    said = {
        "wire": given.wire,
        "wire_length_m": given.wire_length,
        "shunt_resistance_ohm": given.shunt,
        "limit_sense_voltage_v": given.sense_voltage,
        "limit_maximum_voltage_v": given.maximum_voltage,
        "limit_shunt_resistance_ohm": given.shunt,
        "drive_amplitude_v": given.drive_amplitude,
        "pretension_n": given.pretension,
    }
    known = {**recording.metadata, **{key: value for key, value in said.items() if value is not None}}
    length = known.get("wire_length_m")
    if given.legs is not None and isinstance(length, (int, float)):
        known["leg_length_m"] = length / given.legs
    if "sample_period_s" not in known and "time_s" in recording and len(recording) > 1:
        known["sample_period_s"] = float(np.median(np.diff(recording["time_s"])))
    return known


def samples_of(recording: Recording, path: Path, shunt_resistance_ohm: float) -> list[RawSample]:
    """Return rows as samples, NaN as no reading. Raises RecordingError if time, drive or a voltage is missing."""
    for name in ("time_s", "drive_voltage_v", "wire_voltage_v"):
        if name not in recording:
            raise RecordingError(f"{path} has no column '{name}': a replay needs time, drive and both voltages")
    if "shunt_voltage_v" in recording:
        shunt_v = recording["shunt_voltage_v"]
    elif "wire_current_a" in recording:
        shunt_v = recording["wire_current_a"] * shunt_resistance_ohm
    else:
        raise RecordingError(f"{path} has neither 'shunt_voltage_v' nor 'wire_current_a': a replay needs one of them")
    columns = [recording[name].tolist() for name in ("time_s", "drive_voltage_v", "wire_voltage_v")]
    columns.append(shunt_v.tolist())
    for name in REFERENCE_COLUMNS:
        values = recording[name].tolist() if name in recording else [math.nan] * len(recording)
        columns.append([None if math.isnan(value) else value for value in values])
    return [RawSample(*row) for row in zip(*columns, strict=True)]


REPLAY = DeviceKind(ReplayConfiguration, ReplayDevice)
