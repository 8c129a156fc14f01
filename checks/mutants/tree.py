"""The copy of the working tree that is measured and judged; the working tree itself is never changed."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from checks.mutants.importing import SITE

__all__ = ["copied_tree", "environment_of"]

# What the tests that judge read.
COPIED = ("src", "tests", "checks", "emulation", "firmware", "examples", "docs", "studies", "benchmarks",
          "pyproject.toml", "README.md")  # fmt: skip


def copied_tree(root: Path, tree: Path) -> Path:
    """Bring a copy up to date with the files that git knows or would add; a file that is the same stays untouched."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", *COPIED],
        cwd=root,
        capture_output=True,
        text=True,
        check=True,
    )
    names = {name for name in listed.stdout.split("\0") if name and (root / name).is_file()}
    for old in [path for path in tree.rglob("*") if path.is_file() and "__pycache__" not in path.parts]:
        if str(old.relative_to(tree)) not in names:
            old.unlink()
    for name in sorted(names):
        target = tree / name
        if not target.is_file() or target.read_bytes() != (root / name).read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(root / name, target)
    return tree


def environment_of(mode: str, tree: Path) -> dict[str, str]:
    """Return the environment of a process that runs tests of the copy, with compilation on or off."""
    site = tree.parent / "site"
    site.mkdir(exist_ok=True)
    (site / "sitecustomize.py").write_text(SITE, encoding="utf-8")
    paths = os.pathsep.join([str(site), str(tree / "src"), str(tree)])
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
    jit = {"NUMBA_DISABLE_JIT": "1" if mode == "plain" else "0"}
    return {**os.environ, **threads, **jit, "PYTHONPATH": paths, "PYTHONHASHSEED": "0", "MPLBACKEND": "Agg"}
