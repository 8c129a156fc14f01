"""A small process of its own that owns the card's output, because a card holds its last voltage when its program dies.

The host sends it every drive voltage over a socket of this machine. It switches off when the socket closes without an
END command (the host was killed), goes to the sense voltage and then off when the host is silent while the wire is
driven (the host has stalled), and off when it receives END. It opens the output before the host heats anything, so that
switching off is one write.

``output.GuardedOutput`` starts it; it is not meant to be run by hand.
"""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import struct
import sys
import time
from contextlib import suppress
from typing import NamedTuple

from musclewire.errors import MusclewireError, RigError
from musclewire.extras.board._nidaq.driver import DaqFaultError, OutputLine, OutputSettings
from musclewire.extras.board._nidaq.scale import LinearScale

# Host to guardian: a command, and a drive voltage [V].
COMMAND = struct.Struct("<cd")
BEGIN, PUT, KEEP, SAFE, END = b"B", b"D", b"K", b"S", b"O"
# Guardian to host: the result; seconds of silence, or the clock's rate; the driver's number; a text's length.
REPLY = struct.Struct("<cdiH")
DONE, TRIPPED, FAILED = b"A", b"T", b"E"
# How often the guardian checks that its parent still lives, because other processes may have inherited the socket.
LOOK_S = 0.05
# [s] for which it keeps trying to switch off a card that does not answer:
PERSIST_S = 1.0  # of a host that lives, which warns its user
PERSIST_ALONE_S = 60.0  # after a dead one, when no other process tries


class GuardianOrders(NamedTuple):
    """Orders that a guardian receives before it opens the output; voltages are drive voltages [V], times in seconds."""

    output: OutputSettings
    gain: float
    offset_v: float
    sense_voltage_v: float
    sense_after_s: float
    trip_after_s: float

    def as_text(self) -> str:
        """Return the orders as one line."""
        return json.dumps(self)

    @classmethod
    def from_text(cls, text: str) -> GuardianOrders:
        """Return the orders of a line."""
        output, *rest = json.loads(text)
        return cls(OutputSettings(*output), *rest)


class SilenceWatch:
    """The rule for a silent host while the wire is driven: times in, voltage out, without a clock of its own."""

    def __init__(self, orders: GuardianOrders) -> None:
        """Start with nothing out."""
        self._orders = orders
        self.drive_v = 0.0
        self.last_command_s = 0.0
        self.tripped_after_s: float | None = None
        self._degraded = False

    def note(self, now_s: float, drive_v: float | None = None) -> None:
        """Note a command of the host, with its drive voltage if it has one."""
        self.last_command_s = now_s
        if drive_v is not None:
            self.drive_v = drive_v
            self._degraded = False

    @property
    def watching(self) -> bool:
        """Whether silence matters now."""
        return self.tripped_after_s is None and (self._degraded or self.drive_v > self._orders.sense_voltage_v + 1e-9)

    def left_s(self, now_s: float) -> float:
        """Return the time until the next action is due [s]."""
        if not self.watching:
            return LOOK_S
        next_s = self._orders.trip_after_s if self._degraded else self._orders.sense_after_s
        return min(LOOK_S, max(0.0, self.last_command_s + next_s - now_s))

    def due(self, now_s: float) -> float | None:
        """Return the drive voltage that the silence requires now, None if it requires no change."""
        silent_s = now_s - self.last_command_s
        if not self.watching or silent_s < self._orders.sense_after_s:
            return None
        if silent_s >= self._orders.trip_after_s:
            self.tripped_after_s = silent_s
            return 0.0
        if self._degraded:
            return None
        self._degraded = True
        return self._orders.sense_voltage_v


