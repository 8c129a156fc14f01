"""Measure which lines and branches the tests run, and hold them against the bars of ``branch_coverage.toml``.

Compiled functions run as machine code, which cannot be traced: the group ``without_compilation``, a short suite named
in the same file, runs them as plain Python, and its measures are added. ``default`` is the second command of the
README, the other groups are those of ``pyproject.toml``.

All of it takes longer than the tests of CI do, so it can be done in parts: ``--keep FOLDER`` keeps what each group
measured, later calls with the same folder add to it, and ``--report-only`` runs nothing. What was measured of another
source of the package is refused. Exit code 1 if a bar is missed or a test failed; groups that were not run are named.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
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
GROUPS = ("default", "without_compilation", "slow", "emulated", "documented", "browser")
COVERAGE = [sys.executable, "-m", "coverage"]


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
    # A process that a test ends before it has loaded the package has nothing to say; pytest would make that an error.
    path.write_text(
        f"[run]\nbranch = true\nparallel = true\nsource = {ROOT / PACKAGE}\ndata_file = {folder / 'data'}\n"
        "patch = subprocess, _exit\nconcurrency = thread, multiprocessing\nsigterm = true\n"
        "disable_warnings = no-data-collected\n"
        f"[report]\nexclude_also =\n{lines}\n",
        "utf-8",
    )
    return path


def source_hash() -> str:
    """Return a hash over the package's source: measures of different sources must not be added up."""
    digest = hashlib.sha256()
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def tests_of(group: str, processes: str) -> list[str]:
    """Return pytest's arguments for a group; in a browser one test runs after the other, as in CI."""
    parallel = ["-n", "1" if group == "browser" else processes, "--dist", "worksteal"]
    if group == "without_compilation":
        suite = SETTINGS[group]
        return [*parallel, *suite["tests"], *(f"--deselect={left_out['test']}" for left_out in suite["deselect"])]
    return [*parallel, *([] if group == "default" else ["-m", group])]


def run_group(group: str, folder: Path, processes: str) -> None:
    """Run the tests of a group under coverage; leave in its folder what was measured, and whether all passed."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    settings, source = configuration(folder), source_hash()
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)])}
    if group == "without_compilation":
        environment["NUMBA_DISABLE_JIT"] = "1"
    command = [*COVERAGE, "run", f"--rcfile={settings}", "-m", "pytest", "-q", *tests_of(group, processes)]
    passed = subprocess.run(command, cwd=ROOT, env=environment).returncode == 0
    subprocess.run([*COVERAGE, "combine", "-q", f"--rcfile={settings}"], cwd=ROOT, check=True)
    (folder / "run.json").write_text(json.dumps({"passed": passed, "source": source}), "utf-8")


def kept(folder: Path) -> dict[str, bool]:
    """Return the groups that the folder has measures of, and whether their tests passed; exit if of other source."""
    found = {}
    for group in GROUPS:
        if (record := folder / group / "run.json").exists():
            run = json.loads(record.read_text("utf-8"))
            if run["source"] != source_hash():
                sys.exit(f"{folder / group} was measured on other source of the package: run --groups {group} again")
            found[group] = run["passed"]
    return found


def measured(groups: list[str], folder: Path) -> dict[str, Any]:
    """Add up what the groups measured; return coverage's figures per file of the package."""
    settings, report = configuration(folder), folder / "coverage.json"
    parts = [str(folder / group / "data") for group in groups]
    subprocess.run([*COVERAGE, "combine", "-q", "--keep", f"--rcfile={settings}", *parts], cwd=ROOT, check=True)
    subprocess.run([*COVERAGE, "json", "-q", f"--rcfile={settings}", "-o", str(report)], cwd=ROOT, check=True)
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


def arguments() -> argparse.Namespace:
    """Return the options of this call."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--groups", nargs="+", choices=GROUPS, default=GROUPS, help="which groups of tests to run")
    parser.add_argument("--processes", default="auto", help="of pytest-xdist (default: one a core)")
    parser.add_argument("--files", type=int, default=25, help="how many of the files that lack most to name")
    parser.add_argument("--keep", type=Path, help="a folder that keeps what each group measured, to add to it later")
    parser.add_argument("--report-only", action="store_true", help="run nothing, report what --keep's folder has")
    options = parser.parse_args()
    if options.report_only and options.keep is None:
        parser.error("--report-only needs the folder of --keep")
    return options


def judge(folder: Path, files: int) -> int:
    """Print what the folder's groups reach together, what is missing or failed; return the exit code."""
    if not (passed := kept(folder)):
        sys.exit(f"{folder} has no measures of any group: run some with --groups and --keep")
    held = show(measured(list(passed), folder), files)
    failed = [group for group, good in passed.items() if not good]
    missing = [group for group in GROUPS if group not in passed]
    print(f"\n measured: {', '.join(passed)}")
    print(*(f" tests FAILED in: {group}\n" for group in failed), *(f" not run: {group}\n" for group in missing), sep="")
    return 0 if held and not failed else 1


def main() -> int:
    """Run the tests, add up, print and judge."""
    options = arguments()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.keep or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        for group in () if options.report_only else options.groups:
            run_group(group, folder / group, options.processes)
        return judge(folder, options.files)


if __name__ == "__main__":
    sys.exit(main())
