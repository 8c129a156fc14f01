"""How fast it is on this machine, as ratios to what one would use instead.

    python -m benchmarks.speed [--only NAME] [--quick] [--json]

Ours and theirs run in one process, in turns, and who is first changes from turn to turn: whatever else the machine does
falls on both. Rows of one thread are timed by processor time, the others by the wall clock. After one run
of each that is not counted, shown are the medians of the times and of the turns' ratios, with the smallest and largest
ratio: where these are far apart, the machine was busy. A minute, or with --quick a quarter of it, on a machine with
little else to do. Only first_step starts processes.

The work is the same for both as far as another program can do it, and the row says where it cannot: the wire that is
written with SciPy (easier_wire.py) has two phases and one barrier, so no minor loops, no R-phase, no friction. SciPy's
LSODA is the strongest opponent at a long stretch: it takes long steps while nothing happens.

The last line but one gives measured peaks of one thread: multiplications and additions of doubles in vector registers,
the same where each waits for the result of the one before, and the bytes that a sum of two long arrays moves (STREAM's
triad). A step of one wire is mostly a chain; many wires side by side can use the vectors. Comparisons whose program is
not installed are named in left_out, with the extra that they need.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict

from benchmarks.speed.cases import cases
from benchmarks.speed.machine import MachinePeaks, measured_machine
from benchmarks.speed.measuring import Comparison, PreparedComparison, measured

from musclewire.errors import installed_by, nearest_hint


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure what is asked for and print it."""
    parser = argparse.ArgumentParser(
        "python -m benchmarks.speed", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", default="", metavar="NAME", help="only rows whose names begin so: step, exchange")
    parser.add_argument("--quick", action="store_true", help="5 turns of each instead of 15, and shorter ones")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")
    asked = parser.parse_args(arguments)
    began_s, known = time.perf_counter(), cases()
    chosen = [case for case in known if case.name.startswith(asked.only)]
    if not chosen:
        names = sorted({case.name.partition("[")[0] for case in known})
        parser.error(f"no comparison begins with '{asked.only}'{nearest_hint(asked.only, names)}")
    possible, left_out = [case for case in chosen if not case.needs], [case for case in chosen if case.needs]
    rows = []
    for number, case in enumerate(possible, 1):
        print(f"{number} of {len(possible)}: {case.name}", file=sys.stderr)
        rows.append(measured(case, asked.quick))
    machine = measured_machine()
    if not asked.json:
        print(text(rows, left_out, machine))
        return
    answer = {
        "rows": [asdict(row) for row in rows],
        "left_out": [{"name": case.name, "needs_extra": case.needs} for case in left_out],
        "machine": asdict(machine),
        "quick": asked.quick,
        "wall_s": time.perf_counter() - began_s,
    }
    print(json.dumps(answer, indent=2, allow_nan=False))


def text(rows: Sequence[Comparison], left_out: Sequence[PreparedComparison], machine: MachinePeaks) -> str:
    """Return the table of a benchmark, what each row compares, and the machine."""
    width = max((len(row.name) + 2 for row in rows), default=2)
    lines = [f"{'':{width}}{'ours':>12}{'theirs':>12}{'ratio':>9}  {'of the turns':18}compared with"]
    for row in rows:
        times = f"{time_text(row.ours_us):>12}{time_text(row.theirs_us):>12}{ratio_text(row.ratio):>9}"
        span = f"{ratio_text(row.ratio_low)} to {ratio_text(row.ratio_high)}"
        lines.append(f"{row.name:{width}}{times}  {span:18}{row.theirs}")
    lines += ["", "What the time is for:", *(f"  {row.name}: {row.work}" for row in rows)]
    lines += [f"not measured: {case.name}: {installed_by(case.needs)}" for case in left_out]
    turns = rows[0].turns if rows else 0
    return "\n".join([*lines, "", machine_text(machine), f"medians of {turns} turns, ours and theirs in turn"])


def time_text(time_us: float) -> str:
    """Return a time in the unit that suits it, with three digits."""
    for unit, scale in (("ns", 1e3), ("us", 1.0), ("ms", 1e-3)):
        if time_us * scale < 1e3:
            return f"{time_us * scale:.3g} {unit}"
    return f"{1e-6 * time_us:.3g} s"


def ratio_text(ratio: float) -> str:
    """Return a ratio with three digits."""
    return f"{ratio:,.0f}" if ratio >= 100.0 else f"{ratio:.3g}"


def machine_text(machine: MachinePeaks) -> str:
    """Return a machine with its measured peaks."""
    return (
        f"{machine.processor}, {machine.cores} cores; measured for one thread: "
        f"{1e-9 * machine.vector_flops_per_s:.3g} Gflop/s in vectors, "
        f"{1e-9 * machine.chained_flops_per_s:.2g} Gflop/s where each waits for the last, "
        f"{1e-9 * machine.bandwidth_bytes_per_s:.3g} GB/s of memory"
    )


if __name__ == "__main__":
    main()
