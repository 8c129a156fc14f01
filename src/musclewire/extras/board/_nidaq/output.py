"""The host's connection to the guardian: every drive voltage goes through it, and a lost guardian is noticed."""

from __future__ import annotations

import os
import secrets
import socket
import subprocess
import sys
from contextlib import suppress
from typing import NoReturn

from musclewire.errors import RigError
from musclewire.extras.board._nidaq.driver import DaqFaultError, OutputLine
from musclewire.extras.board._nidaq.guardian import BEGIN, COMMAND, END, KEEP, PUT, REPLY, SAFE, GuardianOrders

# Starting Python and the driver takes a second or two on a slow machine.
START_S = 30.0
# Switching off may take a reset of the card; anything longer is a guardian that hangs.
ANSWER_S = 3.0
WORD_BYTES = 16
# Windows: before ordinary programs, and not reached by the console's Ctrl-C. On other systems these are not defined.
WINDOWS_FLAGS = getattr(subprocess, "HIGH_PRIORITY_CLASS", 0) | getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)


class HostStalledError(RigError):
    """The guardian has switched off because the host was silent for ``silent_s`` seconds."""

    def __init__(self, silent_s: float) -> None:
        """Keep the time."""
        super().__init__(f"no command for {silent_s:.3f} s")
        self.silent_s = silent_s


class GuardianLostError(RigError):
    """The process that owns the output is gone or hangs; the host has tried to switch off by itself."""


class GuardedOutput:
    """The output of a card, owned by a guardian process. Raises DaqFaultError if the card refuses."""

    def __init__(self, orders: GuardianOrders) -> None:
        """Start the guardian, and wait until it has applied 0 V."""
        self._orders = orders
        self._closed = False
        self._off_confirmed = False
        self._received = b""
        self._answers_due = 0
        word = secrets.token_hex(WORD_BYTES // 2)
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.settimeout(START_S)
            # A session of its own on POSIX: a signal that kills the host's group must not kill its guardian first.
            self._process = subprocess.Popen(
                # -P: no file in the folder where the user works takes the place of a module.
                [sys.executable, "-P", "-m", "musclewire.extras.board._nidaq.guardian"],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
                creationflags=WINDOWS_FLAGS,
                text=True,
                env={"GRPC_VERBOSITY": "NONE", **os.environ},  # the rig reports a lost connection itself
            )
            try:
                assert self._process.stdin is not None
                self._process.stdin.write(f"{server.getsockname()[1]} {word}\n{orders.as_text()}\n")
                self._process.stdin.close()
                self._line = accepted(server, word)
            except (OSError, TimeoutError):
                self._process.kill()
                self._process.wait()
                raise GuardianLostError(
                    "the process that owns the card's output did not start: is the machine overloaded? try again"
                ) from None
        try:
            self._answers_due = 1
            self.clock_hz = self._answer() or None
            self._line.settimeout(ANSWER_S)
        except RigError:
            self._let_go()
            raise

    def begin(self, drive_v: float) -> None:
        """Apply a drive voltage now; if the card has a clock for it, the next ones wait for its edges."""
        self._ask(BEGIN, drive_v)

    def put(self, drive_v: float) -> None:
        """Apply a drive voltage at the next edge, or at once without a clock."""
        self._ask(PUT, drive_v)

    def put_now(self, drive_v: float) -> None:
        """Apply a drive voltage at once."""
        self._ask(SAFE, drive_v)

    def keep(self) -> None:
        """Say that the host is alive. Raises HostStalledError if the guardian has switched off meanwhile."""
        self._ask(KEEP, 0.0)

    def _ask(self, what: bytes, drive_v: float) -> None:
        self._answers_due += 1
        try:
            self._line.sendall(COMMAND.pack(what, drive_v))
        except OSError:
            self._lost()
        # Ctrl-C may have left the answer to an earlier command unread; it does not belong to this one.
        while self._answers_due > 0:
            self._answer()

    def _answer(self) -> float:
        """Return the number of the guardian's answer. Raises the error that it reports."""
        try:
            what, number, code, length = REPLY.unpack(self._waiting(REPLY.size)[: REPLY.size])
            text = self._waiting(REPLY.size + length)[REPLY.size : REPLY.size + length].decode()
        except (OSError, EOFError):
            self._lost()
        self._received = self._received[REPLY.size + length :]
        self._answers_due -= 1
        if what == b"T":
            raise HostStalledError(number)
        if what == b"E":
            raise DaqFaultError(text, code)
        return float(number)

    def _waiting(self, count: int) -> bytes:
        """Return the bytes that have been received and not been taken, waiting for ``count`` of them."""
        while len(self._received) < count:
            more = self._line.recv(count - len(self._received))
            if not more:
                raise EOFError
            self._received += more
        return self._received

    def _lost(self) -> NoReturn:
        """Switch off without the guardian, which is gone or hangs, and raise GuardianLostError."""
        self._let_go()
        try:
            output = OutputLine(self._orders.output)
        except DaqFaultError as fault:
            raise GuardianLostError(f"the process that owned the card's output has ended, and {fault}") from None
        try:
            off_v = (0.0 - self._orders.offset_v) / self._orders.gain
            try:
                output.put_now(off_v)
            except DaqFaultError:
                output.take_over(off_v)  # the guardian's task still exists
        except DaqFaultError as fault:
            raise GuardianLostError(f"the process that owned the card's output has ended, and {fault}") from None
        finally:
            output.close()
        self._off_confirmed = True
        raise GuardianLostError(
            "the process that owned the card's output has ended; this one has switched off: open the rig again"
        )

    def _let_go(self) -> None:
        self._closed = True
        with suppress(OSError):
            self._line.close()
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()

    def close(self) -> bool:
        """Apply 0 V and end the guardian; return whether the card took it. May be called twice; never raises."""
        if self._closed:
            return self._off_confirmed
        self._closed = True
        try:
            self._line.sendall(COMMAND.pack(END, 0.0))
            # It ends only after it has applied 0 V, or has tried for long enough; its exit code says which.
            self._off_confirmed = self._process.wait(timeout=START_S) == 0
        except (OSError, subprocess.TimeoutExpired):
            pass
        # A guardian that has tried and failed has that exit code; any other end may have left the voltage out.
        if self._process.poll() not in (0, RigError.exit_code):
            with suppress(RigError):
                self._lost()
        self._line.close()
        return self._off_confirmed


def accepted(server: socket.socket, word: str) -> socket.socket:
    """Return the connection of the process that knows the word; those of other processes are closed."""
    while True:
        line, _ = server.accept()
        line.settimeout(ANSWER_S)
        with suppress(OSError):
            data = b""
            while len(data) < len(word) and (more := line.recv(len(word) - len(data))):
                data += more
            if secrets.compare_digest(data, word.encode()):
                line.settimeout(START_S)
                line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                return line
        line.close()
