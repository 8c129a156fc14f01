"""What draws a progress bar is loaded before the first sample: a board does not wait for the host to import it."""

from __future__ import annotations

import subprocess
import sys

import pytest

SCRIPT = """
import sys
from io import StringIO
from rich.console import Console
from musclewire.app import _output as output

shown = StringIO()
output.console = lambda: Console(file=shown, force_terminal={terminal}, width=80)
with output.progress_bar("Closed loop", 10.0) as on_sample:
    assert not shown.getvalue()
    before = set(sys.modules)
    on_sample({{"time_s": 0.05}})
    on_sample({{"time_s": 0.10}})
    imported = sorted(set(sys.modules) - before)
print(imported)
"""


@pytest.mark.parametrize("terminal", [True, False], ids=["a terminal", "a pipe"])
def test_the_first_samples_import_nothing(terminal: bool) -> None:
    script = SCRIPT.format(terminal=terminal)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
