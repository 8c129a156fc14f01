"""The tick of an exported library in Python, by the functions that the closed loop and every rig use.

The C library is compared with it, in its golden vectors and in the tests. Samples are averaged for the controller and,
over the table's reading period, for the protection, as in the library.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from musclewire.controllers import (
    ControllerSetup,
    DriveLimits,
    Event,
    FuzzyPidController,
    FuzzyPidSettings,
    InverseModelController,
    Protection,
    ProtectionLimits,
    RuleBase,
    protection_table,
)
from musclewire.extras.board._c.loops import ControllerSettings
from musclewire.physics import wire_resistance
from musclewire.sensing import ESTIMATORS, PAPER_ESTIMATOR, Estimator, EstimatorSetup, SensingModel
from musclewire.signals import QuantityEstimate, Reason, WireSample, drive_voltage_of

TIME_ROUNDING_S = 1e-9
GAINS = ("kp", "ki", "kd")


class TickOutcome(NamedTuple):
    """The outcome of a library's tick: resistance, estimate, gains, allowed drive and protection state. SI units."""

    resistance_ohm: float
    estimate: float
    valid: bool
    kp: float  # of the inverse of the wire's model, kp, ki and kd are the three numbers that it records
    ki: float
    kd: float
    drive_voltage_v: float
    state: int
    event: int


@dataclass
class SampleSums:
    """Sums of samples, for a mean, and the highest drive among them."""

    drive_v: float = 0.0
    ordered_v: float = 0.0
    wire_v: float = 0.0
    shunt_v: float = 0.0
    time_s: float = 0.0
    samples: int = 0


@dataclass
class ReferenceTick:
    """One wire's controller and protection; ``start`` resets both."""

    model: SensingModel
    settings: ControllerSettings
    limits: DriveLimits
    protection_limits: ProtectionLimits
    rule_base: RuleBase | None = None
    estimator: str = PAPER_ESTIMATOR
    protection: Protection = field(init=False)

    def __post_init__(self) -> None:
        """Build the controller and start."""
        self._shunt_ohm = self.protection_limits.shunt_resistance_ohm
        self._controller: FuzzyPidController | InverseModelController
        if isinstance(self.settings, FuzzyPidSettings):
            self._controller = FuzzyPidController(self.settings, self.limits, self.rule_base)
        else:
            # Its power is that of the circuit at hand, whatever shunt the gains were found with.
            in_circuit = self.settings.model_copy(update={"shunt_resistance_ohm": self._shunt_ohm})
            self._controller = InverseModelController(ControllerSetup(self.limits, settings=in_circuit))
        self._followers: dict[float, Estimator] = {}
        self.start()

    def start(self) -> None:
        """Start cold: the drive is the sense voltage, and nothing is known of the wire."""
        self.protection = Protection(self.protection_limits)
        self._pid: tuple[float, ...] | None = None
        self._mean, self._block = SampleSums(), SampleSums()
        self._resistance_ohm = 0.0
        self._time_s = 0.0
        self._followed: Any = None
        self._estimate = QuantityEstimate(self.model.quantity_min, 0.0, False, Reason.NO_CURRENT)
        self._gains: tuple[float, ...] = (0.0, 0.0, 0.0)

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage [V] that the protection allows now."""
        return self.protection.allowed_drive_v

    @property
    def recorded(self) -> tuple[str, ...]:
        """Names of the three numbers that the controller records, in the place of the gains."""
        return GAINS if isinstance(self.settings, FuzzyPidSettings) else self._controller.columns

    def outcome(self) -> TickOutcome:
        """Return the outcome of the last tick."""
        kp, ki, kd = self._gains
        protection = self.protection.state
        return TickOutcome(
            self._resistance_ohm,
            self._estimate.value,
            self._estimate.valid,
            kp,
            ki,
            kd,
            self.drive_voltage_v,
            int(protection.state),
            int(protection.event),
        )

    def sample(self, wire_voltage_v: float, shunt_voltage_v: float, tick_s: float) -> TickOutcome:
        """Take one sample: add it to the sums, and pass each full block to the protection."""
        if not (tick_s > 0.0 and math.isfinite(tick_s)):
            self.protection.trip(Event.CLOCK_BACKWARDS)
            return self.outcome()
        for sums in (self._mean, self._block):
            sums.drive_v += self.drive_voltage_v
            sums.ordered_v = max(sums.ordered_v, self.drive_voltage_v)
            sums.wire_v += wire_voltage_v
            sums.shunt_v += shunt_voltage_v
            sums.time_s += tick_s
            sums.samples += 1
        block = self._block
        if block.time_s > protection_table().reading_period_s - TIME_ROUNDING_S:
            drive_v, wire_v, shunt_v = (total / block.samples for total in (block.drive_v, block.wire_v, block.shunt_v))
            self.protection.reading(drive_v, wire_v, shunt_v, block.time_s, block.ordered_v)
            self._block = SampleSums()
        return self.outcome()

    def control(self, target: float, dt_s: float) -> TickOutcome:
        """Estimate and control from the mean of the samples since the last control tick."""
        mean, self._mean = self._mean, SampleSums()
        voltages_v = (mean.wire_v / mean.samples, mean.shunt_v / mean.samples) if mean.samples else (0.0, 0.0)
        self._resistance_ohm = wire_resistance(*voltages_v, self._shunt_ohm).resistance_ohm
        self._estimate = self._sensed(voltages_v, dt_s)
        drive_v = self._controlled(target, dt_s) if math.isfinite(target) else -1.0
        self.protection.command(drive_v)
        return self.outcome()

    def _controlled(self, target: float, dt_s: float) -> float:
        """Return the controller's drive [V]; before the first estimate, the drive stays as it is."""
        estimate = self._estimate
        if self._pid is None and estimate.reason is Reason.NO_CURRENT:
            self._gains = (0.0, 0.0, 0.0)
            return self.drive_voltage_v
        before = self._controller.start(self.drive_voltage_v) if self._pid is None else self._pid
        command, self._pid, self._gains = self._controller.step(before, target, estimate, dt_s)
        return drive_voltage_of(command)

    def _sensed(self, voltages_v: tuple[float, float], dt_s: float) -> QuantityEstimate:
        """Return the estimate from both voltages, dt_s after the last; without current, the previous value."""
        self._time_s += dt_s
        if self.estimator != PAPER_ESTIMATOR:
            follower = self._follower(dt_s)
            sample = WireSample(self._time_s, self.drive_voltage_v, *voltages_v)
            estimate, self._followed, _ = follower.step(self._followed or follower.start(), sample)
            return estimate
        if not self._resistance_ohm > 0.0:
            return QuantityEstimate(self._estimate.value, 0.0, False, Reason.NO_CURRENT)
        return QuantityEstimate(*self.model.estimate(self._resistance_ohm))

    def _follower(self, dt_s: float) -> Estimator:
        """Return the estimator for a time between two ticks, made once; any goes on from another's state."""
        if dt_s not in self._followers:
            setup = EstimatorSetup(self.model, self._shunt_ohm, dt_s)
            self._followers[dt_s] = ESTIMATORS.find(self.estimator)(setup)
        return self._followers[dt_s]
