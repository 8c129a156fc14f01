"""The line through pyserial: its loop-back port, a socket of this machine, ports that fail as pyserial's do."""

from __future__ import annotations

import socket

import pytest

from musclewire.errors import RigError
from musclewire.extras.board import open_line
from musclewire.extras.board._serial.line import LineLostError, SerialLine


def test_what_is_written_to_a_loop_comes_back_and_nothing_else() -> None:
    line = open_line("loop://", 115200)
    line.write(b"\x01\0\xff")
    assert line.read(1.0) == b"\x01\0\xff"
    assert line.read(0.0) == b""
    assert line.name == "loop://"
    line.close()
    line.close()


@pytest.mark.parametrize("what", ["read", "write"])
def test_a_closed_line_is_lost(what: str) -> None:
    line = open_line("loop://", 115200)
    line.close()
    with pytest.raises(LineLostError, match="the line to the board, loop://, is gone"):
        line.read(0.0) if what == "read" else line.write(b"x")


def test_a_socket_carries_both_ways_and_is_lost_when_the_other_end_closes() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        line = open_line(f"socket://127.0.0.1:{server.getsockname()[1]}", 115200)
        other, _ = server.accept()
        with other:
            line.write(b"abc")
            assert other.recv(3) == b"abc"
            other.sendall(b"def")
            assert line.read(10.0) == b"def"
        with pytest.raises(LineLostError, match="is gone"):
            line.read(10.0)
        line.close()
        line.close()


def test_a_port_that_another_thread_has_closed_fails_by_an_error_of_another_kind() -> None:
    class Closed:
        """pyserial's port after ``close``: its file descriptor is None."""

        timeout = 0.0

        def read(self, _count: int) -> bytes:
            raise TypeError("'NoneType' object cannot be interpreted as an integer")

        def write(self, _data: bytes) -> None:
            raise AttributeError

        def close(self) -> None:
            raise OSError

    line = SerialLine(Closed(), "/dev/ttyACM0")
    with pytest.raises(LineLostError, match="cannot be interpreted"):
        line.read(0.0)
    with pytest.raises(LineLostError, match="AttributeError"):
        line.write(b"x")
    line.close()


@pytest.mark.parametrize("kind", ["socket", "rfc2217"])
def test_ports_of_this_machine_say_nothing_about_another_machines_address(kind: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"{kind}://127.0.0.1:{server.getsockname()[1]}"
    with pytest.raises(RigError, match=f"cannot open the serial port {kind}://.*efused") as caught:
        open_line(address, 115200)
    assert "here now" not in str(caught.value)
