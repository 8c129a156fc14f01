"""What some tests need beside README's second command: compilers, emulators and browsers, and the extra ``oracles``.

Without one a test is reported as not run, with the line that installs it; where ``MUSCLEWIRE_REQUIRE_TOOLS=1`` is
set, as in CI, it fails instead, so that nothing is left out there unnoticed.
"""

from __future__ import annotations

import importlib
import os
import shutil
from typing import Any, NoReturn

import pytest

__all__ = ["require_oracle", "require_package", "require_tool"]


def require_tool(program: str, packages: str) -> str:
    """Return the path of a program; without it skip the test (or fail it in CI) with the apt line of ``packages``."""
    __tracebackhide__ = True  # reports name the test's file, and not this one
    path = shutil.which(program)
    if path is None:
        not_run(f"{program} is missing: apt-get install --no-install-recommends -y {packages}")
    return path


def require_oracle(module: str) -> Any:
    """Return a module of the extra ``oracles``; without it skip the test, or all of a test's file that asks for it."""
    __tracebackhide__ = True
    return require_package(module, 'pip install ".[oracles]"')


def require_package(module: str, install: str) -> Any:
    """Return a module; without it skip the test, or all of a test's file that asks for it, with what installs it."""
    __tracebackhide__ = True
    try:
        return importlib.import_module(module)
    except ImportError:
        not_run(f"{module} is missing: {install}")


def not_run(reason: str) -> NoReturn:
    """Skip, saying what is missing; in CI, fail."""
    __tracebackhide__ = True
    line = f"not run: {reason}"
    if os.environ.get("MUSCLEWIRE_REQUIRE_TOOLS") == "1":
        pytest.fail(line, pytrace=False)
    pytest.skip(line, allow_module_level=True)
