"""What is kept of a wire's temperature in real files, by real processes that are killed, and by more than one user."""

from __future__ import annotations

import gc
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.places import CHECKOUT
from tests.unit.rigs.remembered_wire import AMBIENT_K, BOARD, LIMIT_K, LIMITS, NOW, REST_S, later

from musclewire.rigs._remembered_temperature import (
    KeptFile,
    RememberedTemperature,
    WireTemperature,
    opened,
    parsed_temperature,
    text_of,
)

pytestmark = pytest.mark.slow
posix = pytest.mark.skipif(sys.platform == "win32", reason="kill -9, fork and file modes are POSIX's")

# Forks, so that imports are paid for once: each child writes without a pause until it is killed.
WRITES_AND_DIES = """
import os, random, signal, sys, time
from musclewire.rigs._remembered_temperature import KeptFile, Moment, WireTemperature, text_of
board, kills, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
draw = random.Random(seed)
kept = KeptFile(board)
for kill in range(kills):
    child = os.fork()
    if not child:
        while True:
            kept.write(text_of(board, WireTemperature(300.0 + kill, Moment("b", 4e3, 0.0))))
    time.sleep(draw.uniform(0.0, 0.02))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    print(kept.path().read_text() if kept.path().exists() else "", end="\\n", flush=True)
"""
NOTES = """
import sys, time
from tests.unit.rigs.remembered_wire import BOARD, LIMITS
from musclewire.rigs._remembered_temperature import RememberedTemperature
remembered = RememberedTemperature(BOARD, LIMITS)
while True:
    remembered.note(400.0)
    time.sleep(0.01)
"""
OPENS = """
import os, sys
from tests.unit.rigs.remembered_wire import BOARD, LIMITS, NOW
from musclewire.rigs._remembered_temperature import KeptFile, opened
if len(sys.argv) > 1:
    os.setuid(int(sys.argv[1]))
print(*opened(BOARD, LIMITS, KeptFile(BOARD), NOW), sep="|")
"""


def command(program: str, *arguments: object) -> list[str]:
    return [sys.executable, "-c", program, *map(str, arguments)]


def until(true: Callable[[], bool]) -> None:
    """Wait for what must come; the bound is generous."""
    ends = time.monotonic() + 60.0
    while not true():
        assert time.monotonic() < ends
        time.sleep(0.01)


@posix
def test_a_file_is_whole_whenever_its_writer_is_killed_and_parts_are_gone_after_the_next_opening() -> None:
    done = subprocess.run(command(WRITES_AND_DIES, BOARD, 200, 7), capture_output=True, text=True, check=True)
    found = [line for line in done.stdout.splitlines() if line]
    assert len(found) > 100
    temperatures_k = [parsed_temperature(line, BOARD).temperature_k for line in found]
    assert all(300.0 <= one <= 499.0 for one in temperatures_k)
    assert len(set(temperatures_k)) > 50
    kept = KeptFile(BOARD)
    parts = [file for file in kept.path().parent.iterdir() if file != kept.path()]
    assert parts, "no child was killed in the middle of a write"
    assert opened(BOARD, LIMITS, kept, NOW._replace(boot="b")).rest_s == 0.0
    assert list(kept.path().parent.iterdir()) == [kept.path()]


@posix
def test_the_thread_keeps_what_a_killed_program_has_noted() -> None:
    def is_kept() -> bool:
        return kept.path().exists() and parsed_temperature(kept.path().read_text("utf-8"), BOARD).temperature_k >= 400.0

    kept = KeptFile(BOARD)
    with subprocess.Popen(command(NOTES), cwd=CHECKOUT) as program:
        until(is_kept)
        program.kill()
    stored = parsed_temperature(kept.path().read_text("utf-8"), BOARD)
    assert 400.0 <= opened(BOARD, LIMITS, kept, stored.moment).temperature_k <= LIMIT_K


