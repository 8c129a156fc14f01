"""What a rig is to do for one sample period: put out a drive voltage, or go to a target by itself."""

from __future__ import annotations

from typing import NamedTuple

from musclewire.errors import CallerError

__all__ = ["Command", "Drive", "Target", "as_command", "drive_voltage_of"]


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
    """Return the drive voltage [V] of a command. Raises CallerError for a target, which only some devices follow."""
    if isinstance(command, Drive):
        return command.voltage_v
    raise CallerError(
        f"a target of {command.value:g} ({command.quantity}) needs a board that closes the loop itself, and this rig "
        "has none: command a drive voltage"
    )
