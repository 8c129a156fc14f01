"""A board switches off if it hears nothing for 0.25 s: no module is loaded from the first sample to the last."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import sys
from musclewire.app._main import run
from musclewire.rigs import GuardedRig

exchange, loaded = GuardedRig.exchange, []

def watched(rig, command):
    loaded.append(set(sys.modules))
    return exchange(rig, command)

GuardedRig.exchange = watched
run(sys.argv[1:])
print(sorted(set().union(*loaded) - loaded[0]), len(loaded) > 100)
"""


@pytest.mark.parametrize("options", ["doctor", "characterize --cycles 1 -o loop.h5"])
def test_the_samples_of_a_command_load_nothing(options: str, tmp_path: Path) -> None:
    command, *others = options.split()
    given = [sys.executable, "-c", SCRIPT, command, "simulated", *others]
    done = subprocess.run(given, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[] True"
