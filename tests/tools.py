"""Programs that some tests need and pip cannot install: compilers and emulators.

Without one a test is reported as not run, with the line that installs it; where ``MUSCLEWIRE_REQUIRE_TOOLS=1`` is
set, as in CI, it fails instead, so that nothing is left out there unnoticed.
"""

from __future__ import annotations

import os
import shutil

import pytest

__all__ = ["require_tool"]


def require_tool(program: str, packages: str) -> str:
    """Return the path of a program; without it skip the test (or fail it in CI) with the apt line of ``packages``."""
    path = shutil.which(program)
    if path is not None:
        return path
    line = f"not run: {program} is missing: apt-get install --no-install-recommends -y {packages}"
    if os.environ.get("MUSCLEWIRE_REQUIRE_TOOLS") == "1":
        pytest.fail(line, pytrace=False)
    pytest.skip(line)
