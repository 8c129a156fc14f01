"""An output that takes no more, by a full disk or a reader that has left, ends a command by a line at most."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not Path("/dev/full").exists(), reason="Linux has /dev/full")]


@pytest.mark.parametrize("words", [["catalogue"], ["catalogue", "--json"], ["--help"], ["--version"]])
def test_a_full_stdout_is_one_line_and_no_traceback(words: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "musclewire", *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert ended.returncode == 1
    (line,) = (line for line in ended.stderr.splitlines() if "compil" not in line)  # as on a new machine
    assert line.startswith("musclewire: the result cannot be written to stdout: No space left on device")


def test_a_reader_that_has_left_is_not_told_so() -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "musclewire", "catalogue"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        assert process.stderr.read() == ""
    assert process.returncode == 1
