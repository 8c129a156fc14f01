"""Whatever is still open when Python ends is switched off, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from tests.places import CHECKOUT

SCRIPT = """
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
        [sys.executable, "-c", SCRIPT.format(paced=paced, end=end)],
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert "off" in done.stdout.splitlines(), done.stderr
