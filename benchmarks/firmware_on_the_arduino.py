"""How many cycles of a tick the firmware keeps the Arduino's processor awake, and how much memory it takes.

    PYTHONPATH=. python benchmarks/firmware_on_the_arduino.py [--quick]

simavr counts the cycles of an ATmega328P at 16 MHz; a tick is 10 ms, 160,000 cycles. Off, driven by a host, and closing
the loop by itself, with a SAMPLE every five ticks and a command every 50 ms. Interrupts count, waiting does not.
Exit 1 where a tick is ever full.
"""

from __future__ import annotations

import re
import struct
import sys
import tempfile
import time
from pathlib import Path

from emulation.board import EmulatedBoard, firmware_for
from firmware.build import size_of

from musclewire.extras.board import Board, MessageKind, open_line

BAUD = 250_000
EVERY_S = 0.05
PATIENCE_S, ATTEMPTS = 0.5, 3
WORK = {
    "off": lambda host: host.command(MessageKind.KEEP, b"", PATIENCE_S, ATTEMPTS),
    "driven by a host": lambda host: host.command(MessageKind.DRIVE, struct.pack("<f", 1.5), PATIENCE_S, ATTEMPTS),
    "closing the loop": lambda host: host.command(MessageKind.TARGET, struct.pack("<f", 0.012), PATIENCE_S, ATTEMPTS),
}


def counted(emulated: EmulatedBoard) -> list[tuple[int, int, int]]:
    """Return what simavr has said so far: mean and most cycles awake of each hundred ticks, and all there are."""
    found = re.findall(r"mean (\d+), most (\d+) of (\d+)", emulated.messages())
    return [(int(mean), int(most), int(whole)) for mean, most, whole in found]


def measured(emulated: EmulatedBoard, host: Board, what: str, duration_s: float) -> tuple[int, int, int]:
    """Work for some time; return mean, most and whole of a tick's cycles, without the first hundred ticks."""
    before = len(counted(emulated))
    host.command(MessageKind.ARM if what != "off" else MessageKind.OFF, b"", PATIENCE_S, ATTEMPTS)
    end_s = time.monotonic() + duration_s
    while time.monotonic() < end_s:
        answer = WORK[what](host)
        if what != "off" and (answer is None or answer.result != 0):
            host.command(MessageKind.ARM, b"", PATIENCE_S, ATTEMPTS)  # this machine was too busy to be in time
        host.receive(EVERY_S / 2.0)
    rows = counted(emulated)[before + 1 :]
    return sum(row[0] for row in rows) // len(rows), max(row[1] for row in rows), rows[0][2]


def main() -> int:
    """Print memory and cycles."""
    duration_s = 4.0 if "--quick" in sys.argv[1:] else 15.0
    with tempfile.TemporaryDirectory() as folder:
        elf = firmware_for("arduino-uno", Path(folder))
        print(size_of("arduino-uno", elf), end="")
        with EmulatedBoard(board="arduino-uno", elf=elf) as emulated:
            host = Board(open_line(emulated.port_url, BAUD))
            host.command(MessageKind.STREAM, struct.pack("<H", 5), PATIENCE_S, ATTEMPTS)
            rows = {what: measured(emulated, host, what, duration_s) for what in WORK}
    for what, (mean, most, whole) in rows.items():
        print(f"{what:17} mean {mean:6} most {most:6} of {whole} cycles: at most {most / whole:.0%} of a tick")
    return 0 if all(most < whole for _, most, whole in rows.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
