"""Frames survive any line: what goes in comes out, and what is damaged is dropped and counted."""

from __future__ import annotations

import struct
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from musclewire.errors import CallerError
from musclewire.extras.board import (
    MAXIMUM_BODY_BYTES,
    FrameParser,
    MessageKind,
    SerialFrame,
    encode_frame,
    read_message,
)
from musclewire.extras.board._serial.frames import stuff, unstuff
from musclewire.extras.board._serial.messages import BoardIdentity

FRAMES = st.builds(SerialFrame, st.integers(0, 255), st.integers(0, 65535), st.binary(max_size=MAXIMUM_BODY_BYTES - 8))


@pytest.mark.parametrize(
    ("body", "stuffed"),
    [
        # Zeros alone, data between zeros, zeros at the end, a run of 253 and one of 255.
        (b"\0", b"\x01\x01"),
        (b"\0\0", b"\x01\x01\x01"),
        (b"\x11\x22\0\x33", b"\x03\x11\x22\x02\x33"),
        (b"\x11\x22\x33\x44", b"\x05\x11\x22\x33\x44"),
        (b"\x11\0\0\0", b"\x02\x11\x01\x01\x01"),
        (bytes(range(1, 254)), b"\xfe" + bytes(range(1, 254))),
        (bytes(range(1, 256)), b"\xff" + bytes(range(1, 255)) + b"\x02\xff"),
    ],
)
def test_stuffing_takes_the_zeros_out_as_the_scheme_says(body: bytes, stuffed: bytes) -> None:
    assert stuff(body) == stuffed
    assert unstuff(stuffed) == body


def test_a_frame_has_the_bytes_that_the_protocol_says() -> None:
    body = bytes([2, 0x03, 0x34, 0x12]) + struct.pack("<f", 1.5)
    body += struct.pack("<I", zlib.crc32(body))
    assert encode_frame(SerialFrame(0x03, 0x1234, struct.pack("<f", 1.5))) == stuff(body) + b"\0"


@given(st.lists(FRAMES, max_size=8), st.integers(1, 40))
def test_frames_come_out_as_they_went_in_however_the_line_cuts_them(frames: list[SerialFrame], piece: int) -> None:
    parser = FrameParser()
    line = b"".join(encode_frame(frame) for frame in frames)
    found = [frame for at in range(0, len(line), piece) for frame in parser.feed(line[at : at + piece])]
    assert found == frames
    assert parser.accepted == len(frames)
    assert parser.errors.total == 0


@given(FRAMES, FRAMES, st.data())
def test_a_damaged_frame_is_dropped_and_the_next_one_found(
    first: SerialFrame, second: SerialFrame, data: st.DataObject
) -> None:
    """One byte changed to any other: CRC-32 sees every error burst up to 32 bits, and a new zero only splits."""
    line = bytearray(encode_frame(first))
    at = data.draw(st.integers(0, len(line) - 2))
    line[at] = data.draw(st.integers(0, 255).filter(lambda value: value != line[at]))
    parser = FrameParser()
    assert parser.feed(bytes(line) + encode_frame(second)) == [second]
    assert parser.errors.total >= 1


def test_a_frame_cut_in_the_middle_costs_itself_only_once_a_zero_follows() -> None:
    frame = SerialFrame(0x82, 7, bytes(32))
    parser = FrameParser()
    assert parser.feed(encode_frame(frame)[:20]) == []
    assert parser.feed(b"\0" + encode_frame(frame)) == [frame]


def test_zeros_in_a_row_are_no_error() -> None:
    parser = FrameParser()
    assert parser.feed(bytes(50)) == []
    assert parser.errors.total == 0


def test_an_endless_frame_takes_no_memory_and_counts_once_per_frames_length() -> None:
    parser = FrameParser()
    for _ in range(1000):
        assert parser.feed(b"\x55" * 100) == []
    assert len(parser._under_way) <= MAXIMUM_BODY_BYTES + 1
    parser.feed(b"\0")
    assert parser.errors.too_long == parser.errors.total == 100_000 // (MAXIMUM_BODY_BYTES + 2)


def test_another_version_is_dropped_and_remembered() -> None:
    body = bytes([3, 0x81, 0, 0])
    body += struct.pack("<I", zlib.crc32(body))
    parser = FrameParser()
    assert parser.feed(stuff(body) + b"\0") == []
    assert parser.errors.version == 1
    assert parser.other_version == 3


def test_a_payload_that_no_frame_holds_is_refused() -> None:
    with pytest.raises(CallerError, match="send less at once"):
        encode_frame(SerialFrame(1, 0, bytes(MAXIMUM_BODY_BYTES - 7)))


def test_an_identity_says_board_quantity_and_wire_as_text() -> None:
    payload = struct.pack(
        "<BBBBIIfffHIB16s12s24s",
        *(2, 0, 3, 2, 1000, 50000, 0.25, 4.0, 1.0, 250, 99, 15),
        *(b"mps2-an386", b"strain", b"flexinol-0.15-lt"),
    )
    identity = read_message(SerialFrame(MessageKind.IDENTITY, 0, payload))
    assert isinstance(identity, BoardIdentity)
    assert (identity.board, identity.quantity, identity.reset_by) == ("mps2-an386", "strain", "watchdog")
    assert identity.wire == "flexinol-0.15-lt"
    assert identity.tick_period_s == 0.001
    assert identity.firmware_version == "0.3"


@given(FRAMES)
def test_any_frame_is_a_message_or_none(frame: SerialFrame) -> None:
    read_message(frame)
