"""A serial port is one program's: pseudo-terminals of this machine, held by this process, by others, or by nobody."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import serial
from tests.command_line import CommandLine

from musclewire.errors import RigError
from musclewire.extras.board import open_line
from musclewire.extras.board._serial import line as line_module
from musclewire.extras.board._serial.ports import PortHolder, holder_of, locking_processes, program_of
from musclewire.rigs import shipped_rig_files

HOLDS = (
    "import sys; from musclewire.extras.board._serial.line import open_line; "
    "line = open_line(sys.argv[1], 115200); print('open', flush=True); sys.stdin.read()"
)
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX's")
only_linux = pytest.mark.skipif(sys.platform != "linux", reason="no other system shows who holds a port")


@pytest.fixture
def port() -> Iterator[str]:
    """A pseudo-terminal, as an emulated board has one: its name, the board's end and a keeper open."""
    board_end, keeper = os.openpty()
    yield os.ttyname(keeper)
    os.close(keeper)
    os.close(board_end)


@contextmanager
def held_by_another(port: str) -> Iterator[subprocess.Popen[str]]:
    """Another process that has opened the port by the same function, until it is ended."""
    command = [sys.executable, "-c", HOLDS, port]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    with process:
        assert process.stdout is not None
        assert process.stdout.readline() == "open\n"
        yield process
        process.kill()


def test_a_port_is_opened_once_in_a_program_and_again_when_it_is_closed(port: str) -> None:
    first = open_line(port, 115200)
    with pytest.raises(RigError, match="it is held by ") as caught:
        open_line(port, 115200)
    assert caught.value.exit_code == 3
    assert port in str(caught.value)
    if sys.platform == "linux":
        assert f"this program itself (process {os.getpid()}); close the rig that holds it" in str(caught.value)
    first.close()
    open_line(port, 115200).close()


def test_the_line_that_is_refused_leaves_the_first_one_as_it_was(port: str) -> None:
    first = open_line(port, 115200)
    with pytest.raises(RigError):
        open_line(port, 9600)
    assert first._port.baudrate == 115200
    first.write(b"abc")
    first.close()


@pytest.mark.parametrize("code", ["EBUSY", "EWOULDBLOCK"])
@pytest.mark.parametrize(
    ("holder", "words"),
    [
        (
            PortHolder(4711, "minicom -D /dev/ttyACM0"),
            r"another program (minicom -D /dev/ttyACM0, process 4711); close",
        ),
        (PortHolder(4711, ""), "another program (process 4711); close the port there"),
        (None, "another program; close the port there, or end that program, and open it again"),
    ],
)
def test_the_message_names_the_other_program_as_far_as_it_is_known(
    monkeypatch: pytest.MonkeyPatch, code: str, holder: PortHolder | None, words: str
) -> None:
    def refuses(*_: Any, **__: Any) -> None:
        raise serial.SerialException(getattr(errno, code), "could not open port")

    monkeypatch.setattr(serial, "serial_for_url", refuses)
    monkeypatch.setattr(line_module, "holder_of", lambda _port: holder)
    with pytest.raises(RigError) as caught:
        open_line("/dev/ttyACM0", 115200)
    assert f"cannot open the serial port /dev/ttyACM0: it is held by {words}" in str(caught.value)


def test_a_lock_is_found_by_device_and_file_and_one_that_waits_is_none(tmp_path: Path) -> None:
    node = tmp_path.stat()
    here = f"{os.major(node.st_dev):02x}:{os.minor(node.st_dev):02x}:{node.st_ino}"
    lines = [
        f"1: FLOCK  ADVISORY  WRITE 41 {here} 0 EOF",
        f"1: -> FLOCK  ADVISORY  WRITE 42 {here} 0 EOF",
        f"2: POSIX  ADVISORY  WRITE 43 {here} 0 EOF",
        f"3: FLOCK  ADVISORY  WRITE 44 {here}1 0 EOF",
        f"4: FLOCK  ADVISORY  WRITE 0 {here} 0 EOF",
        "",
        "5: FLOCK",
    ]
    assert list(locking_processes(node, lines)) == [41]


@only_linux
def test_who_holds_a_port_is_unknown_for_what_is_no_port() -> None:
    assert holder_of("socket://127.0.0.1:4000") is None
    assert program_of(os.getpid()) != ""


@only_linux
@pytest.mark.slow
def test_the_port_of_another_process_is_refused_with_its_name_and_number_until_it_is_killed(
    port: str, tmp_path: Path, musclewire: CommandLine
) -> None:
    text = shipped_rig_files()["serial-board"].read_text("utf-8")
    lines = (f'port = "{port}"' if line.startswith("port") else line for line in text.splitlines())
    (tmp_path / "board.toml").write_text("\n".join(lines), "utf-8")
    with held_by_another(port) as other:
        answer = musclewire("characterize", tmp_path / "board.toml", "-o", tmp_path / "loop.h5")
        assert answer.code == 3
        assert f"{port}: it is held by another program (python" in answer.err
        assert f"process {other.pid}); close the port there" in answer.err
        other.send_signal(signal.SIGKILL)
        other.wait()
        open_line(port, 115200).close()


@only_linux
@pytest.mark.slow
def test_a_program_that_locks_nothing_and_keeps_others_out_is_found_by_its_open_file(port: str) -> None:
    command = [sys.executable, "-c", "import sys; file = open(sys.argv[1]); print(flush=True); sys.stdin.read()", port]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        other.stdout.readline()
        found = holder_of(port)
        assert found is not None
        assert found.process_id == other.pid
        assert "sys.argv[1]" in found.program
        other.kill()
