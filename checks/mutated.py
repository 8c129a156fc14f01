"""pytest plugin of checks/mutation.py: one module has another text, or what each test takes is written down.

A module is changed in memory, while it is imported, and not on disk: an edit of a file with kernels would make Numba
compile all of them again, a minute for each mutant.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

VARIABLE = "MUTATED"  # file that is changed, and the file that has its text, with os.pathsep between
DURATIONS = "DURATIONS"  # file to which durations are written


class Changed(importlib.machinery.SourceFileLoader):
    """Loads a module with another text than its file has."""

    def __init__(self, name: str, path: str, text: Path) -> None:
        """Take the text from a file."""
        super().__init__(name, path)
        self.text = text

    def get_code(self, _: str) -> CodeType:
        """Compile the other text."""
        return compile(self.text.read_text("utf-8"), self.path, "exec", dont_inherit=True)


class Finder(importlib.abc.MetaPathFinder):
    """Finds the changed module where Python would find it, with the other loader."""

    def __init__(self, path: str, text: Path) -> None:
        """Change the module of a file."""
        self.path, self.text = path, text

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> Any:
        """Return the changed module's specification, None for any other."""
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is None or spec.origin is None or Path(spec.origin) != Path(self.path):
            return None
        spec.loader = Changed(name, spec.origin, self.text)
        return spec


durations: dict[str, float] = {}


def pytest_runtest_logreport(report: Any) -> None:
    """Add up what a test takes; one that fails judges nothing."""
    durations[report.nodeid] = durations.get(report.nodeid, 0.0) + (report.duration if report.passed else float("inf"))


def pytest_sessionfinish() -> None:
    """Write down what the tests took."""
    if DURATIONS in os.environ and "PYTEST_XDIST_WORKER" not in os.environ:
        Path(os.environ[DURATIONS]).write_text(json.dumps(durations), "utf-8")


if VARIABLE in os.environ:
    changed_path, _, changed_text = os.environ[VARIABLE].partition(os.pathsep)
    sys.meta_path.insert(0, Finder(changed_path, Path(changed_text)))
