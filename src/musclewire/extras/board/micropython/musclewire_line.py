"""The host's line over USB: raw bytes in and out, and no Ctrl-C while the program runs."""

import select
import sys

import micropython


class Line:
    """Bytes of standard input and output, neither of which ever blocks."""

    def __init__(self):
        micropython.kbd_intr(-1)  # a three is data; the program itself knows Ctrl-C
        self._poll = select.poll()
        self._poll.register(sys.stdin, select.POLLIN)
        self._out = select.poll()
        self._out.register(sys.stdout, select.POLLOUT)

    def received(self):
        """Return the bytes that have come."""
        found = bytearray()
        while len(found) < 64 and self._poll.poll(0):
            found.extend(sys.stdin.buffer.read(1))
        return found

    def send(self, frame):
        """Send a whole frame, or nothing where the host does not read: a wire must not wait for it."""
        if self._out.poll(0):
            sys.stdout.buffer.write(frame)

    def close(self):
        """Give Ctrl-C back to the interpreter."""
        micropython.kbd_intr(3)
