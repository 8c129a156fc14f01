"""Whether musclewire runs with each Python that it claims to run with, in an environment of each one's own.

    python -m checks.pythons                        with every interpreter that is found
    python -m checks.pythons --only 3.13            with one of them
    python -m checks.pythons --system /srv/sid      with that of a system in a folder, too, by chroot

Builds the package once. With each Python it installs the wheel with the extra `test`, runs the demo, a fit and what
`--version` says, and then the short suite: the tests of SUITE, from the sdist and not from the checkout, on all cores.
A system in a folder is made by `debootstrap --include=python3-venv sid /srv/sid`, with /proc and /dev mounted in it.
Exit code 1 if something fails; which Pythons of pyproject.toml were not found is said at the end.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from dataclasses import dataclass
from pathlib import Path

from checks.fresh_environments import ROOT, built, outside

# Rooms whose tests touch most of what differs between Pythons and versions of packages: files, compiled kernels,
# command line. Those in a group are left out, as in a run without names; the demo before them is the loop.
GROUPS = "not slow and not emulated and not documented and not browser"
SUITE = (
    *("tests/unit/signals", "tests/unit/sensing", "tests/unit/controllers", "tests/unit/parameters", "tests/unit/wire"),
    *("tests/extras/interfaces/unit", "tests/house/test_json_schemas.py", "tests/house/test_files_of_releases.py"),
    *("tests/app/test_version.py", "tests/app/test_completion.py", "tests/app/test_import.py"),
)


@dataclass(frozen=True)
class Interpreter:
    """A Python: its version, its program, and the folder of its system if that is not this one."""

    version: str
    program: str
    system: Path | None = None

    def command(self, folder: Path, *words: str) -> list[str]:
        """Return a command that runs in a folder, both as this system sees them."""
        if self.system is None:
            return list(words)
        inside = [
            f"/{Path(word).relative_to(self.system)}" if word.startswith(f"{self.system}/") else word for word in words
        ]
        return [
            "chroot",
            str(self.system),
            "sh",
            "-c",
            'cd "$0" && exec "$@"',
            f"/{folder.relative_to(self.system)}",
            *inside,
        ]

    def run(self, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
        """Run a command in a folder."""
        variables = outside()
        if self.system is not None:  # paths of this system mean nothing in that one
            variables = {name: variables[name] for name in ("LANG", "PIP_DEFAULT_TIMEOUT") if name in variables}
            variables |= {"PATH": "/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin", "HOME": "/root", "MPLBACKEND": "Agg"}
        return subprocess.run(
            self.command(folder, *words), cwd=folder, env=variables, capture_output=True, text=True, check=False
        )


def claimed() -> list[str]:
    """Return the versions of Python that pyproject.toml lists."""
    return re.findall(r"Programming Language :: Python :: (3\.\d+)", (ROOT / "pyproject.toml").read_text("utf-8"))


def candidates(version: str) -> list[str]:
    """Return programs that may be a version of Python: on the path, and installed by pyenv."""
    on_path = shutil.which(f"python{version}")
    own = sys.executable if sys.version.startswith(f"{version}.") else None
    pyenv = sorted(Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")).glob(f"versions/{version}.*/bin/python"))
    return [program for program in (own, *map(str, reversed(pyenv)), on_path) if program]


def version_of(program: str, system: Path | None = None) -> str:
    """Return the version of a program, as 3.13; "" if it does not run or cannot make environments."""
    code = "import sys, venv, ensurepip; print('%d.%d' % sys.version_info[:2])"
    done = Interpreter("", program, system).run(system or ROOT, program, "-c", code)
    return done.stdout.strip() if done.returncode == 0 else ""


def found_interpreters(systems: list[Path]) -> dict[str, Interpreter]:
    """Return one interpreter for each version that is claimed and found."""
    found: dict[str, Interpreter] = {}
    for version in claimed():
        for program in candidates(version):
            if version not in found and version_of(program) == version:
                found[version] = Interpreter(version, program)
    for system in systems:
        version = version_of("/usr/bin/python3", system)
        if version in claimed():
            found.setdefault(version, Interpreter(version, "/usr/bin/python3", system))
    return found


def judge(interpreter: Interpreter, wheel: Path, sdist: Path) -> str:
    """Return "" if a Python runs everything, else what failed; what it runs is printed."""
    base = interpreter.system / "tmp" if interpreter.system else None
    with tempfile.TemporaryDirectory(prefix="musclewire-python-", dir=base) as name:
        folder = Path(name)
        copy = shutil.copy(wheel, folder)
        with tarfile.open(sdist) as archive:
            archive.extractall(folder, filter="data")
        tests = next(path for path in folder.iterdir() if path.is_dir())
        shutil.rmtree(tests / "src")  # what is tested is the wheel
        python = str(folder / "environment/bin/python")
        steps = [
            (folder, interpreter.program, "-m", "venv", str(folder / "environment")),
            (folder, python, "-m", "pip", "install", "-q", f"{copy}[test]"),
            (folder, python, "-m", "musclewire", "--version", "--json"),
            (folder, python, "-m", "musclewire", "demo", "--json"),
            (tests, python, "-m", "pytest", "-q", "-n", "auto", "-p", "no:cacheprovider", "-m", GROUPS, *SUITE),
        ]
        for where, *words in steps:
            done = interpreter.run(where, *words)
            if done.returncode:
                return f"{' '.join(words[1:])}: exit code {done.returncode}\n{done.stdout[-6000:]}{done.stderr[-3000:]}"
            show(interpreter, words, done.stdout)
    return ""


def show(interpreter: Interpreter, words: list[str], said: str) -> None:
    """Print what one step showed: versions, the demo's error, the last line of the tests."""
    name = f"Python {interpreter.version}: "
    if "--version" in words:
        found = json.loads(said)
        packages = ", ".join(
            f"{one} {found['packages'][one]}" for one in ("numpy", "scipy", "numba", "h5py", "pydantic")
        )
        print(f"{name}{found['python']}, {found['system']}\n{name}{packages}")
    elif "demo" in words:
        print(f"{name}demo: mean error {json.loads(said)['mae_mean_pct']:.3f} %")
    elif "pytest" in words:
        print(f"{name}short suite: {[line for line in said.splitlines() if ' passed' in line][-1]}", flush=True)


def main() -> None:
    """Run with every Python that is found, and name those that are not."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", action="append", default=[], help="a version, as 3.13; repeatable")
    parser.add_argument("--system", action="append", default=[], type=Path, help="folder of another system; repeatable")
    given = parser.parse_args()
    found = found_interpreters(given.system)
    chosen = {version: one for version, one in found.items() if not given.only or version in given.only}
    failed = []
    with tempfile.TemporaryDirectory(prefix="musclewire-build-") as name:
        wheel, sdist = sorted(built(Path(name)), key=lambda path: path.suffix != ".whl")
        for version, interpreter in chosen.items():
            problem = judge(interpreter, wheel, sdist)
            if problem:
                failed.append(version)
                print(f"Python {version}: FAIL: {problem}", flush=True)
    print(f"not found: {', '.join(version for version in claimed() if version not in found) or 'none'}")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
