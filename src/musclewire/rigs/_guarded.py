"""The rig: a device, and the protection table before and after each of its samples.

The wire's temperature is limited here. The limit is that of wire and rig file (``_wire_limits``). At the start the wire
is as warm as it was left, or rests at the sense voltage until it is cold (``_remembered_temperature``). Before each
drive ``_allowed`` looks ahead and, in a loop, gives the sense voltage in place of a drive that would end above the
limit; after each sample the protection (``controllers._protection``) takes the larger of the ordered and the measured
power and trips above it. A wire that passes B with less power than still air takes counts as one that loses less heat
from then on (``experiment._calm_air``). The default controller has a ceiling of its own in steady power, from the
recording that its gains are of; it knows nothing of these limits.
"""

from __future__ import annotations

import atexit
import logging
import math
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from numbers import Real
from threading import RLock, get_ident
from time import perf_counter_ns
from types import TracebackType
from typing import NoReturn, Self, final

from musclewire.controllers import (
    DRIVEN_FRACTION,
    STUCK_FRACTION,
    Event,
    Protection,
    ProtectionLimits,
    ProtectionState,
    Rows,
    State,
    protection_table,
)
from musclewire.errors import CallerError, NumericsError, RigError, an_object, argument
from musclewire.rigs._device import (
    DEVICE_METHODS,
    DEVICE_PROPERTIES,
    Device,
    DeviceFault,
    HasCompiledExchange,
    HasOnBoardLoop,
    HasTrueState,
    Metadata,
    Missing,
)
from musclewire.rigs._idle_watch import IdleWatch
from musclewire.rigs._remembered_temperature import RememberedTemperature
from musclewire.rigs._two_clocks import TwoClocks
from musclewire.signals import Command, Drive, RawSample, Target, drive_voltage_of

# Python 3.11 takes longer to look up a member of an enumeration than to compare it.
RUN, TRIPPED, DEGRADED = int(State.RUN), int(State.TRIPPED), int(State.DEGRADED)
# The device's word on its drive counts within this fraction of the maximum voltage, if by both the wire is driven or by
# neither; else what was ordered does.
DRIVE_AGREEMENT = STUCK_FRACTION
# Longest time [s] for which a device may say that a sample is missing, by the host's own clock.
MAX_WAIT_S = 1.0
# A time between two samples within this much of the sample period is the sample period [s]: clocks round.
CLOCK_ROUNDING_S = 1e-6
# No more is known of a device that does not answer.
NOT_CONFIRMED = (
    "0 V was ordered and nothing confirms it: a board's drive expires by itself, a card's guardian has tried to switch "
    "off; cut the supply to be sure"
)


OPEN_RIGS: weakref.WeakSet[GuardedRig] = weakref.WeakSet()


@atexit.register
def close_open_rigs() -> None:
    """Switch off what is still open when the interpreter ends."""
    for rig in list(OPEN_RIGS):
        rig.close()


LOGGER = logging.getLogger("musclewire.rigs")


class SecondThreadError(CallerError):
    """Another thread is in an exchange with this rig."""


class ProtectionTripError(RigError):
    """The protection has switched the drive off; ``event`` is the cause."""

    def __init__(self, message: str, event: Event) -> None:
        """Keep the event with the message."""
        super().__init__(message)
        self.event = event


