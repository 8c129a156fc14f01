"""A command as a process of its own, and the signals that interrupt it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

__all__ = ["ONE_IN_CI", "PATIENCE_S", "SIGNALS", "start"]

PATIENCE_S = 120.0  # a cold machine compiles first
SIGNALS = [(signal.SIGINT, 130), (signal.SIGTERM, 143)]
# What one handler makes of both: one of them in CI.
ONE_IN_CI = [
    pytest.param(signal.SIGINT, 130, marks=pytest.mark.slow),
    pytest.param(signal.SIGTERM, 143, marks=pytest.mark.full),
]


def start(*arguments: object) -> subprocess.Popen[str]:
    """Start a command; what it prints is read by its caller."""
    command = [sys.executable, "-m", "musclewire", *map(str, arguments)]
    return subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "NO_COLOR": "1"},
    )