class OutputGuardian:
    """The output, the socket and the watch together."""

    def __init__(self, orders: GuardianOrders, line: socket.socket) -> None:
        """Open the output and put it to 0 V. Raises DaqFaultError if that fails."""
        self._line = line
        self._scale = LinearScale(orders.gain, orders.offset_v)
        self._watch = SilenceWatch(orders)
        self._orders = orders
        self._parent = os.getppid()
        self._output = OutputLine(orders.output)
        try:
            self._output.put_now(self._scale.voltage_v(0.0))
            self._reply(DONE, self._output.clock_hz() or 0.0)
        except BaseException:
            self._output.close()
            raise

    def run(self) -> bool:
        """Serve the host until it sends END or is gone; return whether the card then took 0 V."""
        goodbye = off = False
        try:
            with suppress(OSError, SystemExit):  # a host that dies in the middle of a message is gone; SIGTERM
                goodbye = self._serve()
        finally:
            # Nothing may keep this process from switching off, whatever has ended it.
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            off = self._off(PERSIST_S if goodbye else PERSIST_ALONE_S)
            if not goodbye:
                self._output.release_card()
            self._output.close()
            if goodbye:
                with suppress(OSError):
                    self._reply(DONE)
        return off

    def _serve(self) -> bool:
        """Follow the host; return whether it sent END, False if it is gone."""
        while os.getppid() == self._parent:
            silent_at_s = self._silent_at_s()
            if silent_at_s is not None:
                self._look(silent_at_s)
                continue
            message = self._receive()
            if message is None:
                return False
            if self._obey(*message):
                return True
        return False

    def _silent_at_s(self) -> float | None:
        """Wait for a command; return None when there is one, otherwise a time until which there certainly was none.

        The machine may delay this process too. A command that has come meanwhile ends the host's silence, so the socket
        is checked once more after the clock.
        """
        if select.select([self._line], [], [], self._watch.left_s(time.monotonic()))[0]:
            return None
        now_s = time.monotonic()
        return None if select.select([self._line], [], [], 0.0)[0] else now_s

    def _receive(self) -> tuple[bytes, float] | None:
        """Return the next command, None if the host is gone."""
        data = b""
        while len(data) < COMMAND.size:
            more = self._line.recv(COMMAND.size - len(data))
            if not more:
                return None
            data += more
        what, drive_v = COMMAND.unpack(data)
        return what, drive_v

    def _obey(self, what: bytes, drive_v: float) -> bool:
        """Carry out a command of the host; return whether it was END."""
        if what == END:
            return True
        if self._watch.tripped_after_s is not None:
            self._reply(TRIPPED, self._watch.tripped_after_s)
            return False
        if what == KEEP:
            self._watch.note(time.monotonic())
            self._reply(DONE)
            return False
        try:
            voltage_v = self._scale.voltage_v(drive_v)
            if what == BEGIN:
                self._output.begin(voltage_v)
            elif what == PUT:
                self._output.put(voltage_v)
            else:
                self._output.put_now(voltage_v)
        except DaqFaultError as fault:
            self._reply(FAILED, 0.0, fault)
            return False
        self._watch.note(time.monotonic(), drive_v)
        self._reply(DONE)
        return False

    def _look(self, silent_at_s: float) -> None:
        """Apply the voltage that silence until a time requires."""
        due_v = self._watch.due(silent_at_s)
        if due_v is None:
            return
        try:
            self._output.put_now(self._scale.voltage_v(due_v))
        except DaqFaultError:
            self._off(PERSIST_S)

    def _off(self, persist_s: float) -> bool:
        """Apply 0 V, by a reset of the card if a write fails; give up after a while. Return whether it is out."""
        until = time.monotonic() + persist_s
        while True:
            try:
                self._output.put_now(self._scale.voltage_v(0.0))
                return True
            except DaqFaultError:
                pass
            try:
                self._output.take_over(self._scale.voltage_v(0.0))
                return True
            except DaqFaultError:
                if time.monotonic() > until:
                    return False
                time.sleep(LOOK_S)

    def _reply(self, what: bytes, number: float = 0.0, fault: MusclewireError | None = None) -> None:
        reply(self._line, what, number, fault)


def reply(line: socket.socket, what: bytes, number: float, fault: MusclewireError | None) -> None:
    """Send a reply, with the fault if there is one."""
    text = str(fault).encode() if fault else b""
    line.sendall(REPLY.pack(what, number, getattr(fault, "code", 0), len(text)) + text)


def go_first() -> None:
    """Run before every ordinary process if that is permitted; this process sleeps most of the time."""
    # Linux only, and before gRPC starts its threads, which inherit it. Windows: by its parent (output.py).
    if hasattr(os, "sched_setscheduler"):
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))


def main() -> int:
    """Read the port, a word that only the parent knows and the orders from standard input, then serve."""
    # Ctrl-C reaches every process of a terminal; the host decides when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    go_first()
    port, word = sys.stdin.readline().split()
    orders = GuardianOrders.from_text(sys.stdin.readline())
    line = socket.create_connection(("127.0.0.1", int(port)), timeout=5.0)
    line.settimeout(None)
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    with line:
        line.sendall(word.encode())
        try:
            guardian = OutputGuardian(orders, line)
        except MusclewireError as fault:
            reply(line, FAILED, 0.0, fault)
            return fault.exit_code
        # The exit code shows the host whether the card took 0 V.
        return 0 if guardian.run() else RigError.exit_code


if __name__ == "__main__":
    sys.exit(main())