@final
class GuardedRig:
    """A device with the protection table around it, which no script, policy or experiment can bypass by accident.

    The only implementation of a rig, simulated or real; :func:`musclewire.open_rig` makes it. The device takes one
    sample and can switch its output off; which drive is allowed and when to switch off is decided here, for all devices
    alike.

    One thread exchanges. ``close`` may be called from another one while a sample is awaited: the drive goes off, and
    the exchange ends with a RigError.

    A rig whose samples come at the pace of a real clock goes to its sense voltage when nobody has talked to it for
    ``sense_after_s`` of the protection table after a sample was due; the next exchange says so, to the logger
    ``musclewire.rigs``, and runs. It is switched off when nobody holds it any more, and every rig when the interpreter
    ends.

    Parameters
    ----------
    device
        An open device with 0 V out. It is switched off if its limits are refused.
    known_by
        How a device without an identity is known again; by default by its class.
    wire_temperature_k
        How warm the wire is [K], if that is not remembered; without it such a wire rests before it is heated.

    Attributes
    ----------
    device
        The guarded device. Its abilities are looked up by ``musclewire.rigs._abilities``. A program that drives it
        directly, such as an emulated circuit, bypasses the protection on purpose.
    drive_at_ns, sample_at_ns
        Times at which the last drive was handed to the output and its sample had come (``time.perf_counter_ns``): the
        time between a sample and the next drive is the host's computing time, with the protection's.
    air_is_known
        Whether it was said, or judged by a model, what loss to its air the wire is protected by.
    air_is_stated
        Whether its user has stated that loss: what a run finds of the air then changes nothing.

    Raises
    ------
    CallerError
        For limits that cannot belong to a wire, and for a temperature that is stated of a wire that states its own.
    """

    def __init__(self, device: Device, known_by: str | None = None, wire_temperature_k: float | None = None) -> None:
        """Arm the protection, and compile all that a sample runs: from here on nothing compiles with the wire driven.

        Raises CallerError for what is no device, for limits that cannot belong to a wire, and for a temperature that is
        stated of a wire that states its own.
        """
        missing = [name for name in (*DEVICE_PROPERTIES, *DEVICE_METHODS) if not hasattr(device, name)]
        if missing:
            raise CallerError(
                f"a GuardedRig holds a Device, and {an_object(device)} is none: it has no {' and no '.join(missing)} "
                "(docs/how-to/bring_your_own_plant.md)"
            )
        self.device = device
        self._facts = device.facts
        try:
            self._limits = self._facts.limits.checked()
        except CallerError:
            device.off()
            raise
        self._accepts_targets = isinstance(device, HasOnBoardLoop)
        identity, own_k = remembered_by(device, known_by), self._facts.wire_temperature_k
        if identity is None and wire_temperature_k is not None:
            device.off()
            raise CallerError("this rig's wire is new at each opening: leave out " + argument("wire_temperature_k"))
        stated_k = own_k if wire_temperature_k is None else wire_temperature_k
        self._remembered = RememberedTemperature(identity, self._limits, stated_k=stated_k)
        at_opening = self._remembered.at_opening
        if at_opening.reason:
            again = f"; for want of an identity of its own it is known again by {identity}"
            LOGGER.warning("%s%s", at_opening.reason, again if self._facts.identity is None else "")
        self._protection = Protection(self._limits, at_opening.temperature_k)
        # So many samples at the sense voltage come before the first that heats.
        self._rest = math.ceil(at_opening.rest_s / self._facts.sample_period_s)
        if isinstance(device, HasCompiledExchange):
            device.compile_exchange()
        # Held whenever the protection's state is read and written, never while a sample is awaited.
        self._deciding = RLock()
        self._last_time_s: float | None = None
        # The drive that was ordered last, the highest one of this exchange and that of the one before; and whether the
        # rig has paused since the last sample, at the sense voltage.
        self._ordered_v = self._highest_v = self._before_v = 0.0
        self._may_hold_back, self._samples_held_back = False, 0
        self._paused = False
        self._missed_s = 0.0  # for how long this exchange's sample has been missing
        # The thread that is in an exchange; when the last one ended; since when nobody has talked to a driven rig.
        self._exchanging: int | None = None
        self._talked_ns = perf_counter_ns()
        self._silent_since_ns: int | None = None
        self._silence_s = self._facts.sample_period_s + protection_table().sense_after_s
        self._off_for_good, self._off_confirmed = False, True
        self.drive_at_ns = self.sample_at_ns = 0
        self.air_is_known = self.air_is_stated = False
        self._watch: IdleWatch | None = None
        # A simulation's clock runs at any speed, and the host's says nothing of its wire.
        self._clocks = TwoClocks() if self._facts.paced and not isinstance(device, HasTrueState) else None
        if self._facts.paced:
            weakref.finalize(self, device.off)  # at the interpreter's end, too
            self._watch = IdleWatch(self._rest_if_silent, self._silence_s)
        OPEN_RIGS.add(self)

    @property
    def sample_period_s(self) -> float:
        """Time between samples [s]."""
        return self._facts.sample_period_s

    @property
    def paced(self) -> bool:
        """Whether samples come at the pace of a real clock."""
        return self._facts.paced

    @property
    def sense_voltage_v(self) -> float:
        """Drive voltage [V] that heats the wire by little and still lets its resistance be measured."""
        return self._limits.sense_voltage_v

    @property
    def maximum_voltage_v(self) -> float:
        """Highest drive voltage [V] this rig allows."""
        return self._limits.maximum_voltage_v

    @property
    def drive_amplitude_v(self) -> float:
        """Amplitude [V] at which this rig's wire completes its transformation in a slow sine."""
        return self._facts.drive_amplitude_v

    @property
    def shunt_resistance_ohm(self) -> float:
        """R of Eq. 1 [ohm]."""
        return self._limits.shunt_resistance_ohm

    @property
    def leg_length_m(self) -> float:
        """Length whose relative shortening is the strain [m]: one leg of the V."""
        return self._facts.leg_length_m

    @property
    def reference_columns(self) -> tuple[str, ...]:
        """Names of the reference instruments."""
        return self._facts.reference_columns

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage [V] that is out now."""
        return self.device.drive_voltage_v

    @property
    def is_driven(self) -> bool:
        """Whether more than the sense voltage was ordered last, answered or not."""
        return self._ordered_v > self.sense_voltage_v

    @property
    def off_confirmed(self) -> bool:
        """Whether the device has confirmed 0 V when it was switched off; true as long as it was not."""
        return self._off_confirmed

    @property
    def protection(self) -> ProtectionState:
        """State of the protection, with the last event and the estimated temperature."""
        return self._protection.state

    @property
    def protection_limits(self) -> ProtectionLimits:
        """The limits that the protection table applies."""
        return self._limits

    def __repr__(self) -> str:
        """Name the guarded device."""
        return f"GuardedRig({self.device!r})"

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this rig."""
        described = self.device.metadata()
        if self._samples_held_back == 0:
            return described
        limit_degc = self._limits.maximum_temperature_k - 273.15
        held_back = (
            f"the protection gave the sense voltage for {self._samples_held_back} samples: the ordered power "
            f"would have made the wire hotter than {limit_degc:.0f} C; if it is cooled better than in still air, or "
            "gets less than is ordered, say so in its rig file (limits, arrives)"
        )
        return {**described, "held_back": held_back}

    def exchange(self, command: Command | float) -> RawSample:
        """Follow a command for one sample period and return the sample at its end.

        While readings are missing the protection holds the drive or lowers it; the sample's ``drive_voltage_v`` is
        what was out. A target goes to the device's own closed loop, whose drive is judged like any other.

        Parameters
        ----------
        command
            A drive voltage [V], as a :class:`~musclewire.signals._exchange.Drive` or a bare number, or a
            :class:`~musclewire.signals._exchange.Target` for a device with a closed loop of its own.

        Returns
        -------
        The sample.

        Raises
        ------
        RigError
            With the drive switched off, for a voltage outside 0 to the maximum, for every event of the protection table
            that trips, and if another thread has closed the rig. Any other exception between entry and return, Ctrl-C
            too, leaves the rig at its sense voltage.
        NumericsError
            With the drive switched off, from a simulation that cannot continue.
        CallerError
            For what is no voltage, for a target if the device has no closed loop of its own, and, with the other
            exchange undisturbed, while another thread is in one.
        """
        # All of it is inside, the return too: wherever Ctrl-C or another exception comes, the drive is not left on.
        try:
            if self._rest and self._may_heat(command):
                self._rest_first()
            sample = self._exchanged(command)
            self._rest = max(self._rest - 1, 0)
            self._talked_ns, self._exchanging = perf_counter_ns(), None
            return sample
        except SecondThreadError:  # the drive belongs to the exchange of the other thread
            raise
        except BaseException:
            self._exchanging = None
            try:
                self._leave_safe()
            except BaseException:  # Ctrl-C while another error is dealt with
                self._leave_safe()
                raise
            raise

    def _may_heat(self, command: Command | float) -> bool:
        """Return whether a command may be more than the sense voltage, at which the wire rests."""
        voltage_v = command.voltage_v if isinstance(command, Drive) else command
        return isinstance(command, Target) or (isinstance(voltage_v, Real) and voltage_v > self.sense_voltage_v)

    def _rest_first(self) -> None:
        """Stay at the sense voltage until a wire of unknown temperature is cold."""
        while self._rest:
            self._exchanged(Drive(self.sense_voltage_v))
            self._rest, self._talked_ns = self._rest - 1, perf_counter_ns()

    def rest(self) -> None:
        """Stay at the sense voltage until a wire of unknown temperature is cold, as the first drive above it would.

        A run whose time begins with its first sample rests before. Raises what ``exchange`` raises.
        """
        while self._rest:
            self.exchange(self.sense_voltage_v)

    def _exchanged(self, command: Command | float) -> RawSample:
        """Follow a command for one sample period and return the sample at its end."""
        with self._deciding:
            if self._exchanging not in (None, get_ident()):
                raise SecondThreadError("another thread is in an exchange with this rig: let one thread exchange")
            self._exchanging = get_ident()
            if self._off_for_good:
                raise RigError("this rig is closed or has failed and stays off: open it again")
            if self._silent_since_ns is not None:
                self._say_silence()
            allowed = self._allowed(command)
        sample = self._awaited(allowed)
        with self._deciding:
            if self._off_for_good:
                self._end_as_switched_off()
            if isinstance(allowed, Target):
                # The protection judges what the device applied as if the host had commanded it.
                self._ordered_v = self._highest_v = sample.drive_voltage_v
                self._protection.command(min(sample.drive_voltage_v, self.maximum_voltage_v))
            self._judge(sample)
        return sample

    def protection_rows(self) -> tuple[Rows, Rows]:
        """Return a copy of the protection's row, and the rules that it goes by, for samples in compiled code."""
        return self._protection.row.copy(), self._protection.rules

    def adopt_compiled_samples(self, protection: Rows, time_s: float) -> None:
        """Go on from sound samples of a simulated device in compiled code.

        Parameters
        ----------
        protection
            Row of the protection after them, one record.
        time_s
            End of the last sample on the rig's clock [s].

        Raises
        ------
        RigError
            If another thread has closed the rig meanwhile.
        """
        with self._deciding:
            if self._off_for_good:
                self._end_as_switched_off()
            self._protection.row[:] = protection
            self._last_time_s = time_s

    def _allowed(self, command: Command | float) -> Command:
        """Return the command that is allowed now. Raises as ``exchange`` does for one that never is."""
        if isinstance(command, Target):
            if not self._accepts_targets:
                drive_voltage_of(command)  # says why it cannot be
            return command
        drive_voltage_v = command.voltage_v if isinstance(command, Drive) else command
        if type(drive_voltage_v) is not float:
            drive_voltage_v = checked_voltage_v(drive_voltage_v)
        allowed_v, state = self._protection.command(drive_voltage_v)
        if state == TRIPPED:
            self.close()
            raise ProtectionTripError(
                f"drive voltage {drive_voltage_v} V is outside 0 to {self.maximum_voltage_v} V; {self._off_in_words()}",
                Event.COMMAND_REFUSED,
            )
        expected_s = 0.0 if self._clocks is None else self._clocks.expected_s
        too_hot = self._too_hot_after(allowed_v, max(expected_s, self._facts.sample_period_s))
        if too_hot and self._may_hold_back:
            self._samples_held_back += 1
            return Drive(self.sense_voltage_v, by_protection=True)
        if too_hot:
            self._trip(Event.OVER_TEMPERATURE, too_hot)
        return Drive(allowed_v, by_protection=state != RUN)

    def _too_hot_after(self, drive_voltage_v: float, dt_s: float) -> str:
        """Return in words how hot the wire would count as after a drive for so long; "" within its limit."""
        if not self.sense_voltage_v < drive_voltage_v < math.inf:  # what follows a target is not known beforehand
            return ""
        limit_k = self._limits.maximum_temperature_k
        after_k = self._protection.temperature_after_k(drive_voltage_v, dt_s)
        if after_k <= limit_k:
            return ""
        said = f"estimated {after_k - 273.15:.0f} C, limit {limit_k - 273.15:.0f} C"
        return f"{dt_s:.2f} s at {drive_voltage_v:.3f} V would end with {said}"

    @contextmanager
    def holding_back(self) -> Iterator[None]:
        """Give the sense voltage in place of a drive that would heat the wire too far, for as long as this lasts.

        For loops; an open-loop drive trips, as a mistake of whoever chose it. What was held back is in the metadata.
        """
        self._may_hold_back, self._samples_held_back = True, 0
        try:
            yield
        finally:
            self._may_hold_back, self._samples_held_back = False, 0

    def _awaited(self, command: Command) -> RawSample:
        """Return the sample of a command; while it is missing, the table decides the drive and how long to wait."""
        self.drive_at_ns = perf_counter_ns()
        waited_s, since_ns = 0.0, 0
        self._before_v, self._highest_v, self._missed_s = self._highest_v, 0.0, 0.0
        while True:
            self._ordered_v = command.voltage_v if isinstance(command, Drive) else math.inf
            self._highest_v = max(self._highest_v, self._ordered_v)
            try:
                answer = self.device.exchange(command)
            except (RigError, NumericsError):
                self._end_unless_switched_off()
                raise
            if isinstance(answer, RawSample):
                self.sample_at_ns = perf_counter_ns()
                return answer
            with self._deciding:
                if self._off_for_good:
                    self._end_as_switched_off()
                if isinstance(answer, DeviceFault):
                    self._trip(answer.event, answer.details)
                if not isinstance(answer, Missing):
                    self._trip(Event.DEVICE_LOST, f"it answered {answer!r:.60} where a sample is due")
                since_ns = since_ns or perf_counter_ns()
                self._require_progress(answer, waited_s, 1e-9 * (perf_counter_ns() - since_ns))
                waited_s = self._missed_s = answer.missing_s
                command = self._miss(answer)
            if answer.sample is not None:
                self.sample_at_ns = perf_counter_ns()
                return answer.sample

    def _require_progress(self, answer: Missing, waited_s: float, own_s: float) -> None:
        """Trip if a device waits whose clock does not go on, or not as the host's does."""
        if not answer.missing_s >= 0.0 or (answer.sample is None and not answer.missing_s > waited_s):
            self._trip(Event.DEVICE_LOST, f"the device waits, but its clock stays at {answer.missing_s:.3f} s")
        if own_s > MAX_WAIT_S:
            said = f"{answer.missing_s:.3g} s by its clock, and {own_s:.1f} s by the host's"
            self._trip(Event.DEVICE_LOST, f"the device has waited for a sample for {said}")

    def _miss(self, missing: Missing) -> Drive:
        """Hold, go to the sense voltage or trip, by the total time that something was missing; the drive meanwhile."""
        before = int(self._protection.state.state)
        waiting_s = self._facts.sample_period_s + missing.missing_s
        if missing.sample is None and (too_hot := self._too_hot_after(self._highest_v, waiting_s)):
            self._trip(Event.OVER_TEMPERATURE, too_hot)
        allowed_v, state = self._protection.missing(missing.event, missing.missing_s)
        if state == DEGRADED != before:
            text = "%s for %.2f s: the drive went to the sense voltage, %g V"
            LOGGER.info(text, missing.event.name.lower().replace("_", " "), missing.missing_s, self.sense_voltage_v)
        if state == TRIPPED:
            self._trip(missing.event, f"missing for {missing.missing_s:.3f} s")
        return Drive(allowed_v, by_protection=state != RUN)

    def _judge(self, sample: RawSample) -> None:
        """Run the protection over a sample."""
        drive_v = self._counted_drive_v(sample.drive_voltage_v)
        ordered_v = max(drive_v, self._highest_v)
        before_s, paused = self._last_time_s, self._paused
        # Whatever its clock says, it has taken no less time than the device said that it was missing.
        covered_s = max(self._covered_s(sample.time_s), self._facts.sample_period_s + self._missed_s)
        if self._clocks is not None or covered_s > self._facts.sample_period_s:
            ordered_v = max(ordered_v, self._before_v)  # until the order arrived the drive before was out
        if self._clocks is not None:
            step_s = None if paused or before_s is None else sample.time_s - before_s
            covered_s = self._longer_s(self._clocks, covered_s, step_s, ordered_v > self.sense_voltage_v)
        protection = self._protection
        sound = protection.sample(drive_v, sample.wire_voltage_v, sample.shunt_voltage_v, covered_s, ordered_v)
        self._remembered.note(protection.temperature_k)
        if not sound and protection.tripped:
            measured = self._measured(*protection.last_reading_v)
            self._trip(protection.state.event, f"at {sample.time_s:.3f} s: {measured}")

    def _covered_s(self, time_s: float) -> float:
        """Return the time that a sample stands for [s], by the device's clock; trip if that goes back or leaps."""
        last_s, period_s, paused = self._last_time_s, self._facts.sample_period_s, self._paused
        if last_s is None:
            last_s, paused = time_s - period_s, True
        if not time_s > last_s:  # nor is it if the time is no number
            self._trip(Event.CLOCK_BACKWARDS, f"{time_s:.6f} s after {last_s:.6f} s")
        self._last_time_s, self._paused = time_s, False
        covered_s = time_s - last_s
        if paused or covered_s <= period_s + CLOCK_ROUNDING_S:
            # How warm the wire is after a pause is not known: as warm as before is on the safe side. A clock that runs
            # slow takes no heat away.
            return period_s
        longest_s = 2.0 * period_s + protection_table().trip_after_s
        if covered_s <= longest_s:
            return covered_s
        if not self._was_idle(covered_s):
            self._trip(Event.CLOCK_LEAPT, f"{time_s:.6f} s after {last_s:.6f} s, samples come every {period_s:g} s")
        return period_s

    def _longer_s(self, clocks: TwoClocks, device_s: float, step_s: float | None, heated: bool) -> float:
        """Return the time that a sample covers by the longer of two clocks; trip if they differ for good.

        ``step_s`` is what the device's clock went on by since the sample before; None after a pause.
        """
        if step_s is None:
            clocks.rest()
        said = clocks.difference(step_s or 0.0, self.sample_at_ns)
        if said:
            self._trip(Event.CLOCK_LEAPT, said)
        return clocks.covered_s(device_s, heated, self.drive_at_ns, self.sample_at_ns)

    def _was_idle(self, covered_s: float) -> bool:
        """Whether a rig has been at rest before this order for so long by the host's clock, too."""
        own_s = 1e-9 * (perf_counter_ns() - self._talked_ns)
        return self._facts.paced and self._before_v <= self.sense_voltage_v and covered_s <= own_s + self._silence_s

    def _counted_drive_v(self, said_v: float) -> float:
        """Return the drive [V] by which a sample is judged: what was ordered, unless the device agrees with it."""
        ordered_v, driven_v = self._ordered_v, DRIVEN_FRACTION * self.sense_voltage_v
        near = abs(said_v - ordered_v) <= DRIVE_AGREEMENT * self.maximum_voltage_v
        return said_v if near and (said_v >= driven_v) == (ordered_v >= driven_v) else ordered_v

    def _measured(self, drive_v: float, wire_v: float, shunt_v: float) -> str:
        """Describe the reading at which the protection tripped."""
        ohm = f", {wire_v / shunt_v * self.shunt_resistance_ohm:.3f} ohm" if shunt_v else ""
        limit_c = self._limits.maximum_temperature_k - 273.15
        warmth = f"estimated {self._protection.temperature_k - 273.15:.0f} C, limit {limit_c:.0f} C"
        return f"drive {drive_v:.3f} V, wire {wire_v:.4f} V, shunt {shunt_v:.4f} V{ohm}, {warmth}"

    def _trip(self, event: Event, details: str) -> NoReturn:
        """Switch the drive off for good and raise the RigError of an event; the first cause stays."""
        self._protection.trip(event)
        self.close()
        row = protection_table().row(event)
        off = "0 V was ordered" if event is Event.OUTPUT_STUCK else self._off_in_words()
        raise ProtectionTripError(f"{row.name}: {row.cause} ({details}); {off}; {row.remedy}", event)

    def _end_unless_switched_off(self) -> None:
        """Switch off after an error of the device; if another thread has switched off, report that instead."""
        with self._deciding:
            if self._off_for_good:
                self._end_as_switched_off()
            self.close()

    def _end_as_switched_off(self) -> NoReturn:
        raise RigError(f"this rig was closed while a sample was awaited; {self._off_in_words()}") from None

    def _off_in_words(self) -> str:
        return "the drive is off" if self._off_confirmed else NOT_CONFIRMED

    def make_safe(self) -> None:
        """Go to the sense voltage at once; a rig that is off for good stays off; never raises."""
        with self._deciding:
            if self._off_for_good:
                return
            if self.device.sense():
                self._ordered_v = self._highest_v = min(self._ordered_v, self.sense_voltage_v)
                self.forget_readings()
            else:
                self.close()  # a device that cannot go to the sense voltage is switched off

    def _leave_safe(self) -> None:
        """Go to the sense voltage, or off for good if that was on its way when something came between."""
        with self._deciding:
            if self._off_for_good:
                self.close()
            else:
                self.make_safe()

    def _rest_if_silent(self) -> float:
        """Go to the sense voltage if nobody has talked to a driven rig for too long; return when to look again [s]."""
        with self._deciding:
            left_s = self._silence_s - 1e-9 * (perf_counter_ns() - self._talked_ns)
            if left_s > 0.0 or self._exchanging is not None or self._off_for_good:
                return max(left_s, 0.01)
            if self._ordered_v > self.sense_voltage_v:
                self._silent_since_ns = self._talked_ns
                self.make_safe()
            return self._silence_s

    def _say_silence(self) -> None:
        """Say that the rig was at rest because nobody talked to it."""
        assert self._silent_since_ns is not None
        silent_s = 1e-9 * (perf_counter_ns() - self._silent_since_ns)
        self._silent_since_ns = None
        text = "nobody talked to the rig for %.1f s: it went to its sense voltage, %g V, and goes on from there"
        LOGGER.warning(text, silent_s, self.sense_voltage_v)

    def lower_heat_loss(self, heat_loss_w_per_k: float, reason: str) -> None:
        """Let the protection count with less heat loss, until this rig is closed; nothing raises it again.

        Parameters
        ----------
        heat_loss_w_per_k
            Loss of the wire to what surrounds it [W/K]; one that is not below the present limit changes nothing.
        reason
            Where it is known from, in words, for the warning.

        Raises
        ------
        CallerError
            For a loss that is not above 0.
        """
        with self._deciding:
            before = self._limits.heat_loss_w_per_k
            if not heat_loss_w_per_k < before:
                return
            self._limits = self._limits._replace(heat_loss_w_per_k=heat_loss_w_per_k).checked()
            self._protection.rules["heat_loss_w_per_k"] = heat_loss_w_per_k
        text = (
            "%s: from here on the wire counts as hotter, as with %.2g of its heat loss; state its loss_factor or "
            "ambient_temperature in the rig file: loss_factor = 1 if it hangs bare in still air and turns below its "
            "alloy's temperature"
        )
        LOGGER.warning(text, reason, heat_loss_w_per_k / before)

    def forget_readings(self) -> None:
        """Start again after a pause, or after the wire was changed: the next reading is not compared with the last."""
        with self._deciding:
            self._protection.rest()
            self._paused = True

    def close(self) -> None:
        """Switch the drive off and release the hardware; may be called twice, and from another thread."""
        with self._deciding:
            self._off_for_good, self._ordered_v = True, 0.0
            if self._watch is not None:
                self._watch.end()
            self._protection.close()
            self._off_confirmed = self.device.off()
            self._remembered.close()

    def __enter__(self) -> Self:
        """Return the rig itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Switch the drive off. Raises RigError if all went well and the device does not confirm the end."""
        was_on = not self._off_for_good
        self.close()
        if kind is None and was_on and not self._off_confirmed:
            raise RigError(f"the device did not answer at the end: {NOT_CONFIRMED}")


def remembered_by(device: Device, known_by: str | None) -> str | None:
    """Return what a device's wire is known by: its identity, its rig file, or its class; None if it is new."""
    facts = device.facts
    if facts.identity is not None or facts.wire_temperature_k is not None:
        return facts.identity
    return known_by or f"class {type(device).__module__}.{type(device).__qualname__}"


def checked_voltage_v(voltage_v: object) -> float:
    """Return a commanded voltage as a number. Raises CallerError for anything that is none."""
    if isinstance(voltage_v, bool) or not isinstance(voltage_v, Real):
        raise CallerError(f"a drive of {voltage_v!r:.60} is no voltage: give a number of volts")
    return float(voltage_v)


# What takes any rig names it so.
Rig = GuardedRig


def refuse_no_rig(rig: object) -> None:
    """Raise CallerError for what is no rig: a device without its guard, or somebody's own driver."""
    if not hasattr(rig, "exchange") or not hasattr(rig, "sense_voltage_v"):
        raise CallerError(
            f"a rig is driven, as open_rig returns it, not {an_object(rig)}: hardware of your own becomes one by the "
            'line kind = "python:module:Class" of a rig file, or by GuardedRig(device) '
            "(docs/how-to/bring_your_own_plant.md)"
        )
