"""What a process does at its end and says of its beginning, whatever its output takes."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from tests.places import CHECKOUT

# What a process does at its end: all that is to be done, nothing else, and with the exit code that was decided.

SCRIPT = """
import sys
from musclewire.app import leaves_at_once

class Loaded:
    def __del__(self):
        print("taken apart")

loaded = [Loaded()]
loaded.append(loaded)  # as modules are: nothing but the interpreter's own end reaches it

with leaves_at_once():
    import atexit, threading, time
    atexit.register(print, "registered")
    threading.Thread(target=lambda: (time.sleep(0.05), print("thread"))).start()
    print("work")
    ENDING
"""


def ended(ending: str) -> tuple[int, list[str], str]:
    run = subprocess.run([sys.executable, "-c", SCRIPT.replace("ENDING", ending)], capture_output=True, text=True)
    return run.returncode, run.stdout.split("\n"), run.stderr


@pytest.mark.parametrize("code", [0, 130])
def test_threads_and_functions_for_the_exit_come_first_and_nothing_is_taken_apart(code: int) -> None:
    assert ended(f"sys.exit({code})") == (code, ["work", "thread", "registered", ""], "")


def test_an_error_of_the_program_is_shown_as_ever() -> None:
    code, said, errors = ended("raise RuntimeError('of ours')")
    assert (code, said[:3]) == (1, ["work", "thread", "registered"])
    assert errors.rstrip().endswith("RuntimeError: of ours")


def test_a_program_without_a_stdout_ends_alike() -> None:
    assert ended("sys.stdout.flush(); sys.stdout = None; sys.exit(3)") == (3, ["work", ""], "")


# An output that takes no more, by a full disk or a reader that has left, ends a command by a line at most.


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux has /dev/full")
@pytest.mark.parametrize("words", [["catalogue"], ["catalogue", "--json"], ["--help"], ["--version"]])
def test_a_full_stdout_is_one_line_and_no_traceback(words: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "musclewire", *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert ended.returncode == 1
    (line,) = (line for line in ended.stderr.splitlines() if "compil" not in line)  # as on a new machine
    assert line.startswith("musclewire: the result cannot be written to stdout: No space left on device")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux has /dev/full")
def test_a_reader_that_has_left_is_not_told_so() -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "musclewire", "catalogue"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        assert process.stderr.read() == ""
    assert process.returncode == 1


# Whatever is still open when Python ends is switched off, in a process of its own.

LEFT_OPEN = """
from tests.unit.rigs.ideal_wire import IdealWire
from musclewire.rigs import GuardedRig

class Told(IdealWire):
    def off(self):
        print("off", flush=True)
        return super().off()

rig = GuardedRig(Told(paced={paced}))
for _ in range(3):
    rig.exchange(3.0)
{end}
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("end", "paced"),
    [("", True), ("", False), ("raise SystemExit(3)", False), ("raise ValueError", True), ("rig = None", True)],
)
def test_a_rig_that_is_open_when_python_ends_is_switched_off(end: str, paced: bool) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LEFT_OPEN.format(paced=paced, end=end)],
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "off" in done.stdout.splitlines(), done.stderr


# The first run says that it compiles, once, and for how long; what the cache holds is not compiled again.


def said_by(folder: Path, *more: str) -> list[str]:
    """Run a command with a kernel cache in a folder; return what it says of compiling."""
    command = [
        sys.executable,
        "-m",
        "musclewire",
        "simulate",
        "--supply",
        "3 V",
        "--off-after",
        "0.1 s",
        "--duration",
        "0.2 s",
    ]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache")}
    done = subprocess.run([*command, *more], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [line for line in done.stderr.splitlines() if "compil" in line]


@pytest.mark.slow
def test_the_first_run_says_that_it_compiles_and_the_second_is_silent(tmp_path: Path) -> None:
    began, ended = said_by(tmp_path, "-o", "first.h5")
    assert began == "compiling wire and controllers to machine code, once: later runs take it from the cache"
    assert re.fullmatch(r"compiling took [\d.]+ s of [\d.]+ s", ended)
    assert said_by(tmp_path, "-o", "second.h5") == []
    # With --json only the answer is printed, also when something is compiled: one function, to be short.
    kept = list((tmp_path / "cache").rglob("*cool_from_hot*"))
    for file in kept:
        file.unlink()
    assert said_by(tmp_path, "-o", "third.h5", "--json") == []
    assert kept
    assert all(file.exists() for file in kept)
