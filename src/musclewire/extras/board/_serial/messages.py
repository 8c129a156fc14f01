"""Messages of the serial protocol: payloads to named values and back.

Numbers, fields and layouts are those of ``message_types.py``, which is written from data/protocol.toml, as the
firmware's header is (docs/reference/firmware_protocol.md).
"""

from __future__ import annotations

from typing import Any

from musclewire.extras.board._serial.frames import SerialFrame
from musclewire.extras.board._serial.message_types import (
    LAYOUTS,
    Acknowledgement,
    BoardCorrection,
    BoardEvent,
    BoardSample,
    IdentityFields,
    MessageKind,
    ResetCause,
)


class BoardIdentity(IdentityFields):
    """Identity of a board, with the model and the firmware that it was built with."""

    __slots__ = ()

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
        """Cause of the board's start as text."""
        known = {cause.value: cause.name.lower().replace("_", "-") for cause in ResetCause}
        return known.get(self.reset_cause, f"cause {self.reset_cause}")


Message = BoardIdentity | BoardSample | BoardEvent | Acknowledgement | BoardCorrection
# The type that each of the board's messages is read as.
READ_AS: dict[int, type[Message]] = {
    MessageKind.IDENTITY: BoardIdentity,
    MessageKind.SAMPLE: BoardSample,
    MessageKind.EVENT: BoardEvent,
    MessageKind.ACKNOWLEDGEMENT: Acknowledgement,
    MessageKind.CORRECTION: BoardCorrection,
}


def payload_of(kind: MessageKind, *values: float) -> bytes:
    """Return the payload of a command with the values of its fields."""
    return LAYOUTS[kind].pack(*values)


def text_of(field: bytes) -> str:
    """Return a text field that ends at its first zero; bytes that are not ASCII are escaped."""
    return field.split(b"\0")[0].decode("ascii", "backslashreplace")


def read_message(frame: SerialFrame) -> Message | None:
    """Return a board's message, None for a type that is not the board's or a payload of another length."""
    made = READ_AS.get(frame.kind)
    if made is None:
        return None
    layout = LAYOUTS[MessageKind(frame.kind)]
    if len(frame.payload) != layout.size:
        return None
    fields: list[Any] = [text_of(one) if isinstance(one, bytes) else one for one in layout.unpack(frame.payload)]
    return made._make(fields)
