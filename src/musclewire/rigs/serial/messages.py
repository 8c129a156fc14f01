"""What the frames of the serial protocol say: payloads to named values and back.

The numbers are the protocol's (docs/reference/firmware_protocol.md), shared with firmware/src.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import NamedTuple

from musclewire.rigs.serial.frames import Frame

__all__ = [
    "Acknowledgement",
    "AcknowledgementResult",
    "BoardEvent",
    "BoardSample",
    "BoardState",
    "Identity",
    "Message",
    "MessageKind",
    "RESET_CAUSES",
    "read_message",
]


class MessageKind(IntEnum):
    """Types of frames; those of the device have the highest bit set."""

    HELLO = 0x01
    ARM = 0x02
    DRIVE = 0x03
    TARGET = 0x04
    OFF = 0x05
    STREAM = 0x06
    KEEP = 0x07
    IDENTITY = 0x81
    SAMPLE = 0x82
    EVENT = 0x83
    ACKNOWLEDGEMENT = 0x84


class BoardState(IntEnum):
    """Protection states as the board numbers them."""

    OFF = 0
    RUN = 1
    HOLD = 2
    SENSE = 3
    TRIPPED = 4


class AcknowledgementResult(IntEnum):
    """What became of a command."""

    DONE = 0
    REFUSED = 1
    UNKNOWN = 2
    BAD_PAYLOAD = 3


RESET_CAUSES = ("power-on", "external", "watchdog", "brown-out")
IDENTITY_LAYOUT = struct.Struct("<BBBBIIfffHIB16s12s")
SAMPLE_LAYOUT = struct.Struct("<IBBHffffff")
EVENT_LAYOUT = struct.Struct("<IBBf")
ACKNOWLEDGEMENT_LAYOUT = struct.Struct("<HBB")


class Identity(NamedTuple):
    """What a board is and what it was built with."""

    protocol_version: int
    firmware_major: int
    firmware_minor: int
    reset_cause: int
    tick_period_us: int
    control_period_us: int
    sense_voltage_v: float
    maximum_voltage_v: float
    shunt_resistance_ohm: float
    expiry_ms: int
    model_checksum: int
    event_at_reset: int
    board: str
    quantity: str

    @property
    def tick_period_s(self) -> float:
        """Time between two readings of the board's converter."""
        return self.tick_period_us / 1e6

    @property
    def firmware_version(self) -> str:
        """The firmware's version as text."""
        return f"{self.firmware_major}.{self.firmware_minor}"

    @property
    def reset_by(self) -> str:
        """Why the board started, in words."""
        return RESET_CAUSES[self.reset_cause] if self.reset_cause < len(RESET_CAUSES) else f"cause {self.reset_cause}"


class BoardSample(NamedTuple):
    """Means over the board's ticks since the sample before, and what the board does."""

    tick: int
    state: int
    event: int
    command_sequence: int
    drive_voltage_v: float
    wire_voltage_v: float
    shunt_voltage_v: float
    resistance_ohm: float
    estimate: float
    target: float


class BoardEvent(NamedTuple):
    """A change of the board's protection state and the value that caused it."""

    tick: int
    state: int
    event: int
    value: float


class Acknowledgement(NamedTuple):
    """The board's answer to a command."""

    sequence: int
    kind: int
    result: int


Message = Identity | BoardSample | BoardEvent | Acknowledgement


def text_of(field: bytes) -> str:
    """Return a text field that ends at its first zero; what is not ASCII is shown as such."""
    return field.split(b"\0")[0].decode("ascii", "backslashreplace")


def read_message(frame: Frame) -> Message | None:
    """Return what a device's frame says, None for a type that is not the device's or a payload of another length."""
    if frame.kind == MessageKind.IDENTITY and len(frame.payload) == IDENTITY_LAYOUT.size:
        *numbers, board, quantity = IDENTITY_LAYOUT.unpack(frame.payload)
        return Identity._make((*numbers, text_of(board), text_of(quantity)))
    if frame.kind == MessageKind.SAMPLE and len(frame.payload) == SAMPLE_LAYOUT.size:
        return BoardSample(*SAMPLE_LAYOUT.unpack(frame.payload))
    if frame.kind == MessageKind.EVENT and len(frame.payload) == EVENT_LAYOUT.size:
        return BoardEvent(*EVENT_LAYOUT.unpack(frame.payload))
    if frame.kind == MessageKind.ACKNOWLEDGEMENT and len(frame.payload) == ACKNOWLEDGEMENT_LAYOUT.size:
        return Acknowledgement(*ACKNOWLEDGEMENT_LAYOUT.unpack(frame.payload))
    return None
