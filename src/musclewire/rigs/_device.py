"""The interface of every kind of hardware or simulation, and optional abilities; safety is decided elsewhere.

A device takes one command, puts it out and returns one sample. It judges nothing: the guard that holds it
(``musclewire.rigs._guarded``) decides before each command what may be out, and after each sample whether to continue.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

from musclewire.controllers import Event, ProtectionLimits
from musclewire.signals import Command, RawSample

if TYPE_CHECKING:
    from musclewire.controllers import FeedforwardSettings, FuzzyPidSettings
    from musclewire.sensing import Correction, SensingModel

Metadata = dict[str, str | int | float | bool | None]


@dataclass(frozen=True, slots=True)
class DeviceFacts:
    """Facts of an open device, which do not change while it is open.

    Parameters
    ----------
    sample_period_s
        Time between samples [s].
    paced
        Whether samples come at the pace of a real clock.
    leg_length_m
        Length whose relative shortening is the strain [m]: one leg of the V.
    drive_amplitude_v
        Amplitude [V] at which the wire completes its transformation in a slow sine.
    limits
        Limits of the protection; sense voltage, maximum voltage and shunt are among them.
    reference_columns
        Names of the reference instruments, of ``musclewire.signals._exchange.REFERENCE_COLUMNS``.
    identity
        A text by which this device and its wire are known again at the next opening, also by another program: serial
        number of its board or card, else its port. None: it is known by its rig file, else by its class.
    wire_temperature_k
        How warm the wire is when the device is opened [K], stated by who knows it, as a simulation does whose wire is
        new with each opening. None: it is remembered; where it is not known, the wire rests before it is heated.
    """

    sample_period_s: float
    paced: bool
    leg_length_m: float
    drive_amplitude_v: float
    limits: ProtectionLimits
    reference_columns: tuple[str, ...] = ()
    identity: str | None = None
    wire_temperature_k: float | None = None


class Missing(NamedTuple):
    """A sample or command has been missing for a time: the guard holds the drive, senses, or switches off."""

    event: Event  # ``Event.SAMPLE_LATE`` for example; the protection table says how long it may be missing
    missing_s: float  # from the beginning of the wait: it grows from one answer to the next
    # If it came after all, judged as any other; None while the device still waits: the guard calls ``exchange`` again,
    # with the command that may be out by now.
    sample: RawSample | None = None


class DeviceFault(NamedTuple):
    """A fault of the device that ends the run: the guard switches off, with the table's words for the event.

    Parameters
    ----------
    event
        The row of the protection table.
    details
        What was observed, for the message: a few words without a period.
    """

    event: Event
    details: str


Answer = RawSample | Missing | DeviceFault

# What a device has, whatever else it has.
DEVICE_METHODS = ("metadata", "exchange", "sense", "off")
DEVICE_PROPERTIES = ("facts", "drive_voltage_v")

# The answer to an exchange that another thread has ended by switching off; the guard reports that.
SWITCHED_OFF = DeviceFault(Event.DEVICE_LOST, "it was switched off while a sample was awaited")


class Device(Protocol):
    """A kind of hardware or simulation, opened, with 0 V out."""

    @property
    def facts(self) -> DeviceFacts:
        """Facts of the device; the same as long as it is open."""
        ...

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage [V] that is out now, as far as the host knows."""
        ...

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this device.

        Returns
        -------
        Facts by metadata keys, and its present counts (lost frames, late samples).
        """
        ...

    def exchange(self, command: Command) -> Answer:
        """Apply a command for one sample period and return the sample at its end.

        Parameters
        ----------
        command
            What the guard allows: a drive voltage, or a target if the device has a closed loop of its own
            (:class:`HasOnBoardLoop`).

        Returns
        -------
        The sample; what is missing, as soon as the guard may have to change the drive; or a fault.

        Raises
        ------
        RigError
            For trouble that no event of the protection table names. The guard switches off, as for a fault.
        NumericsError
            From a simulation that cannot continue. The guard switches off.
        """
        ...

    def sense(self) -> bool:
        """Go to the sense voltage now; never raises.

        Returns
        -------
        Whether it was ordered. If it was not, the guard switches off for good.
        """
        ...

    def off(self) -> bool:
        """Apply 0 V and release the hardware; nothing is applied after that.

        May be called twice, and from another thread while ``exchange`` waits for its sample: the drive does not wait
        for the sample, and the exchange ends soon, with an answer or an error that is not used. Never raises.

        Returns
        -------
        Whether the device has confirmed that 0 V is out; on a second call the same as on the first.
        """
        ...


@runtime_checkable
class HasCompiledExchange(Protocol):
    """A device whose samples are computed here, by code that is compiled when it runs first."""

    def compile_exchange(self) -> None:
        """Compile all that an exchange runs, and leave the device as it is; the guard asks for it before the first."""
        ...


@runtime_checkable
class HasStage(Protocol):
    """A linear stage that software can set."""

    def set_pretension(self, pretension_n: float) -> None:
        """Move the stage until the cold wire carries a force; the instruments are zeroed there.

        Parameters
        ----------
        pretension_n
            Force of the cold wire [N], both legs together.

        Raises
        ------
        CallerError
            For a force that the wire does not allow or the load cannot carry.
        """
        ...


@runtime_checkable
class HasTendonStage(Protocol):
    """A second stage that carries the finger: it gives the tendon slack or draws it taut."""

    def set_tendon_slack(self, slack_m: float) -> None:
        """Move the finger's stage.

        Parameters
        ----------
        slack_m
            Slack of the tendon [m]; below 0 it is drawn taut.

        Raises
        ------
        CallerError
            If there is no finger, or its curve does not extend that far.
        """
        ...


class TrueState(Protocol):
    """The true state of a simulated wire; a part of the simulator's own state."""

    @property
    def time_s(self) -> float:
        """Simulated time [s]."""
        ...

    @property
    def temperature_k(self) -> float:
        """Temperature of the wire [K]."""
        ...

    @property
    def resistance_ohm(self) -> float:
        """Resistance between the terminals [ohm]."""
        ...

    @property
    def cycles(self) -> float:
        """Number of transformation cycles that the wire has completed."""
        ...


