"""The interface of every rig, simulated or real."""

from __future__ import annotations

from types import TracebackType
from typing import Protocol, Self

from musclewire.signals import Command, RawSample

Metadata = dict[str, str | int | float | bool | None]


class Rig(Protocol):
    """A device with a clock that takes a drive voltage and returns readings of its wire.

    The rig owns the clock: ``exchange`` returns when the sample is due. Leaving the ``with`` block switches
    the drive off, whatever happened inside.
    """

    @property
    def sample_period_s(self) -> float:
        """Time between samples [s]."""
        ...

    @property
    def paced(self) -> bool:
        """Whether samples come at the pace of a real clock."""
        ...

    @property
    def sense_voltage_v(self) -> float:
        """Drive voltage [V] that heats the wire by little and still lets its resistance be measured."""
        ...

    @property
    def maximum_voltage_v(self) -> float:
        """Highest drive voltage [V] this rig allows."""
        ...

    @property
    def drive_amplitude_v(self) -> float:
        """Amplitude [V] at which this rig's wire completes its transformation in a slow sine."""
        ...

    @property
    def shunt_resistance_ohm(self) -> float:
        """R of Eq. 1 [ohm]."""
        ...

    @property
    def leg_length_m(self) -> float:
        """Length whose relative shortening is the strain [m]: one leg of the V."""
        ...

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage [V] that is out now."""
        ...

    @property
    def reference_columns(self) -> tuple[str, ...] | None:
        """Names of the reference instruments; None if only the first sample shows them."""
        ...

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this rig."""
        ...

    def exchange(self, command: Command | float) -> RawSample:
        """Follow a command for one sample period and return the sample at its end.

        Parameters
        ----------
        command
            A drive voltage [V], as a :class:`~musclewire.signals._exchange.Drive` or a bare number, or a
            :class:`~musclewire.signals._exchange.Target` for a device with a closed loop of its own.

        Returns
        -------
        The sample. Its ``drive_voltage_v`` is what was out.

        Raises
        ------
        RigError
            With the drive switched off, for a voltage outside 0 to the maximum, and for every event that ends the run.
        CallerError
            For a target if the device has no closed loop of its own.
        """
        ...

    def make_safe(self) -> None:
        """Go to the sense voltage at once; never raises."""
        ...

    def close(self) -> None:
        """Switch the drive off and release the hardware."""
        ...

    def __enter__(self) -> Self:
        """Return the rig itself."""
        ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Switch the drive off."""
        ...
