"""A line with the protocol's other end in memory, on a clock that only moves when somebody waits.

What the real firmware does is tested with the real firmware (tests/contract, tests/faults); this is for what a healthy
board never does: losing chosen frames, other versions, answers out of order.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from math import nan
from typing import Any

from musclewire.controllers import Event
from musclewire.extras.board import (
    Board,
    FrameParser,
    MessageKind,
    SerialConfiguration,
    SerialDevice,
    SerialFrame,
    encode_frame,
)
from musclewire.extras.board._serial.line import LineLostError
from musclewire.extras.board._serial.message_types import PROTOCOL_VERSION
from musclewire.rigs import GuardedRig

WIRE_OHM, SHUNT_OHM = 15.0, 1.0
TICK_S = 1e-3


@dataclass
class BoardInMemory:
    """The board and the line to it; ``clock_s`` is the host's clock."""

    now_s: float = 0.0
    tick: int = 1000
    state: int = 0
    event: int = 0
    drive_v: float = 0.0
    target: float = 0.0
    command_sequence: int = 0
    stream_every: int = 0
    sequence: int = 0
    period_ticks: int = 50
    event_at_reset: int = 0
    maximum_v: float = 4.0
    wire: str = "paper-100um"
    expiry_ms: int = 250
    unreadable: int = 0  # so many of the next samples have no reading of the converter
    answers: dict[int, int] = field(default_factory=dict)  # what it answers to kinds of commands, whatever they do
    drop: set[int] = field(default_factory=set)  # kinds of frames that get lost, once each
    deaf: bool = False
    unplugged: bool = False
    commands: list[tuple[int, bytes]] = field(default_factory=list)
    parser: FrameParser = field(default_factory=FrameParser)
    waiting: bytearray = field(default_factory=bytearray)
    name: str = "memory"

    def clock_s(self) -> float:
        return self.now_s

    def write(self, data: bytes) -> None:
        if self.unplugged:
            raise LineLostError("the line to the board, memory, is gone: unplugged")
        for frame in self.parser.feed(data):
            if not self.deaf:
                self.obey(frame)

    def read(self, timeout_s: float) -> bytes:
        if self.unplugged:
            raise LineLostError("the line to the board, memory, is gone: unplugged")
        if not self.waiting:
            self.now_s += timeout_s
        data = bytes(self.waiting)
        self.waiting.clear()
        return data

    def close(self) -> None:
        self.unplugged = True

    def tell(self, kind: int, payload: bytes) -> None:
        self.sequence += 1
        if kind in self.drop:
            self.drop.discard(kind)
            return
        self.waiting += encode_frame(SerialFrame(kind, self.sequence, payload))

    def identify(self) -> None:
        texts = ((b"memory", 16), (b"strain", 12), (self.wire.encode("ascii"), 24))
        text = b"".join(said.ljust(size, b"\0") for said, size in texts)
        numbers = (
            PROTOCOL_VERSION,
            1,
            0,
            0,
            1000,
            50000,
            0.3,
            self.maximum_v,
            SHUNT_OHM,
            self.expiry_ms,
            7,
            self.event_at_reset,
        )
        self.tell(MessageKind.IDENTITY, struct.pack("<BBBBIIfffHIB", *numbers) + text)

    def trip(self, event: Event) -> None:
        """Tell of a trip, as a board does when its protection has seen something."""
        self.tell(MessageKind.EVENT, struct.pack("<IBBf", self.tick, 4, event.value, 0.0))

    def obey(self, frame: SerialFrame) -> None:
        self.commands.append((frame.kind, frame.payload))
        result = 0
        moves = frame.kind in (MessageKind.DRIVE, MessageKind.TARGET)
        if moves and self.state in (0, 4):
            result = 1
        elif moves:
            (value,) = struct.unpack("<f", frame.payload)
            self.state, self.command_sequence = 1, frame.sequence
            self.drive_v, self.target = (value, 0.0) if frame.kind == MessageKind.DRIVE else (1.0, value)
        elif frame.kind == MessageKind.ARM:
            self.state, self.event, self.drive_v = 3, 0, 0.3
        elif frame.kind == MessageKind.OFF:
            self.state, self.drive_v = 0, 0.0
        elif frame.kind == MessageKind.STREAM:
            (self.stream_every,) = struct.unpack("<H", frame.payload)
        result = self.answers.get(frame.kind, result)
        if frame.kind == MessageKind.CORRECT and result == 0:
            self.tell(MessageKind.CORRECTION, frame.payload)
        self.tell(MessageKind.ACKNOWLEDGEMENT, struct.pack("<HBB", frame.sequence, frame.kind, result))
        if frame.kind == MessageKind.HELLO:
            self.identify()
        if moves and result == 0:
            self.run(self.period_ticks)

    def run(self, ticks: int) -> None:
        for _ in range(ticks // self.stream_every):
            self.now_s += self.stream_every * TICK_S
            self.tick += self.stream_every
            current_a = self.drive_v / (WIRE_OHM + SHUNT_OHM)
            # A reading is never twice the same.
            voltages = (current_a * WIRE_OHM + 1e-6 * (self.tick % 97), current_a * SHUNT_OHM + 1e-7 * (self.tick % 89))
            if self.unreadable:
                self.unreadable, voltages = self.unreadable - 1, (nan, nan)
            header = struct.pack("<IBBH", self.tick % 2**32, self.state, self.event, self.command_sequence)
            rest = struct.pack("<ffffff", self.drive_v, *voltages, WIRE_OHM, 0.01, self.target)
            self.tell(MessageKind.SAMPLE, header + rest)


def configuration(**changed: object) -> SerialConfiguration:
    given = {
        "kind": "serial",
        "port": "memory",
        "wire": "paper-100um",
        "wire_length": 0.14,
        "shunt": SHUNT_OHM,
        "sense_voltage": 0.3,
        "maximum_voltage": 4.0,
        "drive_amplitude": 3.0,
        "wire_range": 5.0,
        "shunt_range": 1.0,
    }
    return SerialConfiguration.model_validate({**given, **changed})


def driven(drive_v: float = 1.0, **board_as: Any) -> tuple[BoardInMemory, GuardedRig]:
    """Return a board and the rig on it once it has been driven for a sample."""
    board = BoardInMemory(**board_as)
    rig = rig_on(board)
    rig.exchange(drive_v)
    return board, rig


def rig_on(board: BoardInMemory, **changed: object) -> GuardedRig:
    return GuardedRig(SerialDevice(configuration(**changed), Board(board, board.clock_s), board.clock_s))
