"""A board as a rig: one exchange is one drive command and the mean of the board's samples of its sample period."""

from __future__ import annotations

import contextlib
import struct
import time
from collections import deque
from collections.abc import Callable, Iterable
from math import isfinite

from musclewire.controllers.protection import Event
from musclewire.errors import CallerError, RigError
from musclewire.rigs.guarded import GuardedRig
from musclewire.rigs.protocol import Metadata
from musclewire.rigs.serial.configuration import SerialConfiguration
from musclewire.rigs.serial.device import Board, LinkStormError
from musclewire.rigs.serial.line import LineLostError
from musclewire.rigs.serial.messages import (
    Acknowledgement,
    AcknowledgementResult,
    BoardEvent,
    BoardSample,
    BoardState,
    Identity,
    Message,
    MessageKind,
)
from musclewire.signals.commands import Command, Target
from musclewire.signals.samples import RawSample

__all__ = ["SerialRig"]

# Samples the board sends in a sample period, as far as the period divides: one that is lost then costs a fifth.
FRAMES_PER_SAMPLE = (5, 4, 3, 2, 1)
# A command is sent again after this share of the patience.
REPEAT_SHARE = 0.1
ATTEMPTS = 5
TICKS = 1 << 32
# Shunt and voltages that a rig file gives with three digits agree with the board's to this share.
AGREEMENT = 5e-3
NO_TICK = -1


