"""What is tried in environments of its own, and what CI has no time for (`nox --list`)."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import sys
import tomllib
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

import nox

from musclewire.errors import MissingExtraError

ROOT = Path(__file__).parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
OF_DEVELOPERS = ("test", "oracles", "dev", "docs")
# What needs an extra, and what it says without one.
ACTIONS = tomllib.loads((ROOT / "checks/extras.toml").read_text("utf-8"))["action"]
STUDY = """format = "musclewire-study"
version = 1
name = "two pretensions"
run = { kind = "characterize", cycles = 1, period = "20 s" }
parameters.pretension.values = ["1.5 N", "1.9 N"]
"""
# Tests that touch most of what differs between Pythons and versions of packages: files, kernels, the command line.
SHORT_SUITE = ("tests/unit", "tests/extras/interfaces/unit", "tests/house/test_files_of_releases.py",
               "tests/app/test_command_line.py", "tests/extras/lab_files/app/test_import.py")  # fmt: skip
PYTHONS = [line.rpartition(" ")[2] for line in PROJECT["classifiers"] if "Python :: 3." in line]
PLATFORMS = {
    "Windows, x86-64": "x86_64-pc-windows-msvc",
    "macOS, Apple silicon": "aarch64-apple-darwin",
    "macOS, x86-64": "x86_64-apple-darwin",
}
# All extras, and which of them imports which, as ARCHITECTURE.md draws it and pyproject.toml holds it.
EXTRAS = sorted(path.parent.name for path in ROOT.glob("src/musclewire/extras/*/manifest.py"))
ARROWS = {"board": ("interfaces",)}
# Packages of the checkout that are installed apart, and commands that need each.
BESIDE = {
    "packages/design": ("design pretensioner --stiffness '386.2 N/m'", "reproduce --only fig13a --seed 1"),
    "studies/robustness": ("robustness --list",),
}
# That an extra is missing is found within so many times what `musclewire --version` takes: reading a file's first rows
# takes two of them, on a machine that is busy too; work that was once done before took a hundred.
ABSENT_TIMES = 4.0
# What a copy of the checkout does without: what is made in it, and the tests that are about the whole of it.
NOT_COPIED = shutil.ignore_patterns(".*", "__pycache__", "build", "*.egg-info", "house")
# Files that are named run whole, their long tests too, unless these are left out.
NO_LONG_TESTS = "not (slow or emulated or documented or oracles or browser or full)"
# What measures time, one after the other: another process beside it is part of the figure.
TIMED = (
    "checks/step_cost.py",
    "-m benchmarks.speed",
    "benchmarks/batch.py",
    "benchmarks/wire_in_segments.py",
    "benchmarks/start_up.py",
    "benchmarks/exchange.py",
    "benchmarks/import_large_file.py",
    "benchmarks/kill_recording.py",
    "benchmarks/many_closed_loops.py",
    "benchmarks/host_loop.py",
    "-m benchmarks.live_stop",
    "-m benchmarks.live_stop --among",
    "-m benchmarks.end_of_commands",
    "-m benchmarks.malformed_messages",
    "-m benchmarks.stop_latency",
    "-m benchmarks.loaded_board",
    "benchmarks/vector_environment.py",
    "-m benchmarks.live_page --stop",
    "-m benchmarks.live_page --growth",
)
# What judges numbers and not time. CI runs the quick form of the first ones.
NUMBERS_IN_CI = (
    "-m benchmarks.lying_rigs",
    "benchmarks/hysteresis_memory.py",
    "studies/isobar_branches.py",
    "benchmarks/convergence.py",
    "benchmarks/kernel_accuracy.py",
    "studies/fit_without_instruments.py",
    "studies/force_self_sensing.py",
    "studies/calibrate_isobars.py",
)
NUMBERS = (
    "studies/calibrate_own_wire.py",
    "studies/calibrations_that_share.py",
    "studies/zero_of_room.py",
    "studies/known_strain.py",
    "studies/changes_in_mid_run.py",
    "studies/alternative_fits.py",
    "studies/fit_paper_wires.py",
    "studies/contact_detection.py",
    "studies/real_recordings.py",
    "-m benchmarks.staircase_from_cold",
    "benchmarks/emulated_staircase.py",
    "benchmarks/exported_c.py",
    "benchmarks/fmu.py",
    "benchmarks/fuzz_firmware.py",
)
WITHOUT_QUICK_FORM = ("checks/step_cost.py", "benchmarks/wire_in_segments.py", "benchmarks/hysteresis_memory.py",
                      "studies/isobar_branches.py", "studies/real_recordings.py")  # fmt: skip
nox.options.sessions = ["package"]


def extras_of_users() -> set[str]:
    """Return the extras that bring users a package, and not only other extras."""
    return {
        extra
        for extra, packages in PROJECT["optional-dependencies"].items()
        if extra not in OF_DEVELOPERS and not all(package.startswith("musclewire[") for package in packages)
    }


@nox.session(venv_backend="uv")
def package(session: nox.Session) -> None:
    """Build wheel and sdist, judge them, use the wheel where nothing else is, and try what needs each extra."""
    folder = Path(session.create_tmp())
    session.run(
        sys.executable,
        "-m",
        "build",
        "-q",
        "--installer",
        "uv",
        "--outdir",
        str(folder / "dist"),
        str(ROOT),
        external=True,
    )
    wheel, sdist = sorted((folder / "dist").iterdir(), key=lambda path: path.suffix != ".whl")
    judges = Path(sys.executable).parent
    # The licence is there twice (W002): a project exported as C carries its own.
    contents = ("--ignore", "W002", "--package", "src/musclewire", str(wheel))
    session.run(f"{judges}/check-wheel-contents", *contents, external=True)
    session.run(f"{judges}/twine", "check", "--strict", str(wheel), str(sdist), external=True)
    session.install(str(wheel))
    session.chdir(folder)
    said = session.run("python", "-c", "import musclewire; print(musclewire.__file__)", silent=True)
    if not str(said).startswith(str(session.virtualenv.location)):
        session.error(f"musclewire was imported from {said}")
    session.run("musclewire", "--version")
    session.run("musclewire", "demo")
    session.run("musclewire", "characterize", "simulated", "--cycles", "1", "-o", "loop.h5")
    session.run("musclewire", "fit", "loop.h5", "-o", "model.json")
    Path("study.toml").write_text(STUDY, "utf-8")
    for name in ("loop.tdms", "loop.xlsx", "loop.parquet"):
        Path(name).touch()
    if missing := extras_of_users() ^ {row["extra"] for row in ACTIONS}:
        session.error(f"checks/extras.toml and pyproject.toml disagree about the extras {sorted(missing)}")
    began_s = computed_s()
    session.run("musclewire", "--version", silent=True)
    version_s = computed_s() - began_s
    for row in ACTIONS:
        without_extra(session, row, ABSENT_TIMES * version_s)
    for place, commands in BESIDE.items():
        beside_it(session, place, commands)
    solid = "musclewire", "design", "finger", "--finger", "lan-fan-2010", "--solid", "finger.stl"
    said = str(session.run(*solid, silent=True, success_codes=[2])).strip()
    if "\n" in said or not said.endswith('pip install "./packages/design[cad]" in the checkout'):
        session.error(f"a solid must say in one line what it needs, and says: {said}")


def computed_s() -> float:
    """Return how long the processes that have ended have computed: what else runs on the machine is no part of it."""
    times = os.times()
    return times.children_user + times.children_system


@nox.session(venv_backend="uv")
def site(session: nox.Session) -> None:
    """Build the site by README's line for it, in an environment of what that line names."""
    said = (ROOT / "README.md").read_text("utf-8")
    install, build = re.findall(r"`(pip install [^`]*|python docs/build[^`]*)`", said)[:2]
    session.install(*shlex.split(install)[2:])
    session.run(*shlex.split(build))


