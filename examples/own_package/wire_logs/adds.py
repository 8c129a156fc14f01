"""A command, a reader and a kind of rig: everything that the manifest names.

A .wirelog is text, a sample in a row: voltage of the wire and of the shunt [V], a hundred rows a second.
"""

from pathlib import Path
from typing import Literal

import numpy as np

from musclewire import (
    SWITCHED_OFF,
    DeviceConfiguration,
    DeviceFacts,
    DeviceKind,
    MountedWire,
    RawSample,
    RecordingError,
    SourceColumn,
    TableInMemory,
    drive_voltage_of,
)

STATED_PERIODS_S = {"the format": 0.01}


def ohms(file: Path, shunt_ohm: float = 1.0) -> None:
    """Print the resistance in each row of a .wirelog."""
    wire_v, shunt_v = read_wirelog(file, None).values
    for resistance_ohm in wire_v / shunt_v * shunt_ohm:
        print(f"{resistance_ohm:.3f} ohm")


def reader(path: Path):
    """Return what reads a file, None for a file that is no .wirelog."""
    return read_wirelog if path.suffix == ".wirelog" else None


def read_wirelog(path: Path, _group: str | None) -> TableInMemory:
    """Return the columns of a .wirelog; there are no groups in it to choose from."""
    try:
        rows = np.loadtxt(path, ndmin=2)
    except ValueError as error:
        raise RecordingError(f"{path}: is no .wirelog: {error}") from error
    if rows.shape[1] != 2:
        raise RecordingError(f"{path}: has {rows.shape[1]} columns; a .wirelog has two, wire and shunt voltage")
    columns = (SourceColumn("wire voltage", "V"), SourceColumn("shunt voltage", "V"))
    return TableInMemory(str(path), "wire log", columns, (rows[:, 0], rows[:, 1]), stated_periods_s=STATED_PERIODS_S)


class ResistorConfiguration(MountedWire, DeviceConfiguration):
    """The keys of wire and circuit that every real rig has, and one more."""

    kind: Literal["resistor"]
    resistance: float


class Resistor:
    """A resistor switched in for the wire: nothing moves, which is how to try a circuit."""

    def __init__(self, configuration: ResistorConfiguration) -> None:
        self._file, self._samples, self._is_off, self.drive_voltage_v = configuration, 0, False, 0.0
        self.facts = DeviceFacts(
            sample_period_s=configuration.sample_period,
            paced=False,
            leg_length_m=configuration.leg_length_m,
            drive_amplitude_v=configuration.drive_amplitude,
            limits=configuration.protection_limits(wire_range_v=10.0, shunt_range_v=10.0, readings_noisy=False),
            wire_temperature_k=295.15,  # a resistor has no heat that counts; without this line it is remembered
        )

    def metadata(self):
        """Return what a recording says of this rig."""
        return {"rig": "resistor", **self._file.facts()}

    def exchange(self, command):
        """Apply a voltage for a sample period and return the sample at its end."""
        self.drive_voltage_v = drive_voltage_of(command)
        if self._is_off:  # looked at after the output: 0 V is the last word whichever thread comes first
            self.drive_voltage_v = 0.0
            return SWITCHED_OFF
        self._samples += 1
        current_a = self.drive_voltage_v / (self._file.resistance + self._file.shunt)
        wire_v, shunt_v = current_a * self._file.resistance, current_a * self._file.shunt
        return RawSample(self._samples * self._file.sample_period, self.drive_voltage_v, wire_v, shunt_v)

    def sense(self):
        """Go to the sense voltage."""
        self.drive_voltage_v = self._file.sense_voltage
        return True

    def off(self):
        """Apply 0 V for good."""
        self._is_off, self.drive_voltage_v = True, 0.0
        return True


RESISTOR = DeviceKind(ResistorConfiguration, Resistor)