class SerialRig(GuardedRig):
    """A wire behind a microcontroller that runs musclewire's firmware.

    The rig's clock is the board's: time counts its ticks, so it does not drift against the samples. The board holds the
    same protection table and lets the heater expire when no command comes; what trips there is raised here.
    """

    def __init__(
        self, configuration: SerialConfiguration, board: Board, clock_s: Callable[[], float] = time.monotonic
    ) -> None:
        """Ask the board what it is and arm the protection; the output stays at 0 V until the first exchange.

        Raises RigError where no board answers or it speaks another version, CallerError where the rig file and the
        board contradict each other.
        """
        self._configuration, self._board, self._clock_s = configuration, board, clock_s
        self._drive_voltage_v = 0.0
        self._armed = self._paused = self._let_go = False
        self._due_tick = NO_TICK
        self._tick, self._first_tick = NO_TICK, NO_TICK
        self._last: BoardSample | None = None
        self._unread: deque[Message] = deque()
        self._identity = board.hello()
        self._check_agreement()
        ticks = configuration.sample_period / self._identity.tick_period_s
        self._ticks = round(ticks)
        self._frames = next(count for count in FRAMES_PER_SAMPLE if self._ticks % count == 0)
        self.protect_with(
            configuration.protection_limits(
                wire_range_v=configuration.wire_range,
                shunt_range_v=configuration.shunt_range,
                readings_noisy=configuration.readings_noisy,
            )
        )
        # A trip that is latched from an earlier session is over: whoever opens the rig has looked.
        self._command(MessageKind.OFF, b"")
        self._command(MessageKind.STREAM, struct.pack("<H", self._ticks // self._frames))

    def _check_agreement(self) -> None:
        """Raise CallerError where the rig file asks for what this board is not."""
        wanted, board = self._configuration, self._identity
        if abs(wanted.shunt - board.shunt_resistance_ohm) > AGREEMENT * board.shunt_resistance_ohm:
            raise CallerError(
                f"shunt is {wanted.shunt:g} ohm in the rig file and {board.shunt_resistance_ohm:g} ohm in the board's "
                "firmware: correct the one that is wrong"
            )
        if wanted.maximum_voltage > board.maximum_voltage_v * (1.0 + AGREEMENT):
            raise CallerError(
                f"maximum_voltage is {wanted.maximum_voltage:g} V in the rig file and the board puts out "
                f"{board.maximum_voltage_v:g} V at most: lower it"
            )
        ticks = wanted.sample_period / board.tick_period_s
        if round(ticks) < 1 or abs(ticks - round(ticks)) > 1e-6 * ticks:
            raise CallerError(
                f"sample_period {wanted.sample_period:g} s is not a whole number of the board's ticks of "
                f"{board.tick_period_s:g} s"
            )
        if wanted.sample_period * 1e3 >= board.expiry_ms:
            raise CallerError(
                f"sample_period {wanted.sample_period:g} s leaves the board without a command for longer than its "
                f"heater lives, {board.expiry_ms} ms: choose a shorter one"
            )

    @property
    def sample_period_s(self) -> float:
        """Time between samples."""
        return self._configuration.sample_period

    @property
    def paced(self) -> bool:
        """Samples come at the pace of the board's clock."""
        return True

    @property
    def drive_amplitude_v(self) -> float:
        """Amplitude of the slow sine for this wire."""
        return self._configuration.drive_amplitude

    @property
    def leg_length_m(self) -> float:
        """Length of one leg."""
        return self._configuration.leg_length_m

    @property
    def drive_voltage_v(self) -> float:
        """Drive voltage that is out now, as the board's last sample says."""
        return self._drive_voltage_v

    @property
    def reference_columns(self) -> tuple[str, ...]:
        """A board has no instruments."""
        return ()

    @property
    def identity(self) -> Identity:
        """What the board says it is."""
        return self._identity

    @property
    def board_estimate(self) -> float | None:
        """The board's own estimate at the last exchange, in its model's unit (SI); None before the first."""
        return None if self._last is None else self._last.estimate

    @property
    def board_resistance_ohm(self) -> float | None:
        """The board's own resistance at the last exchange; None before the first."""
        return None if self._last is None else self._last.resistance_ohm

    def __repr__(self) -> str:
        """Say which board on which port, and what is out."""
        return (
            f"SerialRig({self._identity.board} on {self._configuration.port}, "
            f"wire {self._configuration.wire}, drive {self._drive_voltage_v:.3f} V)"
        )

    def metadata(self) -> Metadata:
        """Return what a recording should say about this rig."""
        return {
            "rig": "serial",
            **self._configuration.facts(),
            "board": self._identity.board,
            "firmware_version": self._identity.firmware_version,
            "protocol_version": self._identity.protocol_version,
            "board_tick_s": self._identity.tick_period_s,
            "board_started_by": self._identity.reset_by,
            "port": self._configuration.port,
            **self.link_counts(),
        }

    def link_counts(self) -> Metadata:
        """Return what the line has cost so far: lost frames, broken frames, repeated commands."""
        return {
            "lost_frames": self._board.lost_frames,
            "broken_frames": self._board.parser.errors.total,
            "repeated_commands": self._board.repeated_commands,
        }

    @property
    def accepts_targets(self) -> bool:
        """The firmware closes the loop itself."""
        return True

    def _exchange(self, command: Command) -> RawSample:
        """Let the board put out a drive voltage, or follow a target (SI, its model's quantity), for a sample period."""
        if isinstance(command, Target):
            return self._period(lambda sequence: self._board.send_target(command.value, sequence))
        return self._period(lambda sequence: self._board.send_drive(command.voltage_v, sequence))

    def _period(self, send: Callable[[int | None], int]) -> RawSample:
        """Send a command and return the mean of the samples that stand for its sample period."""
        try:
            if not self._armed:
                self._arm()
            samples = self._samples_after(send)
        except LineLostError as error:
            self.trip(Event.DEVICE_LOST, str(error))
        except LinkStormError as error:
            self.trip(Event.LINK_CORRUPTED, str(error))
        self._last = samples[-1]
        # A sample in which the converter gave nothing is no number; of several the others speak for the period.
        samples = [one for one in samples if isfinite(one.wire_voltage_v + one.shunt_voltage_v)] or samples
        count = len(samples)
        self._drive_voltage_v = sum(sample.drive_voltage_v for sample in samples) / count
        return RawSample(
            time_s=(self._tick - self._first_tick) * self._identity.tick_period_s,
            drive_voltage_v=self._drive_voltage_v,
            wire_voltage_v=sum(sample.wire_voltage_v for sample in samples) / count,
            shunt_voltage_v=sum(sample.shunt_voltage_v for sample in samples) / count,
        )

    def _samples_after(self, send: Callable[[int | None], int]) -> list[BoardSample]:
        """Collect the samples that carry a command's number until the period is over."""
        sequence = send(None)
        repeat_s = REPEAT_SHARE * self._configuration.patience
        start_s = heard_s = asked_s = self._clock_s()
        found: list[BoardSample] = []
        while True:
            # What came behind the last period's end is read here, too: it may be why the board has tripped.
            self._unread.extend(self._board.receive(0.0 if self._unread else repeat_s))
            while self._unread:
                message = self._unread.popleft()
                heard_s = self._clock_s()
                self._raise_what_it_reports(message, sequence)
                if isinstance(message, BoardSample) and message.command_sequence == sequence:
                    found.append(message)
                    if self._is_over(message.tick):
                        return found
            now_s = self._clock_s()
            if not found and now_s - asked_s >= repeat_s:
                send(sequence)
                asked_s = now_s
            overdue_s = now_s - (heard_s if found else start_s)
            if overdue_s > self._configuration.patience + self.sample_period_s:
                self._give_up(overdue_s)

    def _is_over(self, tick: int) -> bool:
        """Tell whether a sample at a tick ends the period that is due; due ticks stand on one grid: no drift."""
        every = self._ticks // self._frames
        if self._first_tick == NO_TICK:
            self._first_tick = self._tick = tick - every
        # A board that counts in 32 bits comes round after weeks; here ticks go on.
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
        """Trip where the board has tripped, refused the command, or started anew."""
        if isinstance(message, (BoardSample, BoardEvent)) and message.state == BoardState.TRIPPED:
            self._trip_as_the_board(message.event)
        if isinstance(message, Identity):  # unasked, so it has started anew
            self._trip_restarted(message)
        if isinstance(message, BoardSample) and self._went_back(message.tick):
            self._trip_restarted(None)
        if isinstance(message, Acknowledgement) and message.sequence == sequence:
            if message.result == AcknowledgementResult.REFUSED:
                self._trip_refused()
            elif message.result != AcknowledgementResult.DONE:
                self.trip(Event.COMMAND_REFUSED, f"the board answered {message.result} to command {message.kind:#04x}")

    def _went_back(self, tick: int) -> bool:
        return self._tick != NO_TICK and (tick - self._tick) % TICKS >= TICKS // 2

    def _trip_as_the_board(self, number: int) -> None:
        known = {event.value: event for event in Event if event is not Event.NONE}
        self.trip(known.get(number, Event.DEVICE_LOST), f"seen by the board {self._identity.board}")

    def _trip_refused(self) -> None:
        """Trip for a refused command: the reason is in what the board says next, or it has started anew."""
        ends_s = self._clock_s() + self.sample_period_s
        while self._clock_s() < ends_s:
            self._unread.extend(self._board.receive(0.2 * self.sample_period_s))
            while self._unread:
                message = self._unread.popleft()
                if isinstance(message, (BoardSample, BoardEvent)) and message.state == BoardState.TRIPPED:
                    self._trip_as_the_board(message.event)
                if isinstance(message, Identity):
                    self._trip_restarted(message)
        self._trip_restarted(None)

    def _trip_restarted(self, identity: Identity | None) -> None:
        """Trip with the reason for which a board is not armed any more; without an identity it is asked for one."""
        if identity is None:
            with contextlib.suppress(RigError):
                identity = self._board.hello(self._configuration.patience)
        known = {Event.WATCHDOG.value: Event.WATCHDOG}
        event = Event.POWER_LOST if identity is None else known.get(identity.event_at_reset, Event.POWER_LOST)
        why = "it does not say why" if identity is None else f"started by {identity.reset_by}"
        self.trip(event, f"the board {self._identity.board} is not armed any more: {why}")

    def _give_up(self, overdue_s: float) -> None:
        self.trip(Event.DEVICE_LOST, f"no sample for {overdue_s:.2f} s on {self._configuration.port}")

    def _arm(self) -> None:
        """Arm the board, on the first exchange and after a pause in which its heater has expired."""
        if self._paused:
            self._refuse_other_trips([*self._unread, *self._board.receive(0.0)])
        self._unread.clear()
        self._command(MessageKind.ARM, b"")
        self._due_tick = NO_TICK
        self._armed = True

    def _refuse_other_trips(self, messages: Iterable[Message]) -> None:
        """Trip for what the board saw during a pause, except that no command came: none was sent on purpose."""
        for message in messages:
            if (
                isinstance(message, (BoardSample, BoardEvent))
                and message.state == BoardState.TRIPPED
                and message.event != Event.COMMAND_MISSING
            ):
                self._trip_as_the_board(message.event)

    def _command(self, kind: MessageKind, payload: bytes) -> None:
        """Send a command that must be acknowledged. Raises RigError where it is not or is refused."""
        patience_s = max(REPEAT_SHARE * self._configuration.patience, 0.02)
        answer = self._board.command(kind, payload, patience_s, ATTEMPTS * 2)
        if answer is None or answer.result != AcknowledgementResult.DONE:
            said = "did not answer" if answer is None else f"answered {answer.result}"
            raise RigError(f"the board on {self._configuration.port} {said} to {kind.name}: reset it and try again")

    def _put_safe(self) -> None:
        with contextlib.suppress(RigError):
            if self._armed:
                self._board.send_drive(self.sense_voltage_v)
        # Nothing is commanded from here on, so that the heater expires; the next exchange arms again.
        self._armed, self._paused = False, True
        self._drive_voltage_v = self.sense_voltage_v

    def _switch_off(self) -> None:
        if not self._let_go:
            self._off_confirmed = self._answers_off()
        self._board.close()
        self._armed, self._let_go = False, True
        self._drive_voltage_v = 0.0

    def _answers_off(self) -> bool:
        """Order 0 V and return whether the board says that it is out."""
        patience_s = REPEAT_SHARE * self._configuration.patience
        try:
            answer = self._board.command(MessageKind.OFF, b"", patience_s, ATTEMPTS)
        except RigError:
            return False
        return answer is not None and answer.result == AcknowledgementResult.DONE
