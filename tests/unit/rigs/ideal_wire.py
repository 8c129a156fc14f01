"""A device around an ideal wire: the limits' own heat balance, exactly, and whatever goes wrong in between."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from musclewire.controllers import ProtectionLimits
from musclewire.rigs import Answer, DeviceFacts, Metadata, open_rig
from musclewire.signals import Command, Drive, RawSample

PERIOD_S = 0.05
with open_rig("simulated") as _rig:
    LIMITS = _rig.protection_limits._replace(maximum_voltage_v=6.0, maximum_current_a=1.0, maximum_power_w=10.0)
Changed = Callable[[int, RawSample], object]


class IdealWire:
    """A wire whose temperature is known; ``changed`` makes of its n-th sample, from 0, what the guard gets to see.

    ``is_new`` is false for one that states neither a temperature nor an identity. ``ohm_per_k`` is what its
    resistance loses per kelvin between 340 and 380 K. A sample takes ``takes_s`` in truth, and by the device's clock
    always ``PERIOD_S``.
    """

    def __init__(
        self,
        changed: Changed = lambda _, sample: sample,
        *,
        limits: ProtectionLimits = LIMITS,
        resistance_ohm: float = 17.0,
        ohm_per_k: float = 0.0,
        paced: bool = False,
        identity: str | None = None,
        takes_s: float = PERIOD_S,
        is_new: bool = True,
    ) -> None:
        self.facts = DeviceFacts(
            PERIOD_S,
            paced=paced,
            leg_length_m=0.07,
            drive_amplitude_v=3.2,
            limits=limits,
            identity=identity,
            wire_temperature_k=limits.ambient_temperature_k if is_new and identity is None else None,
        )
        self.truth = limits
        self.temperature_k = self.hottest_k = limits.ambient_temperature_k
        self.drive_voltage_v, self.samples = 0.0, 0
        self.true_s, self._takes_s = 0.0, takes_s
        self._changed, self._cold_ohm, self._ohm_per_k = changed, resistance_ohm, ohm_per_k

    def believed(self, limits: ProtectionLimits) -> None:
        """Let its facts state other limits than those whose heat balance it has."""
        self.facts = replace(self.facts, limits=limits)

    def metadata(self) -> Metadata:
        return {}

    def put(self, drive_v: float) -> RawSample:
        """Hold a drive for a sample."""
        limits, self.drive_voltage_v = self.truth, drive_v
        resistance_ohm = self._cold_ohm - self._ohm_per_k * min(max(self.temperature_k - 340.0, 0.0), 40.0)
        current_a = drive_v / (resistance_ohm + limits.shunt_resistance_ohm)
        end_k = limits.ambient_temperature_k + current_a**2 * resistance_ohm / limits.heat_loss_w_per_k
        left = math.exp(-self._takes_s * limits.heat_loss_w_per_k / limits.heat_capacity_j_per_k)
        self.temperature_k = end_k + (self.temperature_k - end_k) * left
        self.hottest_k = max(self.hottest_k, self.temperature_k)
        self.true_s += self._takes_s
        self.samples += 1
        noise_v = 1e-5 * (self.samples % 7)
        volts = current_a * resistance_ohm + noise_v, current_a * limits.shunt_resistance_ohm + noise_v
        return RawSample(PERIOD_S * self.samples, drive_v, *volts)

    def exchange(self, command: Command) -> Answer:
        assert isinstance(command, Drive)
        return self._changed(self.samples, self.put(command.voltage_v))

    def sense(self) -> bool:
        self.drive_voltage_v = self.facts.limits.sense_voltage_v
        return True

    def off(self) -> bool:
        self.drive_voltage_v = 0.0
        return True
