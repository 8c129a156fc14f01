"""One tick of a rig, as plain values."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["ELECTRICAL_COLUMNS", "REFERENCE_COLUMNS", "RawSample"]


class RawSample(NamedTuple):
    """What a rig returns for one command: what its wires carry, nothing derived.

    Displacements and forces are reference instruments, None on a rig without. They are recorded and used to
    characterise and to judge; the closed loop never sees them.

    Parameters
    ----------
    time_s
        When the sample was taken [s], by the rig's clock.
    drive_voltage_v
        Voltage that drove circuit and wire before the sample [V].
    wire_voltage_v
        Voltage across the wire [V].
    shunt_voltage_v
        Voltage across the shunt [V].
    displacement_m
        Contraction at the wire's connector [m]: an LVDT.
    force_n
        Force in the wire at its connector [N]: a load cell.
    ambient_temperature_k
        Temperature of the air [K].
    endpoint_displacement_m
        Displacement of the end of what the wire moves [m]: a laser on a fingertip.
    endpoint_force_n
        Force at that end [N]: a load cell between fingers.
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


# What every rig gives, and the reference instruments that only some have: those that may be missing.
ELECTRICAL_COLUMNS = tuple(name for name in RawSample._fields if name not in RawSample._field_defaults)
REFERENCE_COLUMNS = tuple(RawSample._field_defaults)
