"""What all tests share, those of tests/ and those of packages/: fixtures, groups, a folder for what they keep."""

from __future__ import annotations

import atexit
import gc
import os
import shutil
import sys
import tempfile
from collections.abc import Generator
from itertools import count
from pathlib import Path

# As the command line has it: BLAS on several threads only waits for itself. Before anything loads NumPy.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings
from tests.browser.chromium import browser, playwright
from tests.command_line import musclewire

sys.path.insert(0, str(Path(__file__).parent / "tests"))  # for groups and grain_wire

from groups import pytest_addoption, pytest_configure
from musclewire.errors import MusclewireError

__all__ = ["browser", "musclewire", "playwright", "pytest_addoption", "pytest_configure"]

# Nothing of a test is kept in the user's own folder; processes that tests start inherit it, those of xdist, too.
KEPT = Path(os.environ["MUSCLEWIRE_STATE_HOME"]) if "PYTEST_XDIST_WORKER" in os.environ else None
if KEPT is None:
    KEPT = Path(tempfile.mkdtemp(prefix="musclewire-kept-"))
    os.environ["MUSCLEWIRE_STATE_HOME"] = str(KEPT)
    atexit.register(shutil.rmtree, KEPT, ignore_errors=True)
NUMBERS = count()

# The first call of a compiled function takes seconds, and a busy machine is no defect: no deadlines. The same examples
# every time, so that a red run can be repeated.
settings.register_profile("musclewire", deadline=None, derandomize=True)
settings.load_profile("musclewire")


def said_in_one_line(error: MusclewireError, *arguments: object) -> None:
    """Make an error of musclewire, and fail the test in which one says what is wrong in more than a line."""
    super(MusclewireError, error).__init__(*arguments)
    assert "\n" not in str(error)


MusclewireError.__init__ = said_in_one_line  # type: ignore[method-assign]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no garbage while tests are collected, nor later among what that has made: all of it stays to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_runtest_setup() -> None:
    """Give each test a folder of its own: a port's number comes again, and the wire behind it is another one."""
    os.environ["MUSCLEWIRE_STATE_HOME"] = str(KEPT / f"{os.getpid()}-{next(NUMBERS)}")
