"""A firmware built once for all tests, and the simplest host there is."""

from __future__ import annotations

import socket
import struct
import time
from pathlib import Path
from typing import NamedTuple

import pytest
from emulation.board import EmulatedBoard, firmware_for
from tests.tools import require_tool

from musclewire.extras.board import FrameParser, SerialFrame, encode_frame

HELLO, ARM, DRIVE, TARGET, OFF, STREAM, KEEP, INJECT = 1, 2, 3, 4, 5, 6, 7, 0x7F
IDENTITY, SAMPLE, EVENT, ACK = 0x81, 0x82, 0x83, 0x84

# A wait ends with what is waited for; only a board that is silent on a busy machine, too, lets it end by this time.
PATIENCE_S = 60.0
# Commands that say the same twice, and how long after the first the second is sent.
MAY_BE_REPEATED, AGAIN_S = {HELLO, STREAM}, 2.0


class Sample(NamedTuple):
    """A SAMPLE frame's payload."""

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


class Host:
    """Sends one command after the other and keeps all that comes."""

    def __init__(self, board: EmulatedBoard) -> None:
        self._socket = socket.create_connection(("127.0.0.1", board.port))
        self._parser = FrameParser()
        self._sequence = 0
        self.frames: list[SerialFrame] = []

    def listen(self, duration_s: float) -> None:
        end_s = time.monotonic() + duration_s
        while (left_s := end_s - time.monotonic()) > 0.0:
            self._socket.settimeout(left_s)
            try:
                self.frames += self._parser.feed(self._socket.recv(4096))
            except TimeoutError:
                return

    def command(self, kind: int, payload: bytes = b"", patience_s: float = PATIENCE_S) -> int:
        """Send a command and return the result of its acknowledgement.

        A question or a setting is sent again when nothing comes back, as hosts do: an emulator that waits for the
        processor loses bytes of its line.
        """
        end_s = time.monotonic() + patience_s
        while time.monotonic() < end_s:
            self._sequence += 1
            self._socket.sendall(encode_frame(SerialFrame(kind, self._sequence, payload)))
            again_s = time.monotonic() + AGAIN_S if kind in MAY_BE_REPEATED else end_s
            result = self._acknowledged(kind, min(again_s, end_s))
            if result is not None:
                return result
        raise AssertionError(f"command {kind} was not acknowledged")

    def _acknowledged(self, kind: int, end_s: float) -> int | None:
        """Return the result of the last command, None where it is not acknowledged by a time."""
        wanted = struct.pack("<HB", self._sequence, kind)
        while time.monotonic() < end_s:
            for frame in self.frames:
                if frame.kind == ACK and frame.payload[:3] == wanted:
                    return frame.payload[3]
            self.listen(0.005)
        return None

    def drive(self, voltage_v: float) -> int:
        return self.command(DRIVE, struct.pack("<f", voltage_v))

    def raw(self, data: bytes) -> None:
        self._socket.sendall(data)

    def of_kind(self, kind: int) -> list[bytes]:
        return [frame.payload for frame in self.frames if frame.kind == kind]

    def samples(self) -> list[Sample]:
        return [Sample(*struct.unpack("<IBBHffffff", payload)) for payload in self.of_kind(SAMPLE)]

    def wait_for(self, kind: int, count: int = 1, patience_s: float = PATIENCE_S) -> list[bytes]:
        end_s = time.monotonic() + patience_s
        while len(self.of_kind(kind)) < count:
            assert time.monotonic() < end_s, f"only {len(self.of_kind(kind))} frames of kind {kind:#x} came"
            self.listen(0.01)
        return self.of_kind(kind)

    def close(self) -> None:
        self._socket.close()


@pytest.fixture(scope="session")
def elf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Cortex-M4F firmware with the command that makes it fail."""
    require_tool("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi")
    require_tool("qemu-system-arm", "qemu-system-arm")
    return firmware_for("mps2-an386", tmp_path_factory.mktemp("elf"), ["--fault-injection"])
