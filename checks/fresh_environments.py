"""Virtual environments made for one check: nothing of this checkout is on their path, and they go when it ends."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Environment", "built", "fresh_environment"]

ROOT = Path(__file__).resolve().parents[1]
# What would let an environment see the checkout, or another environment's packages or compiled kernels.
LEFT_OUT = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME")


@dataclass(frozen=True)
class Environment:
    """A virtual environment, and the empty folder in which its programs run."""

    folder: Path
    work: Path

    @property
    def programs(self) -> Path:
        """The folder of its programs."""
        return self.folder / ("Scripts" if sys.platform == "win32" else "bin")

    def run(self, program: str, *arguments: str, code: int | None = 0) -> subprocess.CompletedProcess[str]:
        """Run one of its programs; raises SystemExit with what was said if it ends with another code."""
        done = subprocess.run(
            [str(self.programs / program), *arguments],
            cwd=self.work,
            env=outside(),
            capture_output=True,
            text=True,
            check=False,
        )
        if code is not None and done.returncode != code:
            sys.exit(f"FAIL: {program} {' '.join(arguments)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
        return done

    def install(self, *what: str) -> None:
        """Install packages."""
        self.run("python", "-m", "pip", "install", "-q", *what)


def outside() -> dict[str, str]:
    """Return this process's variables without those that lead back to the checkout."""
    kept = {name: value for name, value in os.environ.items() if name not in LEFT_OUT}
    return {**kept, "MPLBACKEND": "Agg"}


def fresh_environment(folder: Path, python: Sequence[str] = (sys.executable,)) -> Environment:
    """Return a new virtual environment in a folder, and a work folder beside it."""
    work = folder / "work"
    work.mkdir(parents=True)
    subprocess.run([*python, "-m", "venv", str(folder / "environment")], check=True, env=outside())
    return Environment(folder / "environment", work)


def built(into: Path, *options: str) -> list[Path]:
    """Build the package by ``python -m build`` in an environment of the build's own, and return the files."""
    command = [sys.executable, "-m", "build", *options, "--outdir", str(into), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, env=outside(), check=False)
    if done.returncode:
        sys.exit(f"FAIL: {' '.join(command)}\n{done.stdout}{done.stderr}")
    return sorted(into.iterdir())
