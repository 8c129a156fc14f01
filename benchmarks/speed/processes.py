"""The first step of a new process: Python starts, what is needed is imported, kernels come from the cache."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

__all__ = ["first_period_of_ours", "first_period_of_scipy"]

# From here the new process finds this folder.
ROOT = Path(__file__).resolve().parents[2]

OURS = """
from benchmarks.speed.our_wire import one_period, paper_wire
from musclewire.wire._building import resting_state
wire = paper_wire()
one_period(resting_state(wire), wire, 1.0, 0.01)
"""
THEIRS = """
from benchmarks.speed.easier_wire import ScipyLoop
ScipyLoop(0.01).advance(1.0)
"""


def process(program: str) -> Callable[[object], object]:
    """Return a call that runs a program in a new process of this Python. Its error is raised if it fails."""
    return lambda _: subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, cwd=ROOT)


def first_period_of_ours() -> Callable[[object], object]:
    """Return a call that starts a process, advances the simulated wire by one period, and ends."""
    return process(OURS)


def first_period_of_scipy() -> Callable[[object], object]:
    """Return a call that starts a process, advances the easier wire by one period of SciPy's, and ends."""
    return process(THEIRS)