def beside_it(session: nox.Session, folder: str, commands: Sequence[str]) -> None:
    """Try commands whose package is not here: each says which line installs it. Then that line, and the commands."""
    for command in commands:
        said = str(session.run("musclewire", *shlex.split(command), silent=True, success_codes=[2])).strip()
        if "\n" in said or not said.endswith(f"pip install ./{folder} in the checkout"):
            session.error(f"musclewire {command} must say in one line how it is installed, and says: {said}")
    session.install(str(ROOT / folder))
    for command in commands:
        session.run("musclewire", *shlex.split(command))


def without_extra(session: nox.Session, row: dict[str, str], most_s: float) -> None:
    """Try what needs an extra that is not here: it ends in one line that names the extra, a command in no more time."""
    is_command = "command" in row
    command = ["musclewire", *shlex.split(row["command"])] if is_command else ["python", "-c", row["python"]]
    code = 0 if row.get("works") else 2 if is_command else 1
    began_s = computed_s()
    said = str(session.run(*command, silent=True, success_codes=[code])).strip().splitlines()
    took_s = computed_s() - began_s
    session.log(f"{took_s:.2f} s: {shlex.join(command)}")
    if is_command and not row.get("works") and took_s > most_s:
        session.error(f"{shlex.join(command)} took {took_s:.2f} s: the extra's absence is to be found before any work")
    cure = str(MissingExtraError("", row["extra"])).strip()
    if not row.get("works") and (not said or not said[-1].endswith(cure) or (is_command and len(said) != 1)):
        session.error(f"{row} must say in one line '{cure}', and says: {said}")


