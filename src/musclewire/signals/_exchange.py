"""One exchange with a rig as plain values: the command that goes out, and the sample that comes back."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, NamedTuple

from musclewire.errors import CallerError


class Drive(NamedTuple):
    """A drive voltage that is applied for one sample period.

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
        The quantity of the target; it must be that of the model on the device.
    """

    value: float
    quantity: str = "strain"


Command = Drive | Target


def as_command(command: Command | float) -> Command:
    """Return a command; a bare number, as of ``rig.exchange(1.5)``, is a drive voltage [V]."""
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
    """The measurements that a rig returns for one command, with nothing derived from them.

    Displacements and forces come from reference instruments and are None on a rig without them. They are recorded and
    serve to characterize and to validate; the closed loop never reads them.

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
        Contraction at the wire's connector [m], as an LVDT measures it.
    force_n
        Force in the wire at its connector [N], as a load cell measures it.
    ambient_temperature_k
        Temperature of the air [K].
    endpoint_displacement_m
        Displacement of the endpoint of the moved mechanism [m], as a laser on a fingertip measures it.
    endpoint_force_n
        Force at the endpoint [N], as a load cell between the fingers measures it.
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


# The columns of every rig, and those of reference instruments, which a rig may lack: these have a default.
ELECTRICAL_COLUMNS = tuple(name for name in RawSample._fields if name not in RawSample._field_defaults)
REFERENCE_COLUMNS = tuple(RawSample._field_defaults)


class WireSample(NamedTuple):
    """The part of a sample that an estimator may use.

    It holds no reference instrument, so that self-sensing cannot read one by mistake.

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
    """Return the part of a rig's sample that an estimator may use."""
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
    """The wire is still on its way from A to B, where resistance does not determine the quantity."""
    NOT_READY = 5
    """The estimator has not seen enough samples yet."""
    UNEXPLAINED = 6
    """No hypothesis of load and air explains the resistance: the wire is not the one that was calibrated."""
    UNCERTAIN = 7
    """Explanations that are equally good differ by too much."""


class WireEstimate(NamedTuple):
    """What an estimator knows of the wire besides the quantity, for a controller that can use it.

    An estimator that records these as columns of these names gives them to compiled loops as well.

    Parameters
    ----------
    balance_power_w
        Electrical power [W] that would hold the wire's present temperature in the air of the characterization.
    heating_part
        Where between its branches the wire is: 0 on the cooling one, 1 on the heating one.
    air_shift_w
        Power [W] by which today's air shifts both branches.
    convection_ratio
        Loss to the air over that of the characterization.
    wire_power_w
        Electrical power [W] in the wire over the sample, as measured.
    """

    balance_power_w: float
    heating_part: float
    air_shift_w: float
    convection_ratio: float
    wire_power_w: float


# Of an estimator that knows the quantity alone.
UNKNOWN_WIRE = WireEstimate(*(math.nan for _ in WireEstimate._fields))


class QuantityEstimate(NamedTuple):
    """An estimator's result for one sample.

    Parameters
    ----------
    value
        The quantity, in its SI unit; finite, whether valid or not.
    std
        Its standard deviation, in the same unit; finite, at least 0.
    valid
        Whether the value is valid, which requires ``Reason.OK``.
    reason
        Why it is valid or not.
    failure
        Message, in one line, of a run that must end because ``reason`` has lasted too long; "" while it may continue.
    wire
        What else is known of the wire; None if nothing is.
    """

    value: float
    std: float
    valid: bool
    reason: Reason = Reason.OK
    failure: str = ""
    wire: WireEstimate | None = None


class EstimatorStep(NamedTuple):
    """The values that an estimator returns for a sample.

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
    """The values that a controller returns for a tick.

    Parameters
    ----------
    command
        The command for the next sample period.
    state
        The controller's next state, immutable.
    recorded
        A finite number for each of the controller's columns.
    """

    command: Command
    state: Any
    recorded: tuple[float, ...]
