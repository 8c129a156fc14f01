"""Where the checkout has what tests read, wherever a test itself lies."""

from __future__ import annotations

from pathlib import Path

__all__ = ["BENCHMARKS", "CHECKOUT", "DOCS", "EXAMPLES", "PACKAGE", "TESTS", "included_rig_file"]


def checkout_around(path: Path) -> Path:
    """Return the nearest folder around a path that has a pyproject.toml."""
    return next(folder for folder in path.parents if (folder / "pyproject.toml").is_file())


CHECKOUT = checkout_around(Path(__file__).resolve())
BENCHMARKS = CHECKOUT / "benchmarks"
DOCS = CHECKOUT / "docs"
EXAMPLES = CHECKOUT / "examples"
PACKAGE = CHECKOUT / "src" / "musclewire"
TESTS = CHECKOUT / "tests"


def included_rig_file(name: str) -> Path:
    """Return the file of a rig that comes with musclewire, in whichever folder of the package it lies."""
    (found,) = (path for path in PACKAGE.rglob(f"{name}.toml") if path.parent.name in ("rigs", "rig_files"))
    return found
