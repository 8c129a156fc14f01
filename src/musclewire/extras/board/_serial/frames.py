"""Frames of the serial protocol, version 1: bytes in, frames out, and back. No line, no clock.

A frame on the line is COBS(body) followed by a zero byte; a body is version, type, sequence, payload and the CRC-32 of
all before it, little endian (docs/reference/firmware_protocol.md). Consistent overhead byte stuffing takes the zeros
out of a body, so that a zero always ends a frame and a parser finds its way again after any damage (Cheshire and
Baker, IEEE/ACM Transactions on Networking 7(2), 1999, doi 10.1109/90.769765).
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from typing import NamedTuple

from musclewire.errors import CallerError
from musclewire.extras.board._serial.message_types import MAXIMUM_BODY_BYTES, PROTOCOL_VERSION

HEADER = struct.Struct("<BBH")
CHECKSUM = struct.Struct("<I")
MIN_BODY_BYTES = HEADER.size + CHECKSUM.size
# One code byte for each started 254 bytes: a body of 96 bytes grows by one.
MAX_ON_THE_LINE_BYTES = MAXIMUM_BODY_BYTES + 1
MAX_RUN = 0xFF


class SerialFrame(NamedTuple):
    """One frame: its type, its sequence number (0 to 65535) and its payload."""

    kind: int
    sequence: int
    payload: bytes


@dataclass
class LinkErrors:
    """Counts of the frames that were dropped on a line, by reason."""

    too_long: int = 0
    stuffing: int = 0
    too_short: int = 0
    checksum: int = 0
    version: int = 0

    @property
    def total(self) -> int:
        """Frames dropped for any reason."""
        return self.too_long + self.stuffing + self.too_short + self.checksum + self.version


def stuff(body: bytes) -> bytes:
    """Return a body with its zeros taken out, without the zero that ends a frame."""
    stuffed = bytearray()
    for part in body.split(b"\0"):
        start = 0
        while len(part) - start >= MAX_RUN - 1:
            stuffed += bytes([MAX_RUN]) + part[start : start + MAX_RUN - 1]
            start += MAX_RUN - 1
        stuffed += bytes([len(part) - start + 1]) + part[start:]
    return bytes(stuffed)


def unstuff(stuffed: bytes) -> bytes | None:
    """Return the body that was stuffed, None if the bytes are not a stuffed body."""
    body = bytearray()
    at = 0
    while at < len(stuffed):
        code = stuffed[at]
        end = at + code
        if code == 0 or end > len(stuffed):
            return None
        body += stuffed[at + 1 : end]
        if code != MAX_RUN and end < len(stuffed):
            body.append(0)
        at = end
    return bytes(body)


def encode_frame(frame: SerialFrame) -> bytes:
    """Return a frame as it goes over the line. Raises CallerError for a payload that no frame can hold."""
    body = HEADER.pack(PROTOCOL_VERSION, frame.kind, frame.sequence & 0xFFFF) + frame.payload
    body += CHECKSUM.pack(zlib.crc32(body))
    if len(body) > MAXIMUM_BODY_BYTES:
        raise CallerError(f"a frame holds {MAXIMUM_BODY_BYTES} bytes and this one has {len(body)}: send less at once")
    return stuff(body) + b"\0"


@dataclass
class FrameParser:
    """Bytes in, frames out; damaged ones are dropped and counted, and an incomplete one is kept for the next call."""

    accepted: int = 0
    errors: LinkErrors = field(default_factory=LinkErrors)
    other_version: int | None = None
    _under_way: bytearray = field(default_factory=bytearray)
    _overflowed: bool = False

    def feed(self, data: bytes) -> list[SerialFrame]:
        """Take bytes from the line and return the frames that they complete."""
        pieces = data.split(b"\0")
        frames = []
        for piece in pieces[:-1]:
            self._keep(piece)
            frame = self._finish()
            if frame is not None:
                frames.append(frame)
        self._keep(pieces[-1])
        return frames

    def _keep(self, piece: bytes) -> None:
        """Keep bytes of an incomplete frame; noise without any zero counts once per frame's length, as on the board."""
        at = 0
        while len(piece) - at > (room := MAX_ON_THE_LINE_BYTES - len(self._under_way)):
            self.errors.too_long += 1
            self._overflowed = True
            self._under_way.clear()
            at += room + 1
        self._under_way += piece[at:]

    def _finish(self) -> SerialFrame | None:
        """Return the frame that a zero byte has just ended, None for one that is dropped."""
        stuffed, overflowed = bytes(self._under_way), self._overflowed
        self._under_way.clear()
        self._overflowed = False
        # A frame that is too long was counted when it became so; a sender flushes the line with zeros in a row.
        if overflowed or not stuffed:
            return None
        body = unstuff(stuffed)
        if body is None:
            self.errors.stuffing += 1
            return None
        return self._checked(body)

    def _checked(self, body: bytes) -> SerialFrame | None:
        if len(body) < MIN_BODY_BYTES:
            self.errors.too_short += 1
            return None
        (checksum,) = CHECKSUM.unpack_from(body, len(body) - CHECKSUM.size)
        if zlib.crc32(body[: -CHECKSUM.size]) != checksum:
            self.errors.checksum += 1
            return None
        version, kind, sequence = HEADER.unpack_from(body)
        if version != PROTOCOL_VERSION:
            self.errors.version += 1
            self.other_version = version
            return None
        self.accepted += 1
        return SerialFrame(kind, sequence, body[HEADER.size : -CHECKSUM.size])
