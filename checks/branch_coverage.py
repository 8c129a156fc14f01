"""Measure which lines and branches the tests run, and hold them against the bars of ``branch_coverage.toml``.

Compiled functions run as machine code, which cannot be traced: a short suite, named in the same file, runs them as
plain Python, and its measures are added. ``--groups`` runs some of the groups of tests only (``default`` is the second
command of the README); without it all are run, which takes somewhat longer than the tests of CI do. Exit code 1 if a
bar is missed, or a test failed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
SETTINGS = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
PACKAGE = "src/musclewire/"
GROUPS = ("default", "slow", "emulated", "documented", "browser")


class Share(NamedTuple):
    """How many of the lines and branches of a room were run."""

    room: str
    run: int
    there: int
    bar_pct: float | None

    @property
    def percent(self) -> float:
        """Return lines and branches that were run, in percent."""
        return 100.0 * self.run / self.there if self.there else 100.0

    @property
    def missed(self) -> bool:
        """Say whether the share is below its bar."""
        return self.bar_pct is not None and self.percent < self.bar_pct


def configuration(folder: Path) -> Path:
    """Write coverage's settings: branches, every process that a test starts, and what no test can run."""
    lines = "\n".join(f"    {line}" for line in SETTINGS["exclude"]["lines"])
    path = folder / "coveragerc"
    path.write_text(
        f"[run]\nbranch = true\nparallel = true\nsource = {ROOT / PACKAGE}\ndata_file = {folder / 'data'}\n"
        "patch = subprocess, _exit\nconcurrency = thread, multiprocessing\nsigterm = true\n"
        f"[report]\nexclude_also =\n{lines}\n",
        "utf-8",
    )
    return path


def pytest_under_coverage(settings: Path, arguments: list[str], **environment: str) -> bool:
    """Run tests under coverage; return whether all passed."""
    command = [sys.executable, "-m", "coverage", "run", f"--rcfile={settings}", "-m", "pytest", "-q", *arguments]
    source = os.pathsep.join([str(ROOT / "src"), str(ROOT)])
    return subprocess.run(command, cwd=ROOT, env={**os.environ, "PYTHONPATH": source, **environment}).returncode == 0


def run_group(settings: Path, group: str, processes: str) -> bool:
    """Run one group of tests; those in a browser one after the other, as CI does."""
    parallel = ["-n", "1" if group == "browser" else processes, "--dist", "worksteal"]
    return pytest_under_coverage(settings, [*parallel, *([] if group == "default" else ["-m", group])])


def run_without_compilation(settings: Path, processes: str) -> bool:
    """Run the short suite with Numba switched off."""
    suite = SETTINGS["without_compilation"]
    chosen = [*suite["tests"], *(f"--deselect={name}" for name in suite["deselect"])]
    return pytest_under_coverage(settings, ["-n", processes, "--dist", "worksteal", *chosen], NUMBA_DISABLE_JIT="1")


def measured(settings: Path, folder: Path) -> dict[str, Any]:
    """Add up what all processes measured; return coverage's figures per file of the package."""
    coverage = [sys.executable, "-m", "coverage"]
    subprocess.run([*coverage, "combine", "-q", f"--rcfile={settings}"], cwd=ROOT, check=True)
    report = folder / "coverage.json"
    subprocess.run([*coverage, "json", "-q", f"--rcfile={settings}", "-o", str(report)], cwd=ROOT, check=True)
    files = json.loads(report.read_text("utf-8"))["files"]
    return {name.partition(PACKAGE)[2]: file["summary"] for name, file in files.items()}


def share_of(room: str, files: dict[str, Any], bar_pct: float | None) -> Share:
    """Add up the figures of the files of a room; the room '' is the whole package."""
    inside = [file for name, file in files.items() if name.startswith(room and f"{room}/")]
    run = sum(file["covered_lines"] + file["covered_branches"] for file in inside)
    there = sum(file["num_statements"] + file["num_branches"] for file in inside)
    return Share(room or "whole", run, there, bar_pct)


def shares(files: dict[str, Any]) -> list[Share]:
    """Return the share of each room, those with a bar first, and of the whole."""
    bars = SETTINGS["bars"]["rooms"]
    others = sorted({name.split("/")[0] for name in files if "/" in name} - set(bars))
    with_bar = [share_of(room, files, bar) for room, bar in bars.items()]
    return [
        *with_bar,
        *(share_of(room, files, None) for room in others),
        share_of("", files, SETTINGS["bars"]["whole"]),
    ]


def show(files: dict[str, Any], most: int) -> bool:
    """Print the shares and the files that lack most; return whether every bar is held."""
    print("\n room                         lines and branches   bar")
    for share in (found := shares(files)):
        bar = "" if share.bar_pct is None else f"{share.bar_pct:5.1f}" + ("  MISSED" if share.missed else "")
        print(f" {share.room:28s} {share.percent:8.2f} %  {share.run:6d}/{share.there:<6d} {bar}")
    lacking = Counter(
        {name: file["missing_lines"] + file["missing_branches"] for name, file in files.items()}
    ).most_common(most)
    print("\n lines and branches that no test runs:", *(f"\n {count:5d}  {name}" for name, count in lacking))
    return not any(share.missed for share in found)


def main() -> int:
    """Run the tests, add up, print and judge."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--groups", nargs="+", choices=GROUPS, default=GROUPS, help="which groups of tests to run")
    parser.add_argument("--processes", default="auto", help="of pytest-xdist (default: one a core)")
    parser.add_argument("--files", type=int, default=25, help="how many of the files that lack most to name")
    parser.add_argument("--keep", type=Path, help="a folder that keeps coverage's files, to look further")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.keep or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        settings = configuration(folder)
        passed = [run_group(settings, group, options.processes) for group in options.groups]
        passed.append(run_without_compilation(settings, options.processes))
        held = show(measured(settings, folder), options.files)
    return 0 if held and all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
