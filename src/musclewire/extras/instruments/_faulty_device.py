"""A simulated device with faults of wire, circuit, channels and clock."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from musclewire.controllers import Event
from musclewire.extras.instruments._faults import SimulatedFault, SimulatedFaults
from musclewire.physics import series_resistance_ohm
from musclewire.rigs import Answer, DeviceFault, SimulatedDevice, SimulatedSpool
from musclewire.signals import Command, RawSample
from musclewire.wire import WireMeans


class FaultyDevice(SimulatedDevice):
    """A simulated device whose circuit, channels and clock fail as listed; all else is as in ``SimulatedDevice``."""

    uncompiled: ClassVar[str] = "the rig file lists faults"

    def __init__(self, faults: Sequence[SimulatedFault], spool: SimulatedSpool, **how: Any) -> None:
        """Cool the wire and wait at 0 V."""
        super().__init__(spool, **how)
        self._faults = SimulatedFaults(faults)
        self._wire_ohm = spool.wire["resistance_per_metre_ohm_per_m"] * spool.bench["wire_length_m"]

    def exchange(self, command: Command) -> Answer:
        """Hold a drive voltage for one sample period and return the readings at its end, unless the device is lost."""
        time_s = self.wires.time_s
        if self._faults.device_lost(time_s) and not self._off:
            return DeviceFault(Event.DEVICE_LOST, f"at {time_s:.2f} s, by the rig file's [[fault]]")
        return super().exchange(command)

    def _advance(self, drive_voltage_v: float) -> WireMeans:
        """Advance the wire with its current in the faulty circuit; return the voltages at the terminals."""
        time_s, shunt_ohm = self.wires.time_s, self.facts.limits.shunt_resistance_ohm
        output_v = self._faults.output_v(drive_voltage_v, time_s)
        current_a = self._faults.circuit(output_v, self._wire_ohm, shunt_ohm, time_s).wire_current_a
        means = super()._advance(current_a * (self._wire_ohm + shunt_ohm))
        if means.shunt_voltage_v > 0.0:
            self._wire_ohm = series_resistance_ohm(means.wire_voltage_v, means.shunt_voltage_v, shunt_ohm)
        seen = self._faults.circuit(output_v, self._wire_ohm, shunt_ohm, time_s)
        return means._replace(wire_voltage_v=seen.wire_voltage_v, shunt_voltage_v=seen.shunt_voltage_v)

    def _read(self, means: WireMeans) -> RawSample:
        """Return a sample of all instruments' readings, after the faults of channels and clock."""
        sample = super()._read(means)
        began_s = sample.time_s - self.facts.sample_period_s
        wire_v, shunt_v = self._faults.readings_v(sample.wire_voltage_v, sample.shunt_voltage_v, began_s)
        return sample._replace(
            time_s=self._faults.clock_s(sample.time_s), wire_voltage_v=wire_v, shunt_voltage_v=shunt_v
        )

    def off(self) -> bool:
        """Switch the drive off; while the device is lost nothing is confirmed."""
        return super().off() and not self._faults.device_lost(self.wires.time_s)
