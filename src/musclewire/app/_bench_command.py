"""Command ``bench``: how fast it is on this machine, compared with what one would use instead."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

from musclewire.app._options import ONLY, QUICK
from musclewire.app._output import Result, tell
from musclewire.errors import installed_by

if TYPE_CHECKING:
    from musclewire.app._bench_measure import MachinePeaks
    from musclewire.app._bench_rows import Benchmark


def bench(only: Annotated[str | None, ONLY] = None, quick: Annotated[bool, QUICK] = False) -> Result:
    """How fast it is on this machine, as ratios to what one would use instead."""
    from musclewire.app._answers import BenchAnswer, UnmeasuredRow
    from musclewire.app._bench_rows import bench as run_bench

    began_s = time.perf_counter()
    found = run_bench(only, quick=quick, on_case=lambda name, number, of: tell(f"{number + 1} of {of}: {name}"))
    left_out = [UnmeasuredRow(name=name, needs_extra=extra) for name, extra in found.left_out]
    answer = BenchAnswer.read_from(found, left_out=left_out, wall_s=time.perf_counter() - began_s)
    return Result(answer, bench_text(found))


def bench_text(found: Benchmark) -> str:
    """Return the table of a benchmark, what each row compares, and the machine."""
    width = max((len(row.name) + 2 for row in found.rows), default=2)
    lines = [f"{'':{width}}{'ours':>12}{'theirs':>12}{'ratio':>9}  {'of the turns':18}compared with"]
    for row in found.rows:
        times = f"{time_text(row.ours_us):>12}{time_text(row.theirs_us):>12}{ratio_text(row.ratio):>9}"
        span = f"{ratio_text(row.ratio_low)} to {ratio_text(row.ratio_high)}"
        lines.append(f"{row.name:{width}}{times}  {span:18}{row.theirs}")
    lines += ["", "What the time is for:", *(f"  {row.name}: {row.work}" for row in found.rows)]
    lines += [f"not measured: {name}: {installed_by(extra)}" for name, extra in found.left_out if extra]
    elsewhere = [name for name, extra in found.left_out if extra is None]
    if elsewhere:
        lines += ["", f"not measured outside a checkout, whose benchmarks/speed has them: {', '.join(elsewhere)}"]
    turns = found.rows[0].turns if found.rows else 0
    return "\n".join([*lines, "", machine_text(found.machine), f"medians of {turns} turns, ours and theirs in turn"])


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
    """Return a machine with its measured peaks, where they were measured."""
    text = f"{machine.processor}, {machine.cores} cores"
    vectors, chained, moved = machine.vector_flops_per_s, machine.chained_flops_per_s, machine.bandwidth_bytes_per_s
    if vectors is None or chained is None or moved is None:
        return text
    return (
        f"{text}; measured for one thread: {1e-9 * vectors:.3g} Gflop/s in vectors, "
        f"{1e-9 * chained:.2g} Gflop/s where each waits for the last, {1e-9 * moved:.3g} GB/s of memory"
    )
