"""Compare the verdicts of `reproduce` in two checkouts over several seeds: did a change of numerics alter a result?

    python checks/compare_verdicts.py BEFORE AFTER

Each is a checkout, or a folder that an earlier call filled with ``--keep``. Runs `reproduce` with seeds 1 to 10 with
each checkout's own sources. For each row it prints the medians over the seeds, the tolerance, whether the verdict on
the median changed, and whether the median moved by more than a tenth of the tolerance; exit code 1 if one did. Rows
without a tolerance are bounds: of those the verdict counts, however far within them a median moves.

A row of a single noisy run scatters from seed to seed. Beside a row that moved stands by how much the medians of two
such sets of seeds differ by chance (one standard error); ``--only`` and ``--seeds`` look at it with more of them.

``--finer FOLDER`` adds the medians of a third: the checkout BEFORE run with finer steps and more grains. Of a row that
moved it then says whether AFTER agrees with it better than BEFORE does.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

# What may move without being looked at, as a fraction of a row's tolerance.
MOVED = 0.1
# As `reproduce` allows in its comparison.
ROUNDING = 1e-9


class Row(NamedTuple):
    """One row of `reproduce` over the seeds of a checkout; numbers that could not be measured are NaN."""

    name: str
    unit: str
    paper: float
    tolerance: float
    compare: str
    median: float
    scatter: float

    @property
    def holds(self) -> bool:
        """Whether the median is within the tolerance; a number that is not there is not."""
        room = self.tolerance + ROUNDING * max(1.0, abs(self.paper))
        if self.compare == "reported":
            return True
        if self.compare == "at most":
            return self.median <= self.paper + room
        if self.compare == "at least":
            return self.median >= self.paper - room
        return abs(self.median - self.paper) <= room


def run_seeds(checkout: Path, folder: Path, seeds: int, only: str | None) -> None:
    """Run `reproduce` with the sources of a checkout, once for each seed; leave a JSON document of each in a folder."""
    chosen = ["--only", only] if only else []
    environment = {**os.environ, "PYTHONPATH": str(checkout.resolve() / "src"), "MPLBACKEND": "Agg"}
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(1, seeds + 1):
        with tempfile.TemporaryDirectory() as pages:
            done = subprocess.run(
                [sys.executable, "-m", "musclewire", "reproduce", "--seed", str(seed), "--json", "-o", pages, *chosen],
                cwd=pages,
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
        if done.returncode not in (0, 1):  # 1: done, and a row fails
            raise SystemExit(
                f"{checkout}: reproduce with seed {seed} ended with {done.returncode}: {done.stderr[-600:]}"
            )
        (folder / f"seed_{seed}.json").write_text(done.stdout)


def rows_of(place: Path, keep: Path, seeds: int, only: str | None) -> dict[str, Row]:
    """Return the rows of a checkout, which is run, or of a folder of earlier runs."""
    folder = place
    if (place / "src").is_dir():
        folder = keep
        run_seeds(place, folder, seeds, only)
    files = [folder / f"seed_{seed}.json" for seed in range(1, seeds + 1)]
    missing = [file.name for file in files if not file.exists()]
    if missing:
        raise SystemExit(f"{place} is neither a checkout nor a folder with {', '.join(missing)}")
    found: dict[str, list[dict[str, Any]]] = {}
    for file in files:
        for row in json.loads(file.read_text())["rows"]:
            if row["name"].startswith(only or ""):
                found.setdefault(row["name"], []).append(row)
    return {name: over_seeds(rows) for name, rows in found.items()}


def over_seeds(rows: list[dict[str, Any]]) -> Row:
    """Return one row with the median over its seeds; NaN if one of them has no number."""
    values = [math.nan if row["ours"] is None else row["ours"] for row in rows]
    median = math.nan if any(math.isnan(value) for value in values) else statistics.median(values)
    # Standard error of a median of normal numbers: 1.25 times that of their mean.
    scatter = 1.25 * statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else math.nan
    one = rows[0]
    return Row(one["name"], one["unit"], one["paper"], one["tolerance"], one["compare"], median, scatter)


def moved(before: Row, after: Row) -> bool:
    """Return whether a median moved by more than a tenth of the tolerance."""
    if math.isnan(before.median) or math.isnan(after.median):
        return math.isnan(before.median) != math.isnan(after.median)
    return abs(after.median - before.median) > MOVED * before.tolerance > 0.0


def words_on(before: Row, after: Row, finer: Row | None) -> str:
    """Return what there is to say of a row; "" if it is as before."""
    said = []
    if before.holds != after.holds:
        said.append(f"VERDICT {'holds' if before.holds else 'fails'} -> {'holds' if after.holds else 'fails'}")
    if moved(before, after):
        share = abs(after.median - before.median) / (before.tolerance or math.nan)
        chance = math.hypot(before.scatter, after.scatter)
        said.append(f"MOVED by {share:.2f} of its tolerance, {after.median - before.median:+.3g}, chance {chance:.2g}")
    if said and finer is not None:
        nearer = abs(after.median - finer.median) < abs(before.median - finer.median)
        said.append(f"finer: {finer.median:.6g}, {'nearer to after' if nearer else 'nearer to before'}")
    return ", ".join(said)


def main() -> None:
    """Run both and print the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--finer", type=Path, help="a folder or checkout of BEFORE with finer steps")
    parser.add_argument("--seeds", type=int, default=10, help="seeds 1 to this (default 10)")
    parser.add_argument("--only", help="only rows whose names begin so")
    parser.add_argument("--keep", type=Path, help="keep the runs in this folder")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        keep = arguments.keep or Path(scratch)
        wanted = arguments.seeds, arguments.only
        before = rows_of(arguments.before, keep / "before", *wanted)
        after = rows_of(arguments.after, keep / "after", *wanted)
        finer = rows_of(arguments.finer, keep / "finer", *wanted) if arguments.finer else {}
    changed = 0
    print(f"{'row':62}{'before':>14}{'after':>14}{'tolerance':>12}  unit")
    for name, row in before.items():
        if name not in after:
            print(f"{name:62}{row.median:14.6g}{'':>14}{row.tolerance:12.4g}  {row.unit}  GONE")
            changed += 1
            continue
        said = words_on(row, after[name], finer.get(name))
        changed += bool(said)
        print(f"{name:62}{row.median:14.6g}{after[name].median:14.6g}{row.tolerance:12.4g}  {row.unit}  {said}")
    for name in sorted(set(after) - set(before)):
        print(f"{name:62}{'':>14}{after[name].median:14.6g}{after[name].tolerance:12.4g}  {after[name].unit}  NEW")
    print(f"{changed} of {len(before)} rows changed their verdict or moved by more than {MOVED:g} of their tolerance")
    sys.exit(1 if changed else 0)


if __name__ == "__main__":
    main()
