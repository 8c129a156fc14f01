"""Run the tests on a copy of the checkout from which extras have been deleted: what is left must not miss them.

    python checks/without_extras.py [EXTRA ...] [--quick] [-- PYTEST_OPTIONS]

Without names all extras go, and with them ``tests/extras``: the core's tests and the demo of the README must pass. With
names each of these is deleted alone, one after the other, with those that import it (``ARROWS``), and the tests of the
core and of all other extras run. ``tests/house``, which is about the whole checkout, and what else the checkout has
beside the package stay out of it. ``--quick`` runs the demo and one test file of each folder. Exit code 1 if anything
fails.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
EXTRAS = ROOT / "src" / "musclewire" / "extras"
# Which extra needs which: by imports, as ARCHITECTURE.md draws and pyproject.toml holds them, or by name, as studies
# compare the particle filter.
ARROWS = {"design": ("paper",), "board": ("interfaces",), "particles": ("studies",)}
# What a copy has: what the tests of one part or another read.
COPIED = (
    *("src", "tests", "examples", "benchmarks", "checks", "docs", "emulation", "firmware", "hardware", "studies"),
    *("pyproject.toml", "README.md", "LICENSE"),
)
ABOUT_THE_WHOLE = "tests/house"
# Files that are named run whole, their long tests too, unless these are left out.
NO_LONG_TESTS = "not (slow or emulated or documented or browser)"


def without(names: Sequence[str], folder: Path) -> Path:
    """Return a copy of the checkout in a folder, some extras deleted with their tests."""
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, folder / name)
    for place in ("src/musclewire/extras", "tests/extras"):
        for name in names:
            shutil.rmtree(folder / place / name, ignore_errors=True)
    if set(names) == set(extras()):
        shutil.rmtree(folder / "src/musclewire/extras")
        shutil.rmtree(folder / "tests/extras", ignore_errors=True)
    shutil.rmtree(folder / ABOUT_THE_WHOLE)
    return folder


def extras() -> list[str]:
    """Return the names of all extras."""
    return sorted(path.parent.name for path in EXTRAS.glob("*/manifest.py"))


def run(folder: Path, *command: str) -> bool:
    """Run a command of this Python in a copy, with the copy's own sources; return whether it ended well."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder / "src"), str(folder)])}
    print(f"$ {' '.join(command)}", flush=True)
    return (
        subprocess.run([sys.executable, "-P", "-m", *command], cwd=folder, env=environment, check=False).returncode == 0
    )


def quick_selection(folder: Path) -> list[str]:
    """Return one test file of each folder of tests."""
    chosen = {path.parent: path for path in sorted((folder / "tests").rglob("test_*.py"), reverse=True)}
    return [str(path.relative_to(folder)) for path in sorted(chosen.values())]


def passes(names: Sequence[str], quick: bool, options: Sequence[str]) -> bool:
    """Return whether the copy without some extras passes its tests, and without any the demo."""
    with tempfile.TemporaryDirectory(prefix="without-extras-") as place:
        folder = without(names, Path(place) / "musclewire")
        print(f"== without {', '.join(names)}", flush=True)
        demo = run(folder, "musclewire", "demo", "--out", "demo") if set(names) == set(extras()) else True
        selected = [*quick_selection(folder), "-m", NO_LONG_TESTS] if quick else []
        return run(folder, "pytest", "-q", "-n", "auto", "--dist", "worksteal", *options, *selected) and demo


def main() -> int:
    """Run what is asked for; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("extras", nargs="*", metavar="EXTRA", help="delete this one alone; 'each' is all, one by one")
    parser.add_argument("--quick", action="store_true", help="one test file of each folder")
    known, options = parser.parse_known_args()
    chosen = extras() if known.extras == ["each"] else known.extras
    wrong = set(chosen) - set(extras())
    if wrong:
        parser.error(f"there is no extra {', '.join(sorted(wrong))}; there are {', '.join(extras())}")
    cases = [(name, *ARROWS.get(name, ())) for name in chosen] or [tuple(extras())]
    failed = [
        case[0] if len(cases) > 1 else ", ".join(case) for case in cases if not passes(case, known.quick, options)
    ]
    print(f"failed without: {'; '.join(failed)}" if failed else "all tests that are left pass")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
