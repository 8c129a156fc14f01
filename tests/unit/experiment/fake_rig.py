"""A rig of one line: resistance falls straight with the strain, and strain follows the drive with a lag."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import nullcontext
from time import perf_counter_ns
from types import TracebackType
from typing import Self

from musclewire.controllers import Event, ProtectionLimits, ProtectionState, State
from musclewire.rigs import Metadata
from musclewire.sensing import SensingModel
from musclewire.signals import Command, RawSample, as_command, drive_voltage_of

LENGTH_M = 0.07


class FakeRig:
    """Strain goes to (drive - 1) * 2 % with a time constant of 0.3 s; 17.5 ohm at none, 100 ohm less per strain."""

    sample_period_s = 0.05
    paced = False
    sense_voltage_v = 0.3
    maximum_voltage_v = 3.6
    drive_amplitude_v = 3.2
    shunt_resistance_ohm = 1.0
    leg_length_m = LENGTH_M
    reference_columns = ("displacement_m",)
    drive_at_ns = sample_at_ns = 0
    protection_limits = ProtectionLimits(
        0.3, 3.6, 1.0, 1e-3, 0.5, 2.0, 10.0, 25.0, 0.1, 10.0, 10.0, 0.0, 0.02, 0.006, 295.15, 473.15
    )
    protection = ProtectionState(State.ARMED, Event.NONE, drive_voltage_v=0.0, temperature_k=295.15)
    air_is_known = air_is_stated = False
    device = None

    def __init__(self, *, fails_at: int | None = None, dropouts: range = range(0)) -> None:
        self.drive_voltage_v = 0.0
        self.strain = 0.0
        self.samples = 0
        self.safe_calls = 0
        self.fails_at = fails_at
        self.dropouts = dropouts

    def metadata(self) -> Metadata:
        return {"rig": "fake", "leg_length_m": LENGTH_M, "shunt_resistance_ohm": 1.0, "sample_period_s": 0.05}

    def exchange(self, command: Command | float) -> RawSample:
        drive_voltage_v, self.drive_at_ns = drive_voltage_of(as_command(command)), perf_counter_ns()
        if self.samples == self.fails_at:
            raise OSError("the cable came off")
        self.drive_voltage_v = drive_voltage_v
        self.samples += 1
        wanted = 0.02 * max(drive_voltage_v - 1.0, 0.0)
        self.strain += (wanted - self.strain) * (1.0 - math.exp(-0.05 / 0.3))
        resistance = 17.5 - 100.0 * self.strain
        self.sample_at_ns = perf_counter_ns()
        current = 0.0 if self.samples in self.dropouts else drive_voltage_v / (resistance + 1.0)
        return RawSample(
            0.05 * self.samples, drive_voltage_v, current * resistance, current, displacement_m=LENGTH_M * self.strain
        )

    def rest(self) -> None:
        """Its wire is cold."""

    def holding_back(self) -> nullcontext[None]:
        """It has no limit that a drive could exceed."""
        return nullcontext()

    def make_safe(self) -> None:
        self.safe_calls += 1
        self.drive_voltage_v = self.sense_voltage_v

    def close(self) -> None:
        self.drive_voltage_v = 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def straight_model() -> SensingModel:
    """The fake wire's own law: 4 % at 13.5 ohm, nothing at 17.5 ohm."""
    return SensingModel(13.5, 17.5, (0.04, -0.04), (0.04, -0.04), 0.0, 1.0)


def stop_after(rows: int, problem: BaseException):
    """Return an ``on_sample`` that raises a problem at a row."""
    seen: list[Mapping[str, float]] = []

    def on_sample(row: Mapping[str, float]) -> None:
        seen.append(row)
        if len(seen) == rows:
            raise problem

    return on_sample
