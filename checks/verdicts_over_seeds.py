"""Are the verdicts of `reproduce` the simulator's or the seeds'? Judges every row over ten disjoint sets of seeds.

    python checks/verdicts_over_seeds.py [--seeds N] [--sets 10] [--only NAME] [--keep FILE]

Each set has the default number of seeds of `musclewire reproduce`, or N. All seeds run once, on all cores; each set is
then judged by itself. Prints how many verdicts agree with the most frequent one of their row, for the number of seeds
and for smaller ones (as many sets of each), and every row whose sets differ, with the verdicts, the range of their
medians, and the limits. Two ways of counting are printed: whether a row holds or not, which decides exit codes and the
list of known failures, and the three verdicts apart ("holds", "at the bar", "fails"). Exit code 1 if fewer than 99 % of
either agree.

``--keep`` writes all numbers as JSON after each set, and goes on from them if the file is there.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from musclewire.experiment import cores
from musclewire.extras.paper import (
    DEFAULT_SEEDS,
    PaperCheck,
    ReproductionRow,
    SeedCallbacks,
    SeedResult,
    all_checks,
    bars,
    numbers_of_seeds,
    row_of_check,
    selected,
)
from musclewire.signals import write_text_whole

AGREEING = 0.99
SMALLER = (5, 11, 21, 31, 41, 61, 81, 101, 151, 201)
# What each seed gave for each check, by its name.
Numbers = dict[str, list[SeedResult]]


class Agreement(NamedTuple):
    """Parts of all verdicts that agree with the most frequent one of their row: holding or not, and all three."""

    holding: float
    verdict: float


def measured_numbers(checks: Sequence[PaperCheck], seeds: int, sets: int, keep: Path | None) -> Numbers:
    """Return what each seed of all sets gives for each check; what a file has is not measured again."""
    numbers: Numbers = {check.name: [] for check in checks}
    if keep is not None and keep.exists():
        kept = json.loads(keep.read_text())
        if set(kept) != set(numbers):
            raise SystemExit(f"{keep} is of other rows: name another file, or ask for the same rows")
        numbers = {name: [SeedResult(*one) for one in kept[name]] for name in numbers}
    done = len(numbers[checks[0].name])
    while done < seeds * sets:
        chosen = tuple(range(done + 1, min(done + seeds, seeds * sets) + 1))
        found = numbers_of_seeds(checks, chosen, workers=cores(), watching=SeedCallbacks())
        for check in checks:
            numbers[check.name] += found.for_check(check.name)
        done += len(chosen)
        print(f"{done} of {seeds * sets} seeds", file=sys.stderr, flush=True)
        if keep is not None:
            write_text_whole(keep, json.dumps(numbers))
    return numbers


def rows_of_sets(check: PaperCheck, numbers: Numbers, seeds: int, sets: int) -> list[ReproductionRow]:
    """Return the row of a check over each of the disjoint sets."""
    found = numbers[check.name]
    return [row_of_check(check, found[place * seeds : (place + 1) * seeds], {}) for place in range(sets)]


def agreement(rows: Sequence[Sequence[ReproductionRow]]) -> Agreement:
    """Return how many verdicts agree, over all rows and sets."""
    total = sum(len(of_row) for of_row in rows)
    holding = sum(Counter(row.ok for row in of_row).most_common(1)[0][1] for of_row in rows)
    verdict = sum(Counter(row.verdict for row in of_row).most_common(1)[0][1] for of_row in rows)
    return Agreement(holding / total, verdict / total)


def print_differing(checks: Sequence[PaperCheck], rows: Sequence[Sequence[ReproductionRow]]) -> None:
    """Print every row on which sets differ."""
    for check, of_row in zip(checks, rows, strict=True):
        counts = Counter(row.verdict for row in of_row)
        if len(counts) > 1:
            medians = [row.ours for row in of_row if row.ours is not None]
            limits = " and ".join(f"{bar:.5g}" for bar in bars(check))
            said = ", ".join(f"{verdict} {count}" for verdict, count in counts.most_common())
            print(f"  {check.name}: {said}; medians {min(medians):.5g} to {max(medians):.5g}, limit {limits}")


def main() -> None:
    """Run the seeds and print what agrees."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=DEFAULT_SEEDS, help=f"seeds of a set (default {DEFAULT_SEEDS})")
    parser.add_argument("--sets", type=int, default=10, help="how many disjoint sets (default 10)")
    parser.add_argument("--only", help="only rows whose names begin so")
    parser.add_argument("--keep", type=Path, help="write all numbers to this file, and go on from it")
    arguments = parser.parse_args()
    checks = selected(all_checks(), arguments.only)
    numbers = measured_numbers(checks, arguments.seeds, arguments.sets, arguments.keep)
    print(f"{len(checks)} rows, {arguments.sets} disjoint sets; agreeing with the most frequent verdict of their row:")
    print(f"{'seeds of a set':>16}{'holding or not':>16}{'three verdicts':>16}")
    for seeds in sorted({*(count for count in SMALLER if count < arguments.seeds), arguments.seeds}):
        rows = [rows_of_sets(check, numbers, seeds, arguments.sets) for check in checks]
        found = agreement(rows)
        print(f"{seeds:16}{100.0 * found.holding:15.2f}%{100.0 * found.verdict:15.2f}%")
    differing = sum(len({row.verdict for row in of_row}) > 1 for of_row in rows)
    print(f"{differing} of {len(checks)} rows on which sets of {arguments.seeds} differ:")
    print_differing(checks, rows)
    sys.exit(0 if min(found) >= AGREEING else 1)


if __name__ == "__main__":
    main()
