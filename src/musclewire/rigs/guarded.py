"""The base of every rig: no drive goes out and no sample comes back except through the protection table."""

from __future__ import annotations

from abc import ABC, abstractmethod
from time import perf_counter_ns
from types import TracebackType
from typing import Self, final

from musclewire.controllers.protection import (
    Event,
    ProtectionLimits,
    ProtectionState,
    State,
    allowed_drive_v,
    armed,
    closed,
    protect_command,
    protect_missing,
    protect_reading,
    protection_table,
    rested,
    tripped_by,
)
from musclewire.errors import CallerError, RigError
from musclewire.physics.circuit import series_resistance_ohm
from musclewire.rigs.protocol import Metadata
from musclewire.signals.commands import Command, Drive, Target, as_command, drive_voltage_of
from musclewire.signals.samples import RawSample

__all__ = ["GuardedRig", "ProtectionTripError"]

# Of a device that does not answer nobody can say more.
NOT_CONFIRMED = (
    "0 V was ordered and nothing confirms it: a board's drive expires by itself, a card's guardian has tried to switch "
    "off; cut the supply to be sure"
)


class ProtectionTripError(RigError):
    """The protection has switched the drive off; ``event`` says why."""

    def __init__(self, message: str, event: Event) -> None:
        """Keep the event beside the message."""
        super().__init__(message)
        self.event = event


