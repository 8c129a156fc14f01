"""The bench of an emulated board, a process of its own: the wire stays on it whatever becomes of the host.

It starts the emulator, stands on the other side of the board's converter and output stage, passes the host's line on,
and writes down what truly happened. Orders come as JSON lines on standard input; when that ends, so does the bench.
The order "end" ends the board alone: the settings of another one may follow, whose wire is cold and knows nothing of
the first. `emulation.board.EmulatedBoard` starts and orders it.

Two paces. "clock": one tick per tick period by the clock, as on a real bench. "lockstep": time stands still until the
board has acknowledged a DRIVE or TARGET, then one sample period passes as fast as it goes; the same again for the same
seed. When the host lets go of its line, half a second passes, in which the board must make itself safe.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import socket
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from emulation.machines import start_machine
from emulation.plant_line import Direction, LineFaults
from emulation.plant_wire import BenchWire, Truth
from musclewire.errors import MusclewireError
from musclewire.extras.board import Acknowledgement, AcknowledgementResult, FrameParser, MessageKind, read_message

__all__ = ["COLUMNS", "Plant"]

# A row of the log; all are numbers of 8 bytes.
COLUMNS = ("tick", "clock_s", "code", "powered", *Truth._fields)
CONVERSION, CONVERTING, OUTPUT, OUTPUT_AT_START = 0xA5, 0x5A, 0x3C, 0x3D
# More inputs of the Arduino.
BUTTON, KNOB, RESET = 0xB7, 0xB8, 0xB9
OUTPUT_BYTES = 5
AFTER_THE_HOST_S = 0.5
CONVERTING_EVERY_S = 0.02
# Further behind than this the bench gives up on the ticks it has missed: the machine was busy with something else.
GIVE_UP_S = 0.1
# A serial line holds only so much: what a board does not take in time waits in the host's own buffer.
LINE_BYTES = 512
# A board that is this many conversions behind does not get more until it has caught up.
UNREAD = 8
UNREAD_AT_MOST = 16


def listener() -> socket.socket:
    """Return a socket that listens on this machine alone, at a port that the system chooses."""
    made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    made.bind(("127.0.0.1", 0))
    made.listen(4)
    return made


class Plant:
    """The bench's loop: one thread, all sockets, one wire."""

    def __init__(self, settings: dict[str, Any]) -> None:
        """Open the ports and start the emulator."""
        self.settings, self.board = settings, settings["board"]
        self.wire = BenchWire(self.board, settings["wire"], settings["seed"], settings["settings"])
        self.wire.add_faults(settings["faults"])
        self.line = LineFaults(settings["seed"])
        self.lockstep = settings["pace"] == "lockstep"
        self.period_s = float(self.board["tick_period_s"])
        self.ticks_a_sample = round(settings["sample_period_s"] / self.period_s)
        self.user_listener, self.host_listener, self.wire_listener = listener(), listener(), listener()
        self.user: socket.socket | None = None
        self.host: socket.socket | None = None
        self.pins: socket.socket | None = None
        self.unplugged = False
        self.to_board, self.from_pins = bytearray(), bytearray()
        self.watched = FrameParser()
        self.code = self.ticks = self.late = self.given_up = self.overwritten = self.answered = self.released = 0
        self.started_boards = 0
        self.waiting: int | None = None
        self.due_s = self.converting_s = time.monotonic()
        self.log = Path(settings["log"]).open("wb")  # noqa: SIM115 - open as long as the process
        self.machine = self._start_machine()
        self.orders = bytearray()
        self.done = self.ended_by_order = False

    def _start_machine(self) -> Any:
        ports = (self.host_listener.getsockname()[1], self.wire_listener.getsockname()[1])
        machine, elf, messages = self.settings["machine"], self.settings["elf"], Path(self.settings["messages"])
        return start_machine(machine, elf, *ports, messages, lockstep=self.lockstep)

    def run(self) -> None:
        """Work until the orders end, or the order to end comes."""
        try:
            while not self.done:
                self._turn()
        finally:
            self.machine.kill()
            self.machine.wait()
            if self.machine.stdin is not None:
                self.machine.stdin.close()
            self.log.close()
            for each in (self.user_listener, self.host_listener, self.wire_listener, self.user, self.host, self.pins):
                if each is not None:
                    each.close()

    def _turn(self) -> None:
        """Wait for whatever comes first, take it, and let a tick pass where one is due."""
        readable = {
            self.user_listener: self._accept_user,
            self.host_listener: self._accept_host,
            self.wire_listener: self._accept_pins,
            # By the clock the emulator is listened to once a tick: it says its bytes one by one, and waking up for each
            # would take the processor from it.
            self.pins if self.lockstep else None: self._read_pins,
            self.host if self.lockstep else None: self._read_host,
            # A full line is not read any further, as a real port holds its sender back.
            self.user if len(self.to_board) < LINE_BYTES else None: self._read_user,
        }
        sources = [source for source in readable if source is not None]
        ready, _, _ = select.select([sys.stdin.fileno(), *sources], [], [], self._patience_s())
        # The pins first: what was applied before an acknowledgement was applied before it.
        for source in (self.pins, *(item for item in sources if item is not self.pins)):
            if source is not None and source in ready and source.fileno() >= 0:
                readable[source]()
        self._flush_to_board()
        if sys.stdin.fileno() in ready:
            self._read_orders()
        self._pass_time()

    def _patience_s(self) -> float:
        if self.to_board:
            return 0.0005
        if not self.lockstep:
            return max(0.0, self.due_s - time.monotonic())
        return 0.0 if self.released and self.waiting is None else CONVERTING_EVERY_S / 4.0

    def _pass_time(self) -> None:
        if self.lockstep:
            self._pass_lockstep()
        else:
            self._pass_clock()

    def _pass_clock(self) -> None:
        now = time.monotonic()
        if now < self.due_s:
            return
        if now - self.due_s > GIVE_UP_S:
            self.given_up += int((now - self.due_s) / self.period_s)
            self.due_s = now
        self.late += now - self.due_s > self.period_s
        # Absolute deadlines: a late tick does not shift those after it.
        self.due_s += self.period_s
        if self.pins is not None:
            self._read_pins()
        if self.host is not None:
            self._read_host()
        self._tick()

    def _pass_lockstep(self) -> None:
        now = time.monotonic()
        if self.pins is not None and now - self.converting_s > CONVERTING_EVERY_S:
            self.converting_s = now
            self._to_pins(bytes([CONVERTING]))
        if self.released and self.waiting is None:  # time passes also without an answer of a board that is gone
            self.released -= 1
            self._tick()

    def _tick(self) -> None:
        """Let one tick pass at the wire and give its conversion to the board."""
        code = self.code if self.pins is not None else 0
        converted, truth = self.wire.tick(code)
        self.ticks += 1
        powered = self.pins is not None
        row = (float(self.ticks), time.monotonic(), float(code), float(powered), *truth)
        self.log.write(np.array(row).tobytes())
        if not powered:
            return
        number = self.ticks % 256
        # As in a converter's register, where the next conversion takes the place of one that was not fetched; now and
        # then one goes out all the same, for a board that has lost some.
        if (number - self.answered) % 256 > UNREAD and number % UNREAD_AT_MOST and not self.lockstep:
            self.overwritten += 1
            return
        packet = bytes([CONVERSION]) + converted.node.to_bytes(2, "little") + converted.shunt.to_bytes(2, "little")
        packet += bytes([number])
        check = 0
        for byte in packet:
            check ^= byte
        packet += bytes([check])
        if self.lockstep:
            self.waiting = number
            packet += bytes([CONVERTING])
        self._to_pins(packet)

    def _to_pins(self, data: bytes) -> None:
        try:
            if self.pins is not None:
                self.pins.send(data)
        except BlockingIOError:
            pass  # a stopped emulator: its converter runs on unread
        except OSError:
            self._lose_pins()

    def _accept_pins(self) -> None:
        self.pins, _ = self.wire_listener.accept()
        plain(self.pins)
        self.from_pins.clear()
        self.waiting = None

    def _lose_pins(self) -> None:
        """Mark the board as dead: nothing drives the gate of the output stage any more, its pull-down switches off."""
        if self.pins is not None:
            self.pins.close()
        self.pins, self.code, self.waiting = None, 0, None

    def _read_pins(self) -> None:
        data = received(self.pins)
        if data is None:
            self._lose_pins()
            return
        self.from_pins += data
        while len(self.from_pins) >= OUTPUT_BYTES:
            kind, low, high, number, check = self.from_pins[:OUTPUT_BYTES]
            if kind not in (OUTPUT, OUTPUT_AT_START) or kind ^ low ^ high ^ number != check:
                del self.from_pins[0]  # a reset in the middle of a packet: look for the next one
                continue
            del self.from_pins[:OUTPUT_BYTES]
            self.code = low + 256 * high
            self.answered = number if kind == OUTPUT else self.ticks % 256
            if kind == OUTPUT_AT_START:
                self.started_boards += 1
                self.waiting = None
            elif number == self.waiting:
                self.waiting = None

    def _accept_host(self) -> None:
        self.host, _ = self.host_listener.accept()
        plain(self.host)
        self.to_board.clear()

    def _read_host(self) -> None:
        data = received(self.host)
        if data is None:
            assert self.host is not None
            self.host.close()
            self.host = None
            return
        for frame in self.watched.feed(data):
            answer = read_message(frame)
            moves = isinstance(answer, Acknowledgement) and answer.kind in (MessageKind.DRIVE, MessageKind.TARGET)
            if moves and answer.result == AcknowledgementResult.DONE:
                self._read_pins_now()
                self.released = self.ticks_a_sample if self.lockstep else 0
        arrived, _ = self.line.passed(data, "to_host")
        if self.user is not None:
            try:
                self.user.send(arrived)
            except BlockingIOError:
                pass  # the host does not read: a serial port's buffer is full
            except OSError:
                self._lose_user()

    def _read_pins_now(self) -> None:
        if self.pins is not None and select.select([self.pins], [], [], 0.0)[0]:
            self._read_pins()

    def _accept_user(self) -> None:
        user, _ = self.user_listener.accept()
        if self.unplugged:
            user.close()
            return
        if self.user is not None:
            self.user.close()
        plain(user)
        self.user = user
        # Bytes that were in transit when the last host closed the port are dropped.
        self.released = 0
        if self.settings["resets_on_open"]:
            self._to_pins(bytes([RESET, 0]))

    def _lose_user(self) -> None:
        if self.user is not None:
            self.user.close()
        self.user = None
        self.released = round(AFTER_THE_HOST_S / self.period_s) if self.lockstep else 0

    def _read_user(self) -> None:
        data = received(self.user)
        if data is None:
            self._lose_user()
            return
        arrived, broken = self.line.passed(data, "to_board")
        self.to_board += arrived
        if broken:
            self.unplugged = True
            self._lose_user()

    def _flush_to_board(self) -> None:
        if not self.to_board:
            return
        if self.host is None:
            self.to_board.clear()
            return
        try:
            sent = self.host.send(self.to_board)
            del self.to_board[:sent]
        except BlockingIOError:
            pass
        except OSError:
            self.to_board.clear()

    def _read_orders(self) -> None:
        data = os.read(sys.stdin.fileno(), 65536)
        if not data:
            self.done = True
            return
        self.orders += data
        while b"\n" in self.orders:
            line, _, rest = bytes(self.orders).partition(b"\n")
            self.orders[:] = rest
            order = json.loads(line)
            if order["do"] == "end":
                self.done = self.ended_by_order = True
                return
            say(self._obey(order))

    def _obey(self, order: dict[str, Any]) -> dict[str, Any]:
        orders: dict[str, Callable[..., dict[str, Any] | None]] = {
            "figures": self.figures,
            "fault": lambda faults: self.wire.add_faults(faults),
            "repair": self.wire.clear_faults,
            "line": self._line,
            "unplug": self._unplug,
            "plug": self._plug,
            "kill_power": self._kill_power,
            "restart": self._restart,
            "monitor": self._monitor,
            "release": self._release,
            "button": lambda down: self._to_pins(bytes([BUTTON, int(down)])),
            "knob": lambda fraction: self._to_pins(bytes([KNOB, round(255 * fraction)])),
        }
        what = order.pop("do")
        try:
            return {"ok": True, **(orders[what](**order) or {})}
        except (MusclewireError, ValueError, TypeError, KeyError) as error:
            return {"ok": False, "error": f"{what}: {error}"}

    def figures(self) -> dict[str, Any]:
        """Return the bench's counts, after writing its log to the file."""
        self.log.flush()
        return {
            "ticks": self.ticks,
            "clock_s": time.monotonic(),
            "late": self.late,
            "given_up": self.given_up,
            "overwritten": self.overwritten,
            "starts": self.started_boards,
            "running": self.machine.poll() is None,
            "corrupted_bytes": self.line.corrupted_bytes,
            "lost_frames": self.line.lost_frames,
            "repeated_frames": self.line.repeated_frames,
            "released": self.released,
        }

    def _line(self, **faults: Any) -> None:
        directions: tuple[Direction, ...] = tuple(faults.pop("directions", ("to_board", "to_host")))
        self.line = LineFaults(self.settings["seed"], directions=directions, **faults)

    def _unplug(self) -> None:
        self.unplugged = True
        self._lose_user()

    def _plug(self) -> None:
        self.unplugged = False
        self.line.cut_after_bytes = None

    def _kill_power(self) -> None:
        self.machine.kill()
        self.machine.wait()
        self._lose_pins()

    def _restart(self) -> None:
        self._kill_power()
        self.machine = self._start_machine()

    def _monitor(self, text: str) -> None:
        """Send a line to the emulator's monitor, such as QEMU's system_reset, stop or cont."""
        assert self.machine.stdin is not None
        self.machine.stdin.write(f"{text}\n".encode())
        self.machine.stdin.flush()

    def _release(self, ticks: int) -> None:
        """Let some ticks pass in lockstep without a host's command."""
        self.released += ticks


def plain(connection: socket.socket) -> None:
    """Configure a connection so that it neither blocks nor waits for more to send."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setblocking(False)


def received(connection: socket.socket | None) -> bytes | None:
    """Return the bytes that have come, None if the other side has closed the connection."""
    assert connection is not None
    try:
        return connection.recv(4096) or None
    except BlockingIOError:
        return b""
    except OSError:
        return None


def say(what: dict[str, Any]) -> None:
    """Answer on standard output."""
    print(json.dumps(what), flush=True)


def go_first() -> None:
    """Ask for the processor before other programs, where that is permitted: hardware does not wait for them."""
    with contextlib.suppress(OSError):
        os.nice(-10)


def main() -> None:
    """Read the settings, print the port, run the bench; and again for the next board."""
    go_first()
    while settings := sys.stdin.readline():
        plant = Plant(json.loads(settings))
        say({"ok": True, "port": plant.user_listener.getsockname()[1]})
        plant.run()
        if not plant.ended_by_order:
            break
        say({"ok": True})


if __name__ == "__main__":
    main()
