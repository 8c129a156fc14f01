"""What a rig is told to do for one sample period: put out a drive voltage, or go to a target by itself."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["Command", "Drive", "Target"]


class Drive(NamedTuple):
    """A drive voltage [V] that is put out for one sample period."""

    voltage_v: float


class Target(NamedTuple):
    """A target that the device follows with its own controller, in the unit of ``quantity``.

    ``value`` is a strain (dimensionless), a displacement [m] or a force [N]; only a device with a closed loop of its
    own accepts one.
    """

    value: float
    quantity: str = "strain"


Command = Drive | Target
