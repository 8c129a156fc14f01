from __future__ import annotations

import os
import sys
from pathlib import Path

# As the command line has it: BLAS on several threads only waits for itself. Before anything loads NumPy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from hypothesis import settings
from tests.browser.chromium import browser, playwright
from tests.command_line import musclewire

sys.path.insert(0, str(Path(__file__).parent))  # for groups and grain_wire

from groups import pytest_addoption, pytest_configure

__all__ = ["browser", "musclewire", "playwright", "pytest_addoption", "pytest_configure"]

# The first call of a compiled function takes seconds, and a busy machine is no defect: no deadlines. The same examples
# every time, so that a red run can be repeated.
settings.register_profile("musclewire", deadline=None, derandomize=True)
settings.load_profile("musclewire")
