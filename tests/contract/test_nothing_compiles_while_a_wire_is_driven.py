"""All that a rig runs is compiled before its drive leaves 0 V: a pause of seconds would find a wire hot and alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from tests.contract.late_compilations import JOBS, RIGS
from tests.places import CHECKOUT

PROGRAM = Path(__file__).with_name("late_compilations.py")
EVERY = [*((rig, "drive") for rig in RIGS), *(("simulated", job) for job in JOBS if job != "drive")]
QUICKLY = (("simulated", "drive"), ("simulated", "characterize"))
CASES = [pytest.param(*case, marks=pytest.mark.slow if case in QUICKLY else pytest.mark.full) for case in EVERY]


def output_of(*arguments: str, cache: Path | None = None) -> str:
    """Run the program, with a kernel cache of its own if one is named, and return what it prints."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(CHECKOUT), *sys.path])}
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    done = subprocess.run(
        [sys.executable, str(PROGRAM), *arguments], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder without a kernel cache, and with a loop and a model that were made with the cache of all tests."""
    folder = tmp_path_factory.mktemp("compiled")
    output_of("model", str(folder))
    return folder


@pytest.mark.parametrize(("rig", "job"), CASES)
def test_nothing_compiles_once_the_drive_has_left_0_v(rig: str, job: str, prepared: Path) -> None:
    assert json.loads(output_of(rig, job, str(prepared), cache=prepared / "cache")) == []
