"""What importing the room costs."""

from __future__ import annotations

import subprocess
import sys


def test_importing_controllers_loads_neither_numba_nor_matplotlib() -> None:
    code = "import sys, musclewire.controllers; print('numba' in sys.modules, 'matplotlib' in sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.split() == ["False", "False"]
