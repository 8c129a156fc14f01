"""A board as a device: one exchange is one drive command and the mean of the board's samples of its sample period."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Callable, Iterable
from math import isfinite
from threading import RLock
from typing import Annotated, Literal, NoReturn

from pydantic import Field

from musclewire.controllers import Event, FeedforwardSettings, FuzzyPidSettings, State
from musclewire.errors import CallerError, RigError
from musclewire.extras.board._serial.board import Board, BoardOffMeanwhileError, LinkStormError
from musclewire.extras.board._serial.line import LineLostError, open_line
from musclewire.extras.board._serial.message_types import (
    Acknowledgement,
    AcknowledgementResult,
    BoardEvent,
    BoardSample,
    MessageKind,
)
from musclewire.extras.board._serial.messages import BoardIdentity, Message, payload_of
from musclewire.extras.board._serial.ports import identity_of
from musclewire.rigs import (
    SWITCHED_OFF,
    Answer,
    DeviceConfiguration,
    DeviceFacts,
    DeviceFault,
    DeviceKind,
    LivePeriod,
    Metadata,
    MountedWire,
)
from musclewire.sensing import Correction, SensingModel
from musclewire.signals import Command, RawSample, Target, measured_in

Volts = Annotated[float, measured_in("V"), Field(gt=0.0, allow_inf_nan=False)]
Seconds = Annotated[float, measured_in("s"), Field(gt=0.0, le=60.0)]


class SerialConfiguration(MountedWire, DeviceConfiguration):
    """A rig file with ``kind = "serial"``: the wire that is mounted, and the board that drives it.

    Attributes:
        sample_period: time between samples, at most 50 ms, so that every fault ends with 0 V within half a second.
        port: ``/dev/ttyACM0``, ``COM3``, or a URL of pyserial's such as ``socket://127.0.0.1:4000``.
        baud: speed of the line in bits per second; a board on USB takes any.
        patience: time for which a sample may be overdue before the board counts as lost.
        wire_range: end of the range of the channel that reads the wire.
        shunt_range: end of the range of the channel that reads the shunt.
        readings_noisy: whether noise changes every reading, so that a constant reading is a fault by itself.
        lockstep: whether time passes only for commands, in an emulator: the host's clock then says nothing.
    """

    kind: Literal["serial"]
    sample_period: LivePeriod = 0.05
    port: str = Field(min_length=1)
    baud: int = Field(default=115200, ge=1200, le=12_000_000)
    patience: Seconds = 0.25
    wire_range: Volts
    shunt_range: Volts
    readings_noisy: bool = True
    lockstep: bool = False


# Samples that the board sends in a sample period, the first number that divides it: a lost one then costs a fifth.
FRAMES_PER_SAMPLE = (5, 4, 3, 2, 1)
# A command is sent again after this fraction of the patience.
REPEAT_FRACTION = 0.1
ATTEMPTS = 5
TICKS = 1 << 32
# Shunt and voltages that a rig file gives with three digits agree with the board's to this relative difference.
AGREEMENT = 5e-3
# Characters of a wire's name in the board's message: the board cuts off a longer one.
WIRE_CHARACTERS = 24
NO_TICK = -1
# What to do where a command that must be done is not, by the board's answer.
NOT_DONE: dict[int, str] = {
    AcknowledgementResult.UNKNOWN: "its firmware does not know that yet, update it (musclewire flash)",
    AcknowledgementResult.BAD_PAYLOAD: "a number in it is out of range",
}


class BoardFaultError(RigError):
    """A fault that ends an exchange, with its event; the exchange returns it as a :class:`DeviceFault`."""

    def __init__(self, event: Event, details: str) -> None:
        """Keep the event with the details."""
        super().__init__(details)
        self.event = event


class SerialDevice:
    """A wire on a microcontroller that runs musclewire's firmware.

    Its clock is the board's: time counts its ticks, so it does not drift against the samples. The board applies the
    same protection table and switches its drive off if no command comes; a trip of the board is a fault here. It
    follows targets with the loop of its firmware.
    """

    def __init__(
        self,
        configuration: SerialConfiguration,
        board: Board,
        clock_s: Callable[[], float] = time.monotonic,
        identity: str | None = None,
    ) -> None:
        """Read what the board is; the output stays at 0 V until the first exchange. ``identity`` is of the facts.

        Raises RigError if no board answers or it has another protocol version, CallerError if the rig file and the
        board contradict each other.
        """
        self._configuration, self._board, self._clock_s = configuration, board, clock_s
        self._drive_voltage_v = 0.0
        self._armed = self._paused = self._let_go = False
        self._off_confirmed = False
        self._correction: Correction | None = None
        # Another thread may call ``off``: the board's answer to it wakes the exchange, which then releases the line.
        self._talking = RLock()
        self._due_tick = NO_TICK
        self._tick, self._first_tick = NO_TICK, NO_TICK
        self._last: BoardSample | None = None
        self._unread: deque[Message] = deque()
        self._identity = board.hello()
        self._check_agreement()
        ticks = configuration.sample_period / self._identity.tick_period_s
        self._ticks = round(ticks)
        self._frames = next(count for count in FRAMES_PER_SAMPLE if self._ticks % count == 0)
        limits = configuration.protection_limits(
            wire_range_v=configuration.wire_range,
            shunt_range_v=configuration.shunt_range,
            readings_noisy=configuration.readings_noisy,
        )
        self._facts = DeviceFacts(
            sample_period_s=configuration.sample_period,
            paced=not configuration.lockstep,
            leg_length_m=configuration.leg_length_m,
            drive_amplitude_v=configuration.drive_amplitude,
            limits=limits,
            identity=identity,
            # A board without an identity is in memory, and new.
            wire_temperature_k=limits.ambient_temperature_k if identity is None else None,
        )
        # A trip that is latched from an earlier session is cleared: opening the rig acknowledges it.
        self._command(MessageKind.OFF, b"")
        self._command(MessageKind.STREAM, payload_of(MessageKind.STREAM, self._ticks // self._frames))

    def _check_agreement(self) -> None:
        """Raise CallerError if the rig file contradicts the board."""
        wanted, board = self._configuration, self._identity
        mounted = wanted.known_wire().name[:WIRE_CHARACTERS]
        if mounted != board.wire:
            raise CallerError(
                f"the board's firmware was built for wire {board.wire} and the rig file says {mounted}: flash the "
                "firmware of the wire that is mounted, or correct the rig file"
            )
        if abs(wanted.shunt - board.shunt_resistance_ohm) > AGREEMENT * board.shunt_resistance_ohm:
            raise CallerError(
                f"shunt is {wanted.shunt:g} ohm in the rig file and {board.shunt_resistance_ohm:g} ohm in the board's "
                "firmware: correct the one that is wrong"
            )
        if wanted.maximum_voltage > board.maximum_voltage_v * (1.0 + AGREEMENT):
            raise CallerError(
                f"maximum_voltage is {wanted.maximum_voltage:g} V in the rig file and the board gives "
                f"{board.maximum_voltage_v:g} V at most: lower it"
            )
        ticks = wanted.sample_period / board.tick_period_s
        if round(ticks) < 1 or abs(ticks - round(ticks)) > 1e-6 * ticks:
            raise CallerError(
                f"sample_period {wanted.sample_period:g} s is not a whole number of the board's ticks of "
                f"{board.tick_period_s:g} s: choose a multiple"
            )
        if wanted.sample_period * 1e3 >= board.expiry_ms:
            raise CallerError(
                f"sample_period {wanted.sample_period:g} s leaves the board without a command for longer than its "
                f"heater lives, {board.expiry_ms} ms: choose a shorter one"
            )

    @property
    def facts(self) -> DeviceFacts:
        """Facts of the board and its wire; a board has no reference instruments."""
        return self._facts

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage [V] that is out now, by the board's last sample."""
        return self._drive_voltage_v

    @property
    def identity(self) -> BoardIdentity:
        """Identity that the board has reported."""
        return self._identity

    def checksum_of(self, model: SensingModel, settings: FuzzyPidSettings | FeedforwardSettings, estimator: str) -> int:
        """Return the checksum that firmware reports which was built with a model and controller."""
        from musclewire.extras.board._c.library import loop_checksum

        return loop_checksum(model, settings, estimator=estimator)

    @property
    def model_checksum(self) -> int:
        """Checksum of the model and controller that the firmware was built with."""
        return self._identity.model_checksum

    @property
    def board_estimate(self) -> float | None:
        """The board's own estimate at the last exchange, in its model's unit (SI); None before the first."""
        return None if self._last is None else self._last.estimate

    @property
    def board_resistance_ohm(self) -> float | None:
        """The board's own resistance [ohm] at the last exchange; None before the first."""
        return None if self._last is None else self._last.resistance_ohm

    def correct(self, correction: Correction | None) -> None:
        """Let the board's loop run by a model that is corrected, as ``HasOnBoardLoop`` says."""
        self._correction = correction
        with self._talking, contextlib.suppress(BoardOffMeanwhileError):
            self._send_correction()

    def _send_correction(self) -> None:
        """Send the correction, if there is one, until the board confirms it. Raises RigError like ``correct``."""
        if self._correction is None:
            return
        payload = payload_of(MessageKind.CORRECT, self._correction.scale, self._correction.zero)
        for _ in range(ATTEMPTS):
            self._command(MessageKind.CORRECT, payload)
            if (taken := self._board.correction) is not None and payload_of(MessageKind.CORRECT, *taken) == payload:
                return
        raise RigError(f"the board on {self._configuration.port} confirms another correction: reset it and try again")

    def __repr__(self) -> str:
        """Name the board, its port, its wire and its drive."""
        return (
            f"SerialDevice({self._identity.board} on {self._configuration.port}, "
            f"wire {self._configuration.wire}, drive {self._drive_voltage_v:.3f} V)"
        )

    def metadata(self) -> Metadata:
        """Return the metadata of a recording that describe this board."""
        return {
            "rig": "serial",
            **self._configuration.facts(),
            "board": self._identity.board,
            "firmware_wire": self._identity.wire,
            "firmware_version": self._identity.firmware_version,
            "protocol_version": self._identity.protocol_version,
            "board_tick_s": self._identity.tick_period_s,
            "board_started_by": self._identity.reset_by,
            "port": self._configuration.port,
            "lost_frames": self._board.lost_frames,
            "broken_frames": self._board.parser.errors.total,
            "repeated_commands": self._board.repeated_commands,
        }

    def exchange(self, command: Command) -> Answer:
        """Let the board apply a drive voltage, or follow a target (SI, its model's quantity), for a sample period."""
        with self._talking:
            try:
                return self._period(command)
            except BoardOffMeanwhileError:
                return SWITCHED_OFF
            except LineLostError as error:
                return DeviceFault(Event.DEVICE_LOST, str(error))
            except LinkStormError as error:
                return DeviceFault(Event.LINK_CORRUPTED, str(error))
            except BoardFaultError as fault:
                return DeviceFault(fault.event, str(fault))

    def _period(self, command: Command) -> RawSample:
        """Send a command and return the mean of the samples of its sample period."""
        self._require_on()
        if not self._armed:
            self._arm()
        samples = self._samples_after(command)
        self._last = samples[-1]
        # A sample without a reading of the converter is NaN; the others of the period are averaged.
        samples = [one for one in samples if isfinite(one.wire_voltage_v + one.shunt_voltage_v)] or samples
        count = len(samples)
        self._drive_voltage_v = sum(sample.drive_voltage_v for sample in samples) / count
        return RawSample(
            time_s=(self._tick - self._first_tick) * self._identity.tick_period_s,
            drive_voltage_v=self._drive_voltage_v,
            wire_voltage_v=sum(sample.wire_voltage_v for sample in samples) / count,
            shunt_voltage_v=sum(sample.shunt_voltage_v for sample in samples) / count,
        )

    def _require_on(self) -> None:
        if self._board.only_off:
            raise BoardOffMeanwhileError("the line is to be closed: open the rig again")

    def _send(self, command: Command, sequence: int | None = None) -> int:
        """Send a command and return its sequence number; with a ``sequence`` it is the same command again."""
        if isinstance(command, Target):
            return self._board.send_target(command.value, sequence)
        return self._board.send_drive(command.voltage_v, sequence)

    def _samples_after(self, command: Command) -> list[BoardSample]:
        """Collect the samples that carry a command's number until the period is over."""
        sequence = self._send(command)
        repeat_s = REPEAT_FRACTION * self._configuration.patience
        start_s = received_s = sent_s = self._clock_s()
        found: list[BoardSample] = []
        while True:
            self._require_on()
            # Messages after the last period's end are read here, too: they may explain why the board has tripped.
            self._unread.extend(self._board.receive(0.0 if self._unread else repeat_s))
            while self._unread:
                message = self._unread.popleft()
                received_s = self._clock_s()
                self._raise_what_it_reports(message, sequence)
                if isinstance(message, BoardSample) and message.command_sequence == sequence:
                    found.append(message)
                    if self._is_over(message.tick):
                        return found
            now_s = self._clock_s()
            if not found and now_s - sent_s >= repeat_s:
                self._send(command, sequence)
                sent_s = now_s
            overdue_s = now_s - (received_s if found else start_s)
            if overdue_s > self._configuration.patience + self._configuration.sample_period:
                self._give_up(overdue_s)

    def _is_over(self, tick: int) -> bool:
        """Return whether a sample at a tick ends the period that is due; due ticks are on one grid, without drift."""
        every = self._ticks // self._frames
        if self._first_tick == NO_TICK:
            self._first_tick = self._tick = tick - every
        # The board's 32-bit counter wraps after weeks; here ticks continue.
        tick = self._tick + (tick - self._tick) % TICKS
        if self._due_tick == NO_TICK:
            self._due_tick = tick - every + self._ticks
        if tick < self._due_tick:
            return False
        self._tick = tick
        late = (tick - self._due_tick) // self._ticks
        self._due_tick += (1 + late) * self._ticks
        return True

    def _raise_what_it_reports(self, message: Message, sequence: int) -> None:
        """Raise BoardFaultError if the board has tripped, refused the command, or restarted."""
        if isinstance(message, (BoardSample, BoardEvent)) and message.state == State.TRIPPED:
            self._trip_as_the_board(message.event)
        if isinstance(message, BoardIdentity):  # not requested, so the board has restarted
            self._trip_restarted(message)
        if isinstance(message, BoardSample) and self._went_back(message.tick):
            self._trip_restarted(None)
        if isinstance(message, Acknowledgement) and message.sequence == sequence:
            if message.result == AcknowledgementResult.REFUSED:
                self._trip_refused()
            elif message.result != AcknowledgementResult.DONE:
                raise BoardFaultError(
                    Event.COMMAND_REFUSED, f"the board answered {message.result} to command {message.kind:#04x}"
                )

    def _went_back(self, tick: int) -> bool:
        return self._tick != NO_TICK and (tick - self._tick) % TICKS >= TICKS // 2

    def _trip_as_the_board(self, number: int) -> NoReturn:
        known = {event.value: event for event in Event if event is not Event.NONE}
        raise BoardFaultError(known.get(number, Event.DEVICE_LOST), f"seen by the board {self._identity.board}")

    def _trip_refused(self) -> NoReturn:
        """Raise BoardFaultError for a refused command: the board's next message has the cause, or it has restarted."""
        ends_s = self._clock_s() + self._configuration.sample_period
        while self._clock_s() < ends_s:
            self._require_on()
            self._unread.extend(self._board.receive(0.2 * self._configuration.sample_period))
            while self._unread:
                message = self._unread.popleft()
                if isinstance(message, (BoardSample, BoardEvent)) and message.state == State.TRIPPED:
                    self._trip_as_the_board(message.event)
                if isinstance(message, BoardIdentity):
                    self._trip_restarted(message)
        self._trip_restarted(None)

    def _trip_restarted(self, identity: BoardIdentity | None) -> NoReturn:
        """Raise BoardFaultError for a board that is no longer armed; without an identity it is requested."""
        if identity is None:
            with contextlib.suppress(RigError):
                identity = self._board.hello(self._configuration.patience)
        known = {Event.WATCHDOG.value: Event.WATCHDOG}
        event = Event.POWER_LOST if identity is None else known.get(identity.event_at_reset, Event.POWER_LOST)
        why = "it gives no reason" if identity is None else f"started by {identity.reset_by}"
        raise BoardFaultError(event, f"the board {self._identity.board} is not armed any more: {why}")

    def _give_up(self, overdue_s: float) -> NoReturn:
        raise BoardFaultError(Event.DEVICE_LOST, f"no sample for {overdue_s:.2f} s on {self._configuration.port}")

    def _arm(self) -> None:
        """Arm the board, on the first exchange and after a pause in which its heater has expired."""
        if self._paused:
            self._refuse_other_trips([*self._unread, *self._board.receive(0.0)])
        self._unread.clear()
        self._command(MessageKind.ARM, b"")
        self._send_correction()  # which a board forgets when it is armed
        self._due_tick = NO_TICK
        self._armed = True

    def _refuse_other_trips(self, messages: Iterable[Message]) -> None:
        """Raise BoardFaultError for a trip during a pause, except for missing commands: none were sent on purpose."""
        for message in messages:
            if (
                isinstance(message, (BoardSample, BoardEvent))
                and message.state == State.TRIPPED
                and message.event != Event.COMMAND_MISSING
            ):
                self._trip_as_the_board(message.event)

    def _command(self, kind: MessageKind, payload: bytes) -> None:
        """Send a command that must be acknowledged. Raises RigError if it is not, or is refused."""
        patience_s = max(REPEAT_FRACTION * self._configuration.patience, 0.02)
        answer = self._board.command(kind, payload, patience_s, ATTEMPTS * 2)
        if answer is None or answer.result != AcknowledgementResult.DONE:
            said = "did not answer" if answer is None else f"answered {answer.result}"
            advice = NOT_DONE.get(answer.result if answer else -1, "reset it and try again")
            raise RigError(f"the board on {self._configuration.port} {said} to {kind.name}: {advice}")

    def sense(self) -> bool:
        """Order the sense voltage once; a board that does not receive it switches off when its command expires."""
        sense_v = self._configuration.sense_voltage
        with contextlib.suppress(RigError):
            if self._armed:
                self._board.send_drive(sense_v)
        # Nothing is commanded from here on, so that the heater expires; the next exchange arms again.
        self._armed, self._paused = False, True
        self._drive_voltage_v = sense_v
        return True

    def off(self) -> bool:
        """Order 0 V at once, then close the line; return whether the board has confirmed it."""
        with contextlib.suppress(RigError):
            if not self._let_go:
                self._board.order_off()
        with self._talking:
            if not self._let_go:
                self._off_confirmed = self._answers_off()
            self._board.close()
            self._armed, self._let_go = False, True
            self._drive_voltage_v = 0.0
            return self._off_confirmed

    def _answers_off(self) -> bool:
        """Order 0 V and return whether the board confirms it."""
        patience_s = REPEAT_FRACTION * self._configuration.patience
        try:
            answer = self._board.command(MessageKind.OFF, b"", patience_s, ATTEMPTS)
        except RigError:
            return False
        return answer is not None and answer.result == AcknowledgementResult.DONE


def opened(configuration: SerialConfiguration) -> SerialDevice:
    """Return a rig file's board. Raises RigError without an answer, CallerError if file and firmware disagree."""
    board = Board(open_line(configuration.port, configuration.baud, configuration.patience))
    try:
        return SerialDevice(configuration, board, identity=identity_of(configuration.port))
    except BaseException:
        board.close()
        raise


SERIAL = DeviceKind(SerialConfiguration, opened)