def test_a_second_opening_finds_what_the_first_one_left() -> None:
    first = RememberedTemperature(BOARD, LIMITS, clock=lambda: NOW)
    first.note(430.0)
    first.close()
    second = RememberedTemperature(BOARD, LIMITS, clock=lambda: NOW)
    second.close()
    assert second.at_opening.temperature_k == pytest.approx(430.0)
    third = RememberedTemperature(BOARD, LIMITS, clock=lambda: later(0.9))
    third.close()
    assert third.at_opening.temperature_k == pytest.approx(AMBIENT_K + (430.0 - AMBIENT_K) * 0.36788, abs=1e-2)
    assert RememberedTemperature("another board", LIMITS, clock=lambda: NOW).at_opening.temperature_k == LIMIT_K


def test_a_program_that_closes_nothing_leaves_no_thread() -> None:
    remembered = RememberedTemperature(BOARD, LIMITS)
    remembered.note(400.0)
    thread = remembered._thread
    del remembered
    gc.collect()
    thread.join(60.0)
    assert not thread.is_alive()
    assert json.loads(KeptFile(BOARD).path().read_text("utf-8"))["temperature_k"] == 400.0


def test_two_users_have_two_folders_and_neither_sees_the_others_wire(tmp_path: Path) -> None:
    answers = []
    for user, temperature_k in (("one", 400.0), ("other", 420.0)):
        folder = tmp_path / user
        KeptFile(BOARD, folder).write(text_of(BOARD, WireTemperature(temperature_k, NOW)))
        environment = {**os.environ, "MUSCLEWIRE_STATE_HOME": str(folder)}
        done = subprocess.run(command(OPENS), env=environment, cwd=CHECKOUT, capture_output=True, text=True, check=True)
        answers.append(done.stdout.strip())
    assert [answer.split("|")[1:] for answer in answers] == [["0.0", "None"]] * 2
    assert [float(answer.split("|")[0]) for answer in answers] == pytest.approx([400.0, 420.0])


@posix
def test_in_a_folder_of_two_users_the_file_that_may_not_be_read_counts_as_the_limit_and_stays() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        kept = KeptFile(BOARD, folder)
        kept.write(text_of(BOARD, WireTemperature(300.0, NOW)))
        text = kept.path().read_text("utf-8")
        for path, mode in ((kept.path(), 0o000), (kept.path().parent, 0o555), (folder, 0o755)):
            path.chmod(mode)
        environment = {**os.environ, "MUSCLEWIRE_STATE_HOME": name}
        as_other = [65534] if os.geteuid() == 0 else []  # root may read everything: the program becomes nobody
        answer = subprocess.run(
            command(OPENS, *as_other), env=environment, cwd=CHECKOUT, capture_output=True, text=True, check=True
        )
        for path, mode in ((kept.path().parent, 0o755), (kept.path(), 0o600)):
            path.chmod(mode)
        assert kept.path().read_text("utf-8") == text
    temperature_k, rest_s, reason = answer.stdout.strip().split("|")
    assert (float(temperature_k), float(rest_s)) == (LIMIT_K, pytest.approx(REST_S))
    assert reason.count("ermission denied") == 2
    assert "cannot be read" in reason
    assert "cannot be kept" in reason


def test_a_folder_in_the_place_of_the_file_and_a_file_in_the_place_of_the_folder(tmp_path: Path) -> None:
    kept = KeptFile(BOARD)
    kept.path().mkdir(parents=True)
    found = opened(BOARD, LIMITS, kept, NOW)
    assert (found.temperature_k, found.rest_s) == (LIMIT_K, pytest.approx(REST_S))
    (tmp_path / "file").write_text("", "utf-8")
    found = opened(BOARD, LIMITS, KeptFile(BOARD, tmp_path / "file"), NOW)
    assert (found.temperature_k, found.rest_s) == (LIMIT_K, pytest.approx(REST_S))
    assert "cannot be kept" in str(found.reason)


def test_random_bytes_are_no_temperature_below_the_limit(tmp_path: Path) -> None:
    draw, kept = random.Random(3), KeptFile(BOARD, tmp_path)
    kept.path().parent.mkdir()
    for _ in range(300):
        kept.path().write_bytes(draw.randbytes(draw.randrange(200)))
        assert opened(BOARD, LIMITS, kept, NOW)[:2] == (LIMIT_K, pytest.approx(REST_S))
