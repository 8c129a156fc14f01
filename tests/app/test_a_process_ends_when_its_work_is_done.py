"""What a process does at its end: all that is to be done, nothing else, and with the exit code that was decided."""

from __future__ import annotations

import subprocess
import sys

import pytest

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
