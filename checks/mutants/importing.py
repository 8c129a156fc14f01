"""Imports one module from another text than its file's: in this process, and in those that it starts."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType

__all__ = ["SITE", "install", "install_of_parent", "module_name"]

# Names a file with the mutant, for processes that a test starts.
VARIABLE = "MUSCLEWIRE_MUTANT"
# What Python imports when it starts, if it is on the path.
SITE = """import os

if os.environ.get("MUSCLEWIRE_MUTANT"):
    from checks.mutants.importing import install_of_parent

    install_of_parent()
"""


class MutatedLoader(importlib.machinery.SourceFileLoader):
    """Loads a module from another text than its file's."""

    def __init__(self, name: str, path: str, text: str) -> None:
        """Take the module's name, its file and the text."""
        super().__init__(name, path)
        self._text = text

    def get_code(self, _fullname: str) -> CodeType:
        """Compile the text, never the cached code of the file."""
        return compile(self._text, self.path, "exec", dont_inherit=True)


class MutatedFinder:
    """Finds one module, to be loaded from another text."""

    def __init__(self, path: str, text: str) -> None:
        """Take the module's file, from the copy of the tree, and the text."""
        self._name, self._path, self._text = module_name(path), str(Path(path).resolve()), text

    def find_spec(
        self, name: str, _path: Sequence[str] | None = None, _target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return how to load the module, None for any other."""
        if name != self._name:
            return None
        folder = [str(Path(self._path).parent)] if self._path.endswith("__init__.py") else None
        loader = MutatedLoader(name, self._path, self._text)
        return importlib.util.spec_from_file_location(
            name, self._path, loader=loader, submodule_search_locations=folder
        )


def module_name(path: str) -> str:
    """Return the name by which a file below src is imported."""
    parts = Path(path).with_suffix("").parts
    parts = parts[parts.index("src") + 1 :]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def install(path: str, text: str, note: Path) -> None:
    """Import a file's module from another text from now on; ``note`` carries it to processes that are started."""
    note.write_text(json.dumps([str(Path(path).resolve()), text]), encoding="utf-8")
    os.environ[VARIABLE] = str(note)
    sys.meta_path.insert(0, MutatedFinder(path, text))  # type: ignore[arg-type]


def install_of_parent() -> None:
    """Do as the process does that has started this one."""
    path, text = json.loads(Path(os.environ[VARIABLE]).read_text(encoding="utf-8"))
    sys.meta_path.insert(0, MutatedFinder(path, text))  # type: ignore[arg-type]