class GuardedRig(ABC):
    """A rig below whose ``exchange`` the protection table stands, so that no script passes it by accident.

    A kind of rig says how one sample is taken (``_exchange``), how its output goes to the sense voltage (``_put_safe``)
    and how it is switched off for good (``_switch_off``). Everything else, what may be out and when it must go off, is
    decided here, for all of them alike.

    ``drive_at_ns`` and ``sample_at_ns`` are when the last drive was handed to the output and when its sample was there
    (``time.perf_counter_ns``): between a sample and the next drive lies all that the host computes, the protection too.
    """

    drive_at_ns = 0
    sample_at_ns = 0

    _guard: ProtectionState
    _guard_limits: ProtectionLimits
    _block_s: float
    _block_drive_v: float
    _block_wire_v: float
    _block_shunt_v: float
    _last_time_s: float | None
    _off_for_good: bool
    # A kind of rig says False in ``_switch_off`` where its device has not confirmed that 0 V is out.
    _off_confirmed = True

    def protect_with(self, limits: ProtectionLimits) -> None:
        """Arm the protection with the limits of wire and circuit; a kind of rig calls this when it has been opened.

        Raises CallerError for limits that cannot belong to a wire.
        """
        self._guard_limits = limits.checked()
        self._guard = armed(limits)
        self._last_time_s = None
        self._off_for_good = False
        self._start_block()

    @property
    @abstractmethod
    def sample_period_s(self) -> float:
        """Time between samples."""

    @property
    @abstractmethod
    def paced(self) -> bool:
        """Whether samples come at the pace of a real clock."""

    @property
    def sense_voltage_v(self) -> float:
        """Drive voltage that heats the wire by little and still lets its resistance be measured."""
        return self._guard_limits.sense_voltage_v

    @property
    def maximum_voltage_v(self) -> float:
        """Highest drive voltage this rig allows."""
        return self._guard_limits.maximum_voltage_v

    @property
    @abstractmethod
    def drive_amplitude_v(self) -> float:
        """Amplitude at which this rig's wire completes its transformation in a slow sine."""

    @property
    def shunt_resistance_ohm(self) -> float:
        """R of Eq. 1."""
        return self._guard_limits.shunt_resistance_ohm

    @property
    @abstractmethod
    def leg_length_m(self) -> float:
        """Length whose relative shortening is the strain: one leg of the V."""

    @property
    @abstractmethod
    def drive_voltage_v(self) -> float:
        """Drive voltage that is out now."""

    @abstractmethod
    def metadata(self) -> Metadata:
        """Return what a recording should say about this rig."""

    @property
    def reference_columns(self) -> tuple[str, ...] | None:
        """Names of the reference instruments; None where only the first sample tells."""
        return None

    @property
    def accepts_targets(self) -> bool:
        """Whether the device has a closed loop of its own, to which targets go."""
        return False

    @abstractmethod
    def _exchange(self, command: Command) -> RawSample:
        """Follow a command that the protection allows for one sample period; return the sample at its end."""

    @abstractmethod
    def _put_safe(self) -> None:
        """Go to the sense voltage at once; never raises."""

    @abstractmethod
    def _switch_off(self) -> None:
        """Put out 0 V and let go of the hardware; may be called twice; never raises."""

    @property
    def protection(self) -> ProtectionState:
        """What the protection knows: its state, the last event, the estimated temperature."""
        return self._guard

    @property
    def protection_limits(self) -> ProtectionLimits:
        """The limits that the protection table is held against."""
        return self._guard_limits

    @final
    def exchange(self, command: Command | float) -> RawSample:
        """Follow a command for one sample period and return the sample at its end.

        While readings are missing the protection holds the drive or lowers it; the sample's ``drive_voltage_v`` says
        what was out. A target goes to the device's own closed loop; what that puts out is judged like any drive.

        Parameters
        ----------
        command
            A drive voltage [V], as a :class:`~musclewire.signals.commands.Drive` or a bare number, or a
            :class:`~musclewire.signals.commands.Target` for a device with a closed loop of its own.

        Returns
        -------
        The sample.

        Raises
        ------
        RigError
            With the drive switched off, for a voltage outside 0 to the maximum and for every event of the protection
            table that trips. Whatever else is raised leaves the rig at its sense voltage.
        CallerError
            For a target where the device has no closed loop of its own.
        """
        if self._off_for_good:
            raise RigError("this rig is closed or has failed and stays off: open it again")
        allowed = self._allowed(as_command(command))
        self.drive_at_ns = perf_counter_ns()
        try:
            sample = self._exchange(allowed)
        except RigError:
            self.close()  # whatever a device reports as its fault ends off, not at the sense voltage
            raise
        except BaseException:
            self.make_safe()  # Ctrl-C, or a mistake in a kind of rig: nobody may be there to ask for less
            raise
        self.sample_at_ns = perf_counter_ns()
        if isinstance(allowed, Target):
            # The protection judges what the device put out as if the host had commanded it.
            chosen_v = min(sample.drive_voltage_v, self.maximum_voltage_v)
            self._guard = protect_command(self._guard, self._guard_limits, chosen_v)
        self._judge(sample)
        return sample

    def _allowed(self, command: Command) -> Command:
        """Return what may go out of a command. Raises as ``exchange`` does for one that never may."""
        if isinstance(command, Target) and self.accepts_targets:
            return command
        try:
            drive_voltage_v = drive_voltage_of(command)
        except CallerError:
            self.make_safe()
            raise
        self._guard = protect_command(self._guard, self._guard_limits, drive_voltage_v)
        if self._guard.state is State.TRIPPED:
            self.close()
            raise ProtectionTripError(
                f"drive voltage {drive_voltage_v} V is outside 0 to {self.maximum_voltage_v} V; {self._off_in_words()}",
                Event.COMMAND_REFUSED,
            )
        return Drive(allowed_drive_v(self._guard, self._guard_limits))

    def _judge(self, sample: RawSample) -> None:
        """Run the protection over a sample; readings faster than the table's period are averaged first."""
        period_s = self.sample_period_s
        if self._last_time_s is not None and not sample.time_s > self._last_time_s:
            self.trip(Event.CLOCK_BACKWARDS, f"{sample.time_s:.6f} s after {self._last_time_s:.6f} s")
        self._last_time_s = sample.time_s
        share = period_s / (self._block_s + period_s)
        self._block_s += period_s
        self._block_drive_v += share * (sample.drive_voltage_v - self._block_drive_v)
        self._block_wire_v += share * (sample.wire_voltage_v - self._block_wire_v)
        self._block_shunt_v += share * (sample.shunt_voltage_v - self._block_shunt_v)
        if self._block_s < protection_table().reading_period_s - 1e-9:
            return
        self._guard = protect_reading(
            self._guard,
            self._guard_limits,
            self._block_drive_v,
            self._block_wire_v,
            self._block_shunt_v,
            self._block_s,
        )
        wire_v, shunt_v, drive_v = self._block_wire_v, self._block_shunt_v, self._block_drive_v
        self._start_block()
        if self._guard.state is State.TRIPPED:
            self.trip(self._guard.event, f"at {sample.time_s:.3f} s: {self._measured(drive_v, wire_v, shunt_v)}")

    def _start_block(self) -> None:
        self._block_s = self._block_drive_v = self._block_wire_v = self._block_shunt_v = 0.0

    def _measured(self, drive_v: float, wire_v: float, shunt_v: float) -> str:
        """Return what was measured when the protection tripped."""
        resistance_ohm = series_resistance_ohm(wire_v, shunt_v, self.shunt_resistance_ohm) if shunt_v else None
        ohm = "" if resistance_ohm is None else f", {resistance_ohm:.3f} ohm"
        return f"drive {drive_v:.3f} V, wire {wire_v:.4f} V, shunt {shunt_v:.4f} V{ohm}, {self._warmth()}"

    def _warmth(self) -> str:
        return f"estimated {self._guard.temperature_k - 273.15:.0f} C"

    def miss(self, event: Event, missing_s: float) -> None:
        """Tell the protection that a sample has been missing for so long in all: it holds, senses, then trips.

        Raises RigError when it trips.
        """
        self._guard = protect_missing(self._guard, event, missing_s)
        if self._guard.state is State.TRIPPED:
            self.trip(event, f"missing for {missing_s:.3f} s")

    def drive_when_late(self, drive_voltage_v: float, late_s: float) -> float:
        """Return what may be out after a sample has been due for ``late_s`` before its drive was commanded.

        The old drive was held meanwhile; later than the table's ``sense_after_s`` the new one is not followed.
        Raises RigError, with the drive switched off, when it is too late (event ``sample_late``).
        """
        if late_s <= 0.0:
            return drive_voltage_v
        self.miss(Event.SAMPLE_LATE, late_s)
        return allowed_drive_v(self._guard, self._guard_limits)

    def trip(self, event: Event, details: str = "") -> None:
        """Switch the drive off for good and raise the RigError of an event; the first cause stays."""
        self._guard = tripped_by(self._guard, event)
        self.close()
        row = protection_table().row(event)
        where = f" ({details})" if details else ""
        off = "0 V was ordered" if event is Event.OUTPUT_STUCK else self._off_in_words()
        raise ProtectionTripError(f"{row.name}: {row.cause}{where}; {off}; {row.remedy}", event)

    def _off_in_words(self) -> str:
        return "the drive is off" if self._off_confirmed else NOT_CONFIRMED

    def make_safe(self) -> None:
        """Go to the sense voltage at once; a rig that is off for good stays off; never raises."""
        if not self._off_for_good:
            self._put_safe()
            self._forget_readings()

    def _forget_readings(self) -> None:
        """Begin anew after a pause, or after the wire was changed: the next reading is compared with none before."""
        self._guard = rested(self._guard, self._guard_limits)
        self._start_block()

    def close(self) -> None:
        """Switch the drive off and let go of the hardware; may be done twice."""
        self._off_for_good = True
        self._guard = closed(self._guard)
        self._switch_off()

    def __enter__(self) -> Self:
        """Return the rig itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Switch the drive off. Raises RigError where all went well and the device does not confirm the end."""
        was_on = not self._off_for_good
        self.close()
        if kind is None and was_on and not self._off_confirmed:
            raise RigError(f"the device did not answer at the end: {NOT_CONFIRMED}")
