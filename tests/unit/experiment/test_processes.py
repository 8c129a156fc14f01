"""The one pool of processes: what is sent comes back, whatever dies, prints or fails on the way."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from threading import Lock

import pytest

from musclewire.errors import CallerError, NumericsError
from musclewire.experiment import evaluate_in_processes

# No main guard, a function of the script itself, and a file of the current folder called as a module of Python's.
SCRIPT = """
import os
from musclewire.experiment import evaluate_in_processes

def squared(number):
    print("from", os.getpid())
    return number**2, os.environ["NUMBA_NUM_THREADS"]

found = {}
evaluate_in_processes(squared, range(5), found.__setitem__, workers=2, named=str)
print(sorted(found.items()))
"""


def of_numbers(function, **options):
    """Return the results of a function of eight numbers."""
    found = {}
    evaluate_in_processes(function, range(8), found.__setitem__, named=lambda item: f"number {item}", **options)
    return found


def test_one_worker_is_this_process_and_its_errors_are_its_own() -> None:
    assert set(of_numbers(lambda _: os.getpid(), workers=1).values()) == {os.getpid()}
    with pytest.raises(ZeroDivisionError):
        of_numbers(lambda item: 1 / item, workers=1)


def test_whoever_looks_may_stop_before_any_item() -> None:
    def stop() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        of_numbers(str, workers=1, look=stop)


@pytest.mark.slow
def test_a_script_without_a_main_guard_gets_its_results_and_its_output_is_its_own(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT, "utf-8")
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == f"{[(number, (number**2, '1')) for number in range(5)]}\n"
    assert done.stderr.count("from") == 5


@pytest.mark.slow
def test_an_error_in_the_code_of_a_process_names_its_item() -> None:
    with pytest.raises(NumericsError, match="number 0: ZeroDivisionError: division by zero"):
        of_numbers(lambda item: 1 / item, workers=2)


@pytest.mark.slow
def test_a_process_that_dies_is_begun_again_and_one_that_always_dies_is_an_error(tmp_path: Path) -> None:
    pids = tmp_path / "pids"

    def dies(item: int, note: Path, always: bool) -> int:
        with pids.open("a", encoding="utf-8") as file:
            file.write(f"{os.getpid()}\n")
        if item == 3 and (always or not note.exists()):
            note.touch()
            os._exit(1)
        return item

    found = of_numbers(lambda item: dies(item, tmp_path / "died", False), workers=2)
    assert sorted(found) == sorted(found.values()) == list(range(8))
    with pytest.raises(NumericsError, match="number 3 has died 2 times"):
        of_numbers(lambda item: dies(item, tmp_path / "died", True), workers=3)
    assert [pid for pid in pids.read_text("utf-8").split() if Path(f"/proc/{pid}/stat").exists()] == []


@pytest.mark.slow
def test_what_cannot_be_sent_is_said_at_once() -> None:
    lock = Lock()
    with pytest.raises(CallerError, match="cannot be sent"):
        of_numbers(lambda _: lock.locked(), workers=2)
