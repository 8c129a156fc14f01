"""Whether every test there is has run in one of the runs whose records are given: none may drop out between groups.

Those of the group ``full`` are left to `nox -s full`, and counted.

    python -m pytest --record a.txt; python -m pytest -m slow --record b.txt; ...
    python .ci/every_test_ran.py a.txt b.txt ...

Collects all tests anew and compares. A test that was skipped wherever it ran has not run.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def recorded(path: Path) -> dict[str, str]:
    """Return how the tests of a record of tests/groups.py ended, by their names."""
    lines = (line.split("\t", 1) for line in path.read_text(encoding="utf-8").splitlines())
    return {name: end for end, name in lines}


def collected() -> dict[str, str]:
    """Return the groups of all tests that pytest finds, by their names; "collected" is a test of no group."""
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "all.txt"
        command = [sys.executable, "-m", "pytest", "--all", "--collect-only", "-qq", "--record", str(record)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"the tests cannot be collected:\n{done.stdout[-3000:]}{done.stderr}")
        return recorded(record)


def main(paths: list[Path]) -> int:
    """Print how many tests each run ran, and every test that none did; return 1 if there is one."""
    if not paths:
        sys.exit(__doc__)
    ran: Counter[str] = Counter()
    for path in paths:
        ends = recorded(path)
        run = [name for name, end in ends.items() if end != "skipped"]
        ran.update(run)
        marked = sum(end == "failed as marked" for end in ends.values())
        print(f"{len(run):6d} ran, {marked} of them failed as marked, {len(ends) - len(run)} skipped: {path.stem}")
    every = collected()
    in_full = {name for name, group in every.items() if group == "full"}
    missing = sorted(set(every) - set(ran) - in_full)
    print(f"{len(every):6d} tests there are, {len(set(every) & set(ran))} of them ran, {ran.total()} runs of a test")
    print(f"{len(in_full - set(ran)):6d} are of the group full, which `nox -s full` runs")
    for name in missing:
        print(f"in no run: {name}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main([Path(name) for name in sys.argv[1:]]))
