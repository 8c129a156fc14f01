"""Whether wheel and sdist are whole: built, installed where nothing else is, and used.

    python -m checks.package

Builds the sdist, a wheel of the sdist and a wheel of the checkout; both must hold every file below src/musclewire and
nothing else. Installs them in an environment without any extra, outside the checkout, and runs what a first user runs:
the version, the demo, a recording, a fit, what to cite. Then tries, for each optional extra, what needs it
(checks/extras.toml): one line must name the extra. Exit code 1 at the first thing that does not hold.
"""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from checks.fresh_environments import ROOT, Environment, built, fresh_environment

EXTRAS = Path(__file__).with_name("extras.toml")
# Extras of those who change musclewire, not of those who use it.
OF_DEVELOPERS = ("test", "dev", "docs")
# What an installed wheel times; a checkout times more.
BENCH_ROWS = ["step", "closed_loop_period", "exchange", "fuzzy_pid_tick"]
STUDY = """format = "musclewire-study"
version = 1
name = "two pretensions"
run = { kind = "characterize", cycles = 1, period = "20 s" }
parameters.pretension.values = ["1.5 N", "1.9 N"]
"""


def actions() -> list[dict[str, Any]]:
    """Return the rows of extras.toml."""
    rows: list[dict[str, Any]] = tomllib.loads(EXTRAS.read_text("utf-8"))["action"]
    return rows


def extras_of_users() -> set[str]:
    """Return the extras of pyproject.toml that bring users a package, and not only other extras."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    return {
        extra
        for extra, packages in project["optional-dependencies"].items()
        if extra not in OF_DEVELOPERS and not all(package.startswith("musclewire[") for package in packages)
    }


def tracked(folder: str) -> set[str]:
    """Return the files that git knows below a folder, as seen from it."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--", "."], cwd=ROOT / folder, capture_output=True, text=True, check=True
    )
    return {name for name in listed.stdout.split("\0") if name}


def texts_of(wheel: Path) -> dict[str, bytes]:
    """Return what a wheel holds, without its list of check sums."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist() if not name.endswith("/RECORD")}


def judge_contents(of_checkout: Path, of_sdist: Path, sdist: Path) -> None:
    """End with exit code 1 unless both wheels hold the package and only it."""
    inside = texts_of(of_sdist)
    if inside != texts_of(of_checkout):
        sys.exit("FAIL: the wheel of the sdist is not the wheel of the checkout")
    files = {name for name in inside if ".dist-info/" not in name}
    expected = {f"musclewire/{name}" for name in tracked("src/musclewire")}
    if files != expected:
        sys.exit(f"FAIL: in the wheel but not in git, or the other way round: {sorted(files ^ expected)}")
    paths = sorted(name for name, text in inside.items() if str(ROOT).encode() in text)
    if paths:
        sys.exit(f"FAIL: the path of this checkout is in {paths}")
    with tarfile.open(sdist) as archive:
        count = len(archive.getnames())
    wheel_mb, sdist_mb = of_sdist.stat().st_size / 1e6, sdist.stat().st_size / 1e6
    print(f"wheel: {len(files)} files, {wheel_mb:.1f} MB, the same of checkout and sdist")
    print(f"sdist: {count} files, {sdist_mb:.1f} MB")


def judge_metadata(files: list[Path]) -> None:
    """End with exit code 1 unless twine calls the metadata valid, warnings included."""
    command = [sys.executable, "-m", "twine", "--no-color", "check", "--strict", *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"FAIL: twine check\n{done.stdout}{done.stderr}")
    print("metadata: valid (twine check --strict)")


def judge_first_use(bare: Environment) -> None:
    """Run what a first user runs; what it writes is used by what follows."""
    location = bare.run("python", "-c", "import musclewire; print(musclewire.__file__)").stdout
    if not location.startswith(str(bare.folder)):
        sys.exit(f"FAIL: musclewire was imported from {location}")
    said = [bare.run("musclewire", "--version").stdout.splitlines()[0]]
    said.append(bare.run("musclewire", "cite").stdout.splitlines()[0])
    demo = json.loads(bare.run("musclewire", "demo", "--json").stdout)
    bare.run("musclewire", "characterize", "simulated", "--cycles", "1", "-o", "loop.h5")
    bare.run("musclewire", "fit", "loop.h5", "-o", "model.json")
    rows = json.loads(bare.run("musclewire", "bench", "--quick", "--json").stdout)["rows"]
    if [row["name"].partition("[")[0] for row in rows] != BENCH_ROWS:
        sys.exit(f"FAIL: musclewire bench timed {[row['name'] for row in rows]} and not {BENCH_ROWS}")
    (bare.work / "study.toml").write_text(STUDY, "utf-8")
    for name in ("loop.tdms", "loop.xlsx", "loop.parquet"):
        (bare.work / name).touch()
    print(f"first use: {said[0]!r}, {said[1]!r}, demo with a mean error of {demo['mae_mean_pct']:.2f} %, fit")


def judge_absence(bare: Environment, row: Mapping[str, Any]) -> str:
    """Return what an action says without its extra; ends with exit code 1 unless that is one line with the cure."""
    if "python" in row:
        program, arguments = "python", ["-c", row["python"]]
    else:
        program, arguments = "musclewire", shlex.split(row["command"])
    works = row.get("works", False)
    done = bare.run(program, *arguments, code=0 if works else 1 if program == "python" else 2)
    if works:
        return "works without it"
    lines = done.stderr.strip().splitlines()
    line = lines[-1] if lines else ""
    if program == "musclewire" and (len(lines) != 1 or done.stdout):
        sys.exit(f"FAIL: {row} must say one line, and says:\n{done.stdout}{done.stderr}")
    if not line.endswith(f"needs the extra '{row['extra']}': pip install \"musclewire[{row['extra']}]\""):
        sys.exit(f"FAIL: {row} must name its extra, and says: {line}")
    return re.sub(r"^[\w.]+: ", "", line)


def main() -> None:
    """Build, install, use, and print what was found."""
    with tempfile.TemporaryDirectory(prefix="musclewire-package-") as name:
        folder = Path(name)
        of_sdist, sdist = sorted(built(folder / "of_sdist"), key=lambda path: path.suffix != ".whl")
        (of_checkout,) = built(folder / "of_checkout", "--wheel")
        judge_contents(of_checkout, of_sdist, sdist)
        judge_metadata([of_sdist, sdist])
        bare = fresh_environment(folder / "bare")
        bare.install(str(of_sdist))
        judge_first_use(bare)
        for row in actions():
            print(f"{row['extra']:10}{row.get('command') or row['python']}\n{'':10}{judge_absence(bare, row)}")
        bare.install("--no-deps", "--force-reinstall", str(of_checkout))
        bare.run("musclewire", "simulate", "--wire", "flexinol-0.10-lt", "--json")
        print("the wheel of the checkout, installed in its place: runs")


if __name__ == "__main__":
    main()
