"""The first run says that it compiles, once, and for how long; what the cache holds is not compiled again."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest


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
