"""One tick of a rig, as plain values."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["RawSample"]


class RawSample(NamedTuple):
    """What a rig hands back for one drive command: what its wires carry, nothing derived.

    ``displacement_m`` and ``force_n`` are reference instruments (an LVDT, a load cell) where the rig has them, at the
    wire's connector; ``endpoint_displacement_m`` and ``endpoint_force_n`` others at the end of what it moves. They
    are recorded and used to characterise and to judge; the closed loop never sees them.
    """

    time_s: float
    drive_voltage_v: float
    wire_voltage_v: float
    shunt_voltage_v: float
    displacement_m: float | None = None
    force_n: float | None = None
    ambient_temperature_k: float | None = None
    endpoint_displacement_m: float | None = None
    endpoint_force_n: float | None = None
