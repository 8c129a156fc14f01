"""A serial line through pyserial: a port of this machine, a pseudo-terminal, or ``socket://host:port``."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
from typing import Any, Protocol

from musclewire.errors import RigError
from musclewire.extras.board._serial.ports import holder_of, ports_text, serial_ports

# More than a second of samples at any rate: a longer backlog has been abandoned.
READ_BYTES = 65536
PATIENCE_S = 0.25
# Of a port that a program has locked, as this one does, or that it keeps from being opened.
HELD = (errno.EWOULDBLOCK, errno.EBUSY)


class LineLostError(RigError):
    """The line to the board is gone: unplugged, reset, or closed by the other side."""


class ByteLine(Protocol):
    """Bytes to and from a board."""

    @property
    def name(self) -> str:
        """Name of the line in messages."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes. Raises LineLostError if the line is gone, or takes nothing in time."""
        ...

    def read(self, timeout_s: float) -> bytes:
        """Return the bytes that have come, after waiting for the first; 0 s does not wait. Raises LineLostError."""
        ...

    def close(self) -> None:
        """Close the line; may be called twice; never raises."""
        ...


class SerialLine:
    """A line through pyserial."""

    def __init__(self, port: Any, name: str) -> None:
        """Take an open pyserial port."""
        self._port, self._name = port, name

    @property
    def name(self) -> str:
        """The port as it was given."""
        return self._name

    def write(self, data: bytes) -> None:
        """Send bytes. Raises LineLostError, also for a line that takes none in time."""
        try:
            self._port.write(data)
        except (OSError, TypeError, AttributeError) as error:
            raise self._lost(error) from None

    def read(self, timeout_s: float) -> bytes:
        """Return the bytes that have come, waiting for the first one up to ``timeout_s``. Raises LineLostError."""
        try:
            self._port.timeout = max(timeout_s, 0.0)
            first: bytes = self._port.read(1)
            if not first:
                return b""
            # A socket does not report how many bytes wait, so the rest is read without waiting.
            self._port.timeout = 0.0
            rest: bytes = self._port.read(READ_BYTES)
            return first + rest
        except (OSError, TypeError, AttributeError) as error:
            raise self._lost(error) from None

    def _lost(self, error: Exception) -> LineLostError:
        """Return the error of a line that is gone; for one closed meanwhile pyserial raises several kinds."""
        reason = " ".join(str(error).split()) or type(error).__name__
        return LineLostError(f"the line to the board, {self._name}, is gone: {reason}")

    def close(self) -> None:
        """Close the line; may be called twice; never raises."""
        inner = getattr(self._port, "_socket", None)
        # pyserial does not close a socket whose other end is gone, and sleeps 0.3 s after it has closed another: too
        # long for a loop that waits for a stop.
        with contextlib.suppress(Exception):
            if inner is not None:
                inner.shutdown(socket.SHUT_RDWR)
        with contextlib.suppress(Exception):
            if inner is not None:
                self._port.is_open = False
                inner.close()
        with contextlib.suppress(Exception):  # nothing can be done about a port that cannot be closed
            self._port.close()


def open_line(port: str, baud: int, patience_s: float = PATIENCE_S) -> SerialLine:
    """Open a port: ``/dev/ttyACM0``, ``COM3``, or a URL of pyserial's such as ``socket://127.0.0.1:4000``.

    A port of this computer is opened for this program alone, until it is closed or the program ends. A line that takes
    no bytes for ``patience_s`` counts as lost. Raises RigError if the port is missing, held by another program or by
    this one, or not permitted.
    """
    import serial

    try:
        # Windows lets nobody else in by itself; what is no port of this computer, such as a socket, ignores it.
        opened = serial.serial_for_url(port, baudrate=baud, timeout=0.0, write_timeout=patience_s, exclusive=True)
    except (serial.SerialException, OSError, ValueError) as error:
        if getattr(error, "errno", None) in HELD:
            raise held_error(port) from None
        reason = " ".join(str(error).split())
        raise RigError(
            f"cannot open the serial port {port}: {reason}; check that the board is plugged in, that no other program "
            f"holds the port, and that you may use it (on Linux: group dialout){ports_here(port)}"
        ) from None
    return SerialLine(opened, port)


def held_error(port: str) -> RigError:
    """Return the error of a port that is open already, with who holds it if the system shows it."""
    holder = holder_of(port)
    if holder is None:
        who, what_to_do = "another program", "close the port there, or end that program"
    elif holder.process_id == os.getpid():
        who = f"this program itself (process {holder.process_id})"
        what_to_do = "close the rig that holds it: end its `with` block, or call its `close()`"
    else:
        named = f"{holder.program}, " if holder.program else ""
        who = f"another program ({named}process {holder.process_id})"
        what_to_do = "close the port there, or end that program"
    return RigError(f"cannot open the serial port {port}: it is held by {who}; {what_to_do}, and open it again")


def ports_here(port: str) -> str:
    """Return which ports exist, for a port of this computer that could not be opened."""
    return "" if "://" in port else f"; {ports_text(serial_ports())}"
