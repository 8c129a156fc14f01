"""What some tests need beside README's second command: compilers, emulators and browsers, and the extra ``oracles``.

Without one a test is reported as not run, with the line that installs it; where ``MUSCLEWIRE_REQUIRE_TOOLS=1`` is
set, as in CI, it fails instead, so that nothing is left out there unnoticed. And what takes long to make is made once
for all processes of a run.
"""

from __future__ import annotations

import importlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import pytest

__all__ = ["made_once", "require_oracle", "require_package", "require_tool"]


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


def made_once(folders: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """Return a folder that ``make`` has filled, once for all processes of this run: whoever comes second waits."""
    import fcntl

    own = folders.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    folder, whole = shared / f"{name}-made-once", shared / f"{name}-is-whole"
    with (shared / f"{name}-lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not whole.exists():
            shutil.rmtree(folder, ignore_errors=True)  # of a process whose ``make`` has failed
            folder.mkdir()
            make(folder)
            whole.touch()
    return folder


def not_run(reason: str) -> NoReturn:
    """Skip, saying what is missing; in CI, fail."""
    __tracebackhide__ = True
    line = f"not run: {reason}"
    if os.environ.get("MUSCLEWIRE_REQUIRE_TOOLS") == "1":
        pytest.fail(line, pytrace=False)
    pytest.skip(line, allow_module_level=True)
