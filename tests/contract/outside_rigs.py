"""A kind of device as another package would add it: one file and one registration, and rig files know it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import pytest
from tests.contract.rig_subject import RigSubject

from musclewire.rigs import (
    DEVICES,
    SWITCHED_OFF,
    Answer,
    DeviceConfiguration,
    DeviceFacts,
    DeviceKind,
    GuardedRig,
    Metadata,
    MountedWire,
    open_rig,
)
from musclewire.signals import Command, RawSample, drive_voltage_of

RIG_FILE = """
kind = "first order"
wire = "paper-100um"
wire_length = "14 cm"
shunt = "1 ohm"
sense_voltage = "0.3 V"
drive_amplitude = "3.0 V"
maximum_voltage = "3.6 V"
cold_resistance = 17.0
"""
COLD_OHM = 17.0
# A hot wire has lost a sixth of its resistance, and follows the power with this time constant.
LOST_FRACTION, LAG_S, HALFWAY_W = 1.0 / 6.0, 0.4, 0.1


class FirstOrderConfiguration(MountedWire, DeviceConfiguration):
    """The wire's keys as on every real rig, and the resistance that this device adds."""

    kind: Literal["first order"]
    cold_resistance: float


class FirstOrderDevice:
    """A wire whose resistance falls with the power, after a lag: no instruments, no clock, no noise."""

    def __init__(self, configuration: FirstOrderConfiguration) -> None:
        self._of = configuration
        self._drive_voltage_v = self._hot = 0.0
        self._samples, self._off = 0, False
        limits = configuration.protection_limits(wire_range_v=10.0, shunt_range_v=10.0, readings_noisy=False)
        self._facts = DeviceFacts(
            sample_period_s=configuration.sample_period,
            paced=False,
            leg_length_m=configuration.leg_length_m,
            drive_amplitude_v=configuration.drive_amplitude,
            limits=limits,
            wire_temperature_k=limits.ambient_temperature_k,
        )

    @property
    def facts(self) -> DeviceFacts:
        return self._facts

    @property
    def drive_voltage_v(self) -> float:
        return self._drive_voltage_v

    def metadata(self) -> Metadata:
        return {"rig": "first order", **self._of.facts()}

    def exchange(self, command: Command) -> Answer:
        drive_v = self._drive_voltage_v = drive_voltage_of(command)
        if self._off:
            self._drive_voltage_v = 0.0
            return SWITCHED_OFF
        wire_ohm = self._of.cold_resistance * (1.0 - LOST_FRACTION * self._hot)
        current_a = drive_v / (wire_ohm + self._of.shunt)
        power_w = current_a**2 * wire_ohm
        aim = power_w**2 / (power_w**2 + HALFWAY_W**2)
        self._hot += (aim - self._hot) * (1.0 - math.exp(-self._of.sample_period / LAG_S))
        self._samples += 1
        time_s = self._samples * self._of.sample_period
        return RawSample(time_s, drive_v, current_a * wire_ohm, current_a * self._of.shunt)

    def sense(self) -> bool:
        self._drive_voltage_v = self._of.sense_voltage
        return True

    def off(self) -> bool:
        self._off, self._drive_voltage_v = True, 0.0
        return True


# All that a package does to add its kind. The field "devices" of its manifest does it without a call.
DEVICES.register("first order", DeviceKind(FirstOrderConfiguration, FirstOrderDevice))


def opened_by_its_rig_file(_request: pytest.FixtureRequest, folder: Path) -> GuardedRig:
    rig_file = folder / "first-order.toml"
    rig_file.write_text(RIG_FILE, encoding="utf-8")
    return open_rig(rig_file)


SUBJECTS = (RigSubject("from outside", opened_by_its_rig_file, (COLD_OHM - 0.01, COLD_OHM + 0.01)),)
