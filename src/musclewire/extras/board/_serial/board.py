"""The connection to a board: acknowledged commands, received messages, and counts of lost frames."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from threading import Lock

from musclewire.errors import RigError
from musclewire.extras.board._serial.frames import FrameParser, SerialFrame, encode_frame
from musclewire.extras.board._serial.line import ByteLine
from musclewire.extras.board._serial.message_types import (
    PROTOCOL_VERSION,
    Acknowledgement,
    BoardCorrection,
    MessageKind,
)
from musclewire.extras.board._serial.messages import BoardIdentity, Message, payload_of, read_message

# The protocol's checksum storm:
STORM_FRAMES = 16  # broken frames
STORM_S = 0.2  # [s] in which they arrive
# A board that has just been plugged in runs its boot loader first.
BOOT_S = 3.0
HELLO_EVERY_S = 0.2
SEQUENCES = 1 << 16


class LinkStormError(RigError):
    """The line carries mostly broken frames."""


class BoardOffMeanwhileError(RigError):
    """Another thread has requested to switch off: no other command goes out any more."""


class Board:
    """Commands out, messages in. It counts lost frames and keeps no state of the run.

    One thread talks; another one may order 0 V meanwhile, and that is then the last command.

    ``lost_frames`` are gaps in the board's sequence numbers; ``repeated_commands`` commands that were sent again
    because no answer came; ``correction`` the last that the board has confirmed.
    """

    def __init__(self, line: ByteLine, clock_s: Callable[[], float] = time.monotonic) -> None:
        """Use an open line; ``clock_s`` is the host's clock [s]."""
        self._line, self._clock_s = line, clock_s
        self.parser = FrameParser()
        self.lost_frames = 0
        self.repeated_commands = 0
        self.correction: BoardCorrection | None = None
        self._next_sequence = 0
        self._sending, self._only_off = Lock(), False
        self._seen_sequence: int | None = None
        self._broken_at_s: deque[float] = deque(maxlen=STORM_FRAMES)

    def new_sequence(self) -> int:
        """Return the number of the next command."""
        self._next_sequence = (self._next_sequence + 1) % SEQUENCES
        return self._next_sequence

    def send(self, kind: MessageKind, payload: bytes = b"", sequence: int | None = None) -> int:
        """Send a command and return its sequence number; with a ``sequence`` it is the same command again.

        Raises OffMeanwhileError for another command than OFF once ``order_off`` was called.
        """
        with self._sending:
            if self._only_off and kind is not MessageKind.OFF:
                raise BoardOffMeanwhileError("the line is to be closed: open the rig again")
            if sequence is not None:
                self.repeated_commands += 1
            number = self.new_sequence() if sequence is None else sequence
            # The zero before it ends the bytes of any disturbance on the line, so that they spoil no command.
            self._line.write(b"\0" + encode_frame(SerialFrame(kind, number, payload)))
            return number

    @property
    def only_off(self) -> bool:
        """Whether 0 V was ordered, so that no other command goes out."""
        return self._only_off

    def order_off(self) -> None:
        """Order 0 V from any thread and let no other command out after it. Raises LineLostError if the line is gone."""
        self._only_off = True  # a command that is being sent goes out before the order, any later one is refused
        self.send(MessageKind.OFF)

    def send_drive(self, drive_voltage_v: float, sequence: int | None = None) -> int:
        """Command a drive voltage [V]; the board's loop is then open."""
        return self.send(MessageKind.DRIVE, payload_of(MessageKind.DRIVE, drive_voltage_v), sequence)

    def send_target(self, target: float, sequence: int | None = None) -> int:
        """Command a target in the unit of the board's model, SI; the board closes the loop."""
        return self.send(MessageKind.TARGET, payload_of(MessageKind.TARGET, target), sequence)

    def receive(self, timeout_s: float) -> list[Message]:
        """Return the messages that have come, waiting up to ``timeout_s`` for the first byte.

        Raises LineLostError if the line is gone and LinkStormError if most frames are broken.
        """
        broken = self.parser.errors.total
        frames = self.parser.feed(self._line.read(timeout_s))
        self._watch_for_storm(self.parser.errors.total - broken)
        messages = []
        for frame in frames:
            self._count(frame.sequence)
            message = read_message(frame)
            if message is not None:
                messages.append(message)
        return messages

    def _count(self, sequence: int) -> None:
        """Count the frames that are missing before this one; a number that went back shows that the board restarted."""
        if self._seen_sequence is not None:
            missing = (sequence - self._seen_sequence - 1) % SEQUENCES
            if missing < SEQUENCES // 2:
                self.lost_frames += missing
        self._seen_sequence = sequence

    def _watch_for_storm(self, newly_broken: int) -> None:
        now_s = self._clock_s()
        self._broken_at_s.extend([now_s] * min(newly_broken, STORM_FRAMES))
        if newly_broken and len(self._broken_at_s) == STORM_FRAMES and now_s - self._broken_at_s[0] <= STORM_S:
            raise LinkStormError(
                f"{STORM_FRAMES} broken frames within {STORM_S:g} s on {self._line.name}: check baud rate, cable and "
                "ground"
            )

    def command(self, kind: MessageKind, payload: bytes, patience_s: float, attempts: int) -> Acknowledgement | None:
        """Send a command until it is acknowledged; None if it never was. Other messages are dropped."""
        sequence = None
        for _ in range(attempts):
            sequence = self.send(kind, payload, sequence)
            ends_s = self._clock_s() + patience_s
            while (left_s := ends_s - self._clock_s()) > 0.0:
                for message in self.receive(left_s):
                    if isinstance(message, BoardCorrection):
                        self.correction = message
                    if isinstance(message, Acknowledgement) and (message.sequence, message.kind) == (sequence, kind):
                        return message
        return None

    def hello(self, max_wait_s: float = BOOT_S) -> BoardIdentity:
        """Return the board's identity. Raises RigError if no board answers or it has another protocol version."""
        ends_s = self._clock_s() + max_wait_s
        while self._clock_s() < ends_s:
            self.send(MessageKind.HELLO)
            again_s = self._clock_s() + HELLO_EVERY_S
            while (left_s := again_s - self._clock_s()) > 0.0:
                for message in self.receive(left_s):
                    if isinstance(message, BoardIdentity):
                        return self._checked(message)
                if self.parser.other_version is not None:
                    self._wrong_version(self.parser.other_version)
        raise RigError(
            f"no answer from a musclewire board on {self._line.name} within {max_wait_s:g} s: check port, baud rate "
            "and that the board runs the firmware"
        )

    def _checked(self, identity: BoardIdentity) -> BoardIdentity:
        if identity.protocol_version != PROTOCOL_VERSION:
            self._wrong_version(identity.protocol_version)
        return identity

    def _wrong_version(self, version: int) -> None:
        older = "update the firmware" if version < PROTOCOL_VERSION else "update musclewire"
        raise RigError(
            f"the board on {self._line.name} speaks version {version} of the protocol and this musclewire speaks "
            f"{PROTOCOL_VERSION}: {older}"
        )

    def close(self) -> None:
        """Close the line."""
        self._line.close()