def hide(folder: Path, package: str) -> None:
    """Have no package that is installed, for who looks into this folder first: an empty one has its name."""
    distribution = folder / f"{package}-0.dist-info"
    distribution.mkdir()
    (distribution / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 0\n", "utf-8")
    (folder / f"{package}.py").write_text('raise ImportError("hidden")\n', "utf-8")


@nox.session(venv_backend="none")
def without_extras(session: nox.Session) -> None:
    """Delete all extras in a copy, and packages/design: the core's tests and the demo pass.

    `-- each`, or names: one after the other. With each goes what imports it. `-- quick` runs one test file of each
    folder.
    """
    quick, named = "quick" in session.posargs, [word for word in session.posargs if word != "quick"]
    there_are = (*EXTRAS, "design")
    chosen = there_are if named == ["each"] else named
    if wrong := set(chosen) - set(there_are):
        session.error(f"there is no extra {', '.join(sorted(wrong))}; there are {', '.join(there_are)}")
    for deleted in [(name, *ARROWS.get(name, ())) for name in chosen] or [there_are]:
        session.log(f"without {', '.join(deleted)}")
        folder = Path(session.create_tmp()).resolve() / "copy"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(ROOT, folder, ignore=NOT_COPIED)
        # Without any extra their folder goes as well.
        for name in [""] if deleted == there_are else deleted:
            shutil.rmtree(folder / "src/musclewire/extras" / name, ignore_errors=True)
            shutil.rmtree(folder / "tests/extras" / name, ignore_errors=True)
        if "design" in deleted:
            shutil.rmtree(folder / "packages/design")
            hide(folder / "src", "musclewire_design")
        # Of a package that stands on three of them.
        shutil.rmtree(folder / "tests/extras/robustness", ignore_errors=True)
        python = (sys.executable, "-P", "-m")
        variables = {"PYTHONPATH": f"{folder / 'src'}{os.pathsep}{folder}"}
        found = chain.from_iterable((folder / place).rglob("test_*.py") for place in ("tests", "packages"))
        tests = {path.parent: str(path) for path in sorted(found, reverse=True)}
        selected = [*sorted(tests.values()), "-m", NO_LONG_TESTS] if quick else []
        session.chdir(folder)
        if deleted == there_are:
            session.run(*python, "musclewire", "demo", "--output", "demo", env=variables)
        session.run(*python, "pytest", "-q", "-n", "auto", "--dist", "worksteal", *selected, env=variables)


@nox.session(venv_backend="none")
def full(session: nox.Session) -> None:
    """Run what CI leaves out: the tests of the group full, benchmarks, long studies, the core without its extras.

    `-- time`, `-- numbers` and `-- tests` run one of the three; `-- quick` the quick form of all benchmarks and
    studies, and `-- quick numbers` those that CI runs.
    """
    words = set(session.posargs)
    if wrong := words - {"quick", "time", "numbers", "tests"}:
        session.error(f"{', '.join(sorted(wrong))}: say quick, time, numbers or tests")
    quick, parts = "quick" in words, words - {"quick"}
    chosen: tuple[str, ...] = ()
    if not parts or "numbers" in parts:
        chosen += NUMBERS_IN_CI if quick and parts else NUMBERS_IN_CI + NUMBERS
    if not parts or "time" in parts:
        chosen += TIMED
    for line in chosen:
        name, *options = shlex.split(line)
        options += ["--quick"] if quick and name not in WITHOUT_QUICK_FORM else []
        session.run(sys.executable, name, *options, env={"PYTHONPATH": str(ROOT)}, external=True)
    if not quick and (not parts or "tests" in parts):
        session.run(sys.executable, "-m", "pytest", "-n", "auto", "--dist", "worksteal", "-m", "full", external=True)
        session.notify("without_extras")


@nox.session(python=PYTHONS)
def pythons(session: nox.Session) -> None:
    """Install with each Python that is claimed and found, and run the demo and a short suite."""
    session.install(".[test]")
    session.run("musclewire", "--version", "--json")
    session.run("musclewire", "demo")
    session.run("python", "-m", "pytest", "-q", "-n", "auto", "-m", "not slow and not documented", *SHORT_SUITE)


@nox.session(venv_backend="none")
def platforms(session: nox.Session) -> None:
    """Resolve all dependencies for Windows and macOS, from compiled packages only; nothing is run there."""
    chosen = [word for extra in sorted(extras_of_users()) for word in ("--extra", extra)]
    design = tomllib.loads((ROOT / "packages/design/pyproject.toml").read_text("utf-8"))["project"]
    needed = [*design["dependencies"], *chain(*design["optional-dependencies"].values())]
    of_design = Path(session.create_tmp()) / "design.in"
    of_design.write_text("\n".join(line for line in needed if line != "musclewire"), "utf-8")
    for name, platform in PLATFORMS.items():
        for python in PYTHONS:
            options = ["--only-binary", ":all:", "--python-platform", platform, "--python-version", python]
            session.log(f"{name}, Python {python}")
            session.run("uv", "pip", "compile", "-q", *options, *chosen, "pyproject.toml", str(of_design), silent=True)


@nox.session
def coverage(session: nox.Session) -> None:
    """Measure lines and branches of the default tests and, where compiled code cannot be traced, of some without it."""
    session.install("-e", ".[test,dev]", "-e", "packages/design")
    session.run("coverage", "erase")
    session.run("coverage", "run", "-m", "pytest", "-q", "-n", "auto", *session.posargs)
    plain = ("tests/unit/controllers", "tests/unit/sensing", "tests/unit/physics")
    limit = ("--timeout", "30", "-o", "filterwarnings=default")
    # For threads coverage holds a lock, and a test that ends at its limit while it is held never ends.
    session.run(
        "coverage", "run", "--concurrency", "multiprocessing", "-m", "pytest", "-q", "-n", "auto", *limit, *plain,
        env={"NUMBA_DISABLE_JIT": "1"}, success_codes=[0, 1],
    )  # fmt: skip
    session.run("coverage", "combine")
    session.run("coverage", "report", "--skip-covered", "--sort=cover")
