"""Options that commands with a rig share: the slow sine, how a loop keeps its time, how warm the wire is."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from musclewire.app._options import (
    AMPLITUDE,
    CLOCK_SPEED,
    CPU,
    CYCLES,
    PERIOD,
    REAL_TIME,
    REAL_TIME_PRIORITY,
    WIRE_TEMPERATURE,
    in_si,
)
from musclewire.app._output import warn
from musclewire.app._stopping import opened_rig
from musclewire.errors import CallerError

if TYPE_CHECKING:
    from musclewire.rigs import GuardedRig


@dataclass(frozen=True)
class SlowSineOptions:
    """The slow sine and how often it is repeated."""

    amplitude: Annotated[str | None, AMPLITUDE] = None
    period: Annotated[str, PERIOD] = "90 s"
    cycles: Annotated[int, CYCLES] = 2

    @property
    def amplitude_v(self) -> float | None:
        """Amplitude of the drive; None for the rig's own."""
        return in_si("--amplitude", self.amplitude)

    @property
    def period_s(self) -> float:
        """Duration of one cycle."""
        return in_si("--period", self.period)


@dataclass(frozen=True)
class TimingOptions:
    """How a loop keeps its time, and with how warm a wire it begins."""

    real_time: Annotated[bool, REAL_TIME] = False
    clock_speed: Annotated[float, CLOCK_SPEED] = 1.0
    real_time_priority: Annotated[bool, REAL_TIME_PRIORITY] = False
    cpu: Annotated[int | None, CPU] = None
    wire_temperature: Annotated[str | None, WIRE_TEMPERATURE] = None

    def open_rig(self, rig: str, seed: int | None) -> AbstractContextManager[GuardedRig]:
        """Open a rig that keeps this time. Raises CallerError for a speed of a clock that it does not have."""
        return opened_rig(
            rig,
            seed=seed,
            real_time=self.real_time,
            clock_speed=self.clock_speed,
            wire_temperature_k=in_si("--wire-temperature", self.wire_temperature),
        )

    def apply(self, rig: GuardedRig) -> list[str]:
        """Pin this process and take real-time priority as requested; return what the system refused, also on stderr.

        Raises CallerError for a core that does not exist, and for priority if no clock paces the rig.
        """
        from musclewire.rigs import pin_to_cpu, take_priority

        if self.real_time_priority and not rig.paced:
            raise CallerError(
                "no clock paces this rig, so at real-time priority it would take a whole core from everything else: "
                "add --real-time, or leave out --real-time-priority"
            )
        if self.cpu is not None:
            pin_to_cpu(self.cpu)
        return warn(take_priority()) if self.real_time_priority else []
