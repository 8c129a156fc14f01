"""The permitted range of the drive while the wire is sensed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from musclewire.errors import CallerError, NumericsError


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """The range of the drive voltage: from the sense voltage, which is above zero, to the maximum.

    The paper's Eq. 1 divides by the shunt voltage: without current there is no resistance, and without
    resistance no estimate to control with. So the controller never commands less than the sense voltage.

    Parameters
    ----------
    sense_voltage_v
        Minimum drive [V], at which the resistance can still be measured.
    maximum_voltage_v
        Maximum drive [V].

    Raises
    ------
    CallerError
        Unless 0 < sense_voltage_v < maximum_voltage_v, both finite.
    """

    sense_voltage_v: float
    maximum_voltage_v: float

    def __post_init__(self) -> None:
        """Check the range."""
        if not (math.isfinite(self.sense_voltage_v) and math.isfinite(self.maximum_voltage_v)):
            raise CallerError(
                f"drive limits must be finite, not {self.sense_voltage_v} V and {self.maximum_voltage_v} V"
            )
        if self.sense_voltage_v <= 0.0:
            raise CallerError(
                f"sense_voltage_v is {self.sense_voltage_v} V and must be above zero: "
                "without current the resistance cannot be measured (Eq. 1)"
            )
        if self.sense_voltage_v >= self.maximum_voltage_v:
            raise CallerError(
                f"sense_voltage_v ({self.sense_voltage_v} V) must be below "
                f"maximum_voltage_v ({self.maximum_voltage_v} V)"
            )

    def clamp(self, drive_voltage_v: float) -> float:
        """Return the nearest allowed drive.

        Parameters
        ----------
        drive_voltage_v
            A drive [V], which may be infinite.

        Returns
        -------
        The drive within the limits [V].

        Raises
        ------
        NumericsError
            If the drive is NaN.
        """
        if math.isnan(drive_voltage_v):
            raise NumericsError("the drive voltage is NaN: find the step that produced it")
        return min(max(drive_voltage_v, self.sense_voltage_v), self.maximum_voltage_v)
