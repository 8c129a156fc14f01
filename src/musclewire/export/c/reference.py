"""The tick of an exported library as Python computes it: the functions of the closed loop and of every rig, in order.

The C library is held against it, in its golden vectors and in the tests. Samples are averaged for the controller and,
over the table's reading period, for the protection, as the library does it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from musclewire.controllers import DriveLimits, FuzzyPid, FuzzyPidSettings, RuleBase
from musclewire.controllers.fuzzy_pid import ControllerState
from musclewire.controllers.protection import (
    Event,
    ProtectionLimits,
    ProtectionState,
    allowed_drive_v,
    armed,
    protect_command,
    protect_reading,
    protection_table,
    tripped_by,
)
from musclewire.sensing.model import SensingModel
from musclewire.sensing.resistance import wire_resistance

__all__ = ["Outcome", "ReferenceTick"]

TIME_ROUNDING_S = 1e-9


class Outcome(NamedTuple):
    """What a library's tick leaves behind: readings, gains, and what may be out. SI units."""

    resistance_ohm: float
    estimate: float
    valid: bool
    kp: float
    ki: float
    kd: float
    drive_voltage_v: float
    state: int
    event: int


@dataclass
class Sums:
    """Samples summed up for a mean."""

    drive_v: float = 0.0
    wire_v: float = 0.0
    shunt_v: float = 0.0
    time_s: float = 0.0
    samples: int = 0


@dataclass
class ReferenceTick:
    """One wire's controller and protection; ``start`` begins anew."""

    model: SensingModel
    settings: FuzzyPidSettings
    limits: DriveLimits
    protection_limits: ProtectionLimits
    rule_base: RuleBase | None = None
    protection: ProtectionState = field(init=False)

    def __post_init__(self) -> None:
        """Build the controller and start."""
        self._controller = FuzzyPid(self.settings, self.limits, self.rule_base)
        self.start()

    def start(self) -> None:
        """Cold start: sense voltage, nothing known of the wire."""
        self.protection = armed(self.protection_limits)
        self._pid: ControllerState | None = None
        self._mean, self._block = Sums(), Sums()
        self._resistance_ohm = 0.0
        self._estimate, self._valid = self.model.quantity_min, False
        self._gains = (0.0, 0.0, 0.0)

    @property
    def drive_voltage_v(self) -> float:
        """What may be out now."""
        return allowed_drive_v(self.protection, self.protection_limits)

    def outcome(self) -> Outcome:
        """Return what the last tick left behind."""
        return Outcome(
            self._resistance_ohm,
            self._estimate,
            self._valid,
            *self._gains,
            self.drive_voltage_v,
            int(self.protection.state),
            int(self.protection.event),
        )

    def sample(self, wire_voltage_v: float, shunt_voltage_v: float, tick_s: float) -> Outcome:
        """Take one sample: sum it up, and let the protection judge a full block of them."""
        if not (tick_s > 0.0 and math.isfinite(tick_s)):
            self.protection = tripped_by(self.protection, Event.CLOCK_BACKWARDS)
            return self.outcome()
        for sums in (self._mean, self._block):
            sums.drive_v += self.drive_voltage_v
            sums.wire_v += wire_voltage_v
            sums.shunt_v += shunt_voltage_v
            sums.time_s += tick_s
            sums.samples += 1
        block = self._block
        if block.time_s > protection_table().reading_period_s - TIME_ROUNDING_S:
            drive_v, wire_v, shunt_v = (total / block.samples for total in (block.drive_v, block.wire_v, block.shunt_v))
            self.protection = protect_reading(
                self.protection, self.protection_limits, drive_v, wire_v, shunt_v, block.time_s
            )
            self._block = Sums()
        return self.outcome()

    def control(self, target: float, dt_s: float) -> Outcome:
        """Estimate and control from the mean of the samples since the last control tick."""
        mean, self._mean = self._mean, Sums()
        self._resistance_ohm = 0.0
        if mean.samples:
            shunt_ohm = self.protection_limits.shunt_resistance_ohm
            reading = wire_resistance(mean.wire_v / mean.samples, mean.shunt_v / mean.samples, shunt_ohm)
            self._resistance_ohm = reading.resistance_ohm
        drive_v = -1.0
        if math.isfinite(target):
            drive_v = self._controlled(target, dt_s) if self._resistance_ohm > 0.0 else self._blind()
        self.protection = protect_command(self.protection, self.protection_limits, drive_v)
        return self.outcome()

    def _controlled(self, target: float, dt_s: float) -> float:
        estimate = self.model.estimate(self._resistance_ohm)
        self._estimate, self._valid = estimate.value, estimate.valid
        if self._pid is None:
            self._pid = self._controller.start(self.drive_voltage_v, self._estimate, target)
        result = self._controller.step(self._pid, target, self._estimate, dt_s)
        self._pid = result.state
        self._gains = (result.kp, result.ki, result.kd)
        return result.drive_voltage_v

    def _blind(self) -> float:
        self._valid, self._gains = False, (0.0, 0.0, 0.0)
        if self._pid is None:
            return self.drive_voltage_v
        self._pid = self._controller.hold(self._pid)
        return self._pid.drive_voltage_v
