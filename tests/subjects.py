"""What a suite runs over, collected from files beside it and from folders that add to it.

A suite of tests in tests/FOLDER, as the contract of all rigs, takes its subjects from modules by a pattern of their
names, in tests/FOLDER, in every tests/extras/NAME/FOLDER and in every packages/NAME/tests/FOLDER. Whoever deletes a
folder takes its subjects away; a module that is there and cannot be imported is an error.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from tests.places import CHECKOUT

__all__ = ["subjects_of"]


def subjects_of(folder: str, pattern: str, name: str) -> list[Any]:
    """Return what all modules of a suite list under a name, in the order of their paths."""
    places = (f"tests/{folder}", f"tests/extras/*/{folder}", f"packages/*/tests/{folder}")
    found = [path for place in places for path in sorted(CHECKOUT.glob(f"{place}/{pattern}"))]
    modules = [".".join(path.relative_to(CHECKOUT).with_suffix("").parts) for path in found]
    return [subject for module in modules for subject in getattr(import_module(module), name)]
