"""One exchange with a rig as plain values: the command that goes out, and the sample that comes back."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

from musclewire.errors import CallerError

__all__ = [
    "Command",
    "Drive",
    "Target",
    "as_command",
    "drive_voltage_of",
    "ELECTRICAL_COLUMNS",
    "REFERENCE_COLUMNS",
    "ControlStep",
    "EstimatorStep",
    "QuantityEstimate",
    "RawSample",
    "Reason",
    "WireSample",
    "wire_sample",
]


class Drive(NamedTuple):
    """A drive voltage that is put out for one sample period.

    Parameters
    ----------
    voltage_v
        The voltage across circuit and wire [V].
    by_protection
        Whether the protection chose this voltage instead of the one that was commanded, while readings are missing;
        only a rig's guard sets it.
    """

    voltage_v: float
    by_protection: bool = False


class Target(NamedTuple):
    """A target that the device follows with its own controller; only one with a closed loop of its own accepts it.

    Parameters
    ----------
    value
        The target in SI: a strain (dimensionless), a displacement [m] or a force [N].
    quantity
        What it is a target of: that of the model on the device.
    """

    value: float
    quantity: str = "strain"


Command = Drive | Target


def as_command(command: Command | float) -> Command:
    """Return a command; a bare number is a drive voltage in volts.

    Parameters
    ----------
    command
        A command, or a drive voltage [V], as scripts write it: ``rig.exchange(1.5)``.

    Returns
    -------
    The command itself, or the number as a :class:`Drive`.
    """
    return command if isinstance(command, (Drive, Target)) else Drive(command)


def drive_voltage_of(command: Command) -> float:
    """Return the drive voltage [V] of a command, for a device without a closed loop of its own.

    Parameters
    ----------
    command
        A drive voltage; the guard lets nothing else through to such a device.

    Returns
    -------
    The voltage [V].

    Raises
    ------
    CallerError
        For a target.
    """
    if isinstance(command, Drive):
        return command.voltage_v
    raise CallerError(
        f"a target of {command.value:g} ({command.quantity}) needs a board that closes the loop itself, and this rig "
        "has none: command a drive voltage"
    )


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


class WireSample(NamedTuple):
    """All that an estimator may see of a sample.

    No reference instrument is in it: what senses the wire by itself cannot read one by mistake.

    Parameters
    ----------
    time_s
        When the sample was taken [s], by the rig's clock.
    drive_voltage_v
        Voltage that drove circuit and wire before the sample [V].
    wire_voltage_v
        Voltage across the wire [V], V_SMA of Eq. 1.
    shunt_voltage_v
        Voltage across the shunt [V], V_R of Eq. 1.
    ambient_temperature_k
        Temperature of the air [K]; None on a rig that does not measure it.
    """

    time_s: float
    drive_voltage_v: float
    wire_voltage_v: float
    shunt_voltage_v: float
    ambient_temperature_k: float | None = None


def wire_sample(sample: RawSample) -> WireSample:
    """Return of a rig's sample what an estimator may see."""
    return WireSample(
        sample.time_s,
        sample.drive_voltage_v,
        sample.wire_voltage_v,
        sample.shunt_voltage_v,
        sample.ambient_temperature_k,
    )


class Reason(IntEnum):
    """Why an estimate is valid or not; the number is what a recording holds."""

    OK = 0
    NO_CURRENT = 1
    """No current flows, so there is no resistance."""
    MISMATCH = 2
    """The resistance is one that the model's wire never has."""
    OUT_OF_RANGE = 3
    """The resistance lies outside of the range in which the model senses."""
    COLD = 4
    """The wire is still on its way from A to B, where resistance does not tell the quantity."""
    NOT_READY = 5
    """The estimator has not seen enough samples yet."""


class QuantityEstimate(NamedTuple):
    """What an estimator makes of a sample.

    Parameters
    ----------
    value
        The quantity, in its SI unit; finite, whether valid or not.
    std
        Its standard deviation, in the same unit; finite, at least 0.
    valid
        Whether the value may be believed; only with ``Reason.OK``.
    reason
        Why it is valid or not.
    failure
        Why a run must end here, in one line, after ``reason`` has lasted too long; "" while it may go on.
    """

    value: float
    std: float
    valid: bool
    reason: Reason = Reason.OK
    failure: str = ""


class EstimatorStep(NamedTuple):
    """What an estimator returns for a sample.

    Parameters
    ----------
    estimate
        The estimate.
    state
        The estimator's next state, immutable.
    recorded
        A finite number for each of the estimator's columns.
    """

    estimate: QuantityEstimate
    state: Any
    recorded: tuple[float, ...]


class ControlStep(NamedTuple):
    """What a controller returns for a tick.

    Parameters
    ----------
    command
        What the rig is to do for the next sample period.
    state
        The controller's next state, immutable.
    recorded
        A finite number for each of the controller's columns.
    """

    command: Command
    state: Any
    recorded: tuple[float, ...]