@runtime_checkable
class HasAnEnd(Protocol):
    """A device that has so many samples and no more, as a recording that is replayed."""

    @property
    def samples_left(self) -> int:
        """Samples that have not been handed out yet."""
        ...


@runtime_checkable
class HasTrueState(Protocol):
    """A simulation, whose true state no instrument shows. For judging a result, never for an estimator."""

    @property
    def wire_state(self) -> TrueState:
        """State of the wire whose voltages are measured."""
        ...

    @property
    def partner_state(self) -> TrueState | None:
        """State of a second wire, None if there is none."""
        ...


@runtime_checkable
class HasOnBoardLoop(Protocol):
    """A closed loop on the device: it follows targets with its own estimator and controller."""

    @property
    def model_checksum(self) -> int:
        """Checksum of the model and controller that the device was built with."""
        ...

    def checksum_of(self, model: SensingModel, settings: FuzzyPidSettings | FeedforwardSettings, estimator: str) -> int:
        """Return the checksum that the device would have if it were built with a model and controller.

        Parameters
        ----------
        model
            The model.
        settings
            The settings of the controller.
        estimator
            Name of the estimator.

        Returns
        -------
        The checksum.
        """
        ...

    def correct(self, correction: Correction | None) -> None:
        """Let the loop run by a model that is corrected, from the next sample on.

        Parameters
        ----------
        correction
            What makes the model that of today; None for the model as it is, from the next run on.

        Raises
        ------
        RigError
            If the device knows no corrections, finds this one out of range, or does not answer.
        """
        ...

    @property
    def board_estimate(self) -> float | None:
        """The device's own estimate at the last exchange, in its model's unit (SI); None before the first."""
        ...

    @property
    def board_resistance_ohm(self) -> float | None:
        """The device's own resistance [ohm] at the last exchange; None before the first."""
        ...
