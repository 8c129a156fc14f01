"""The benchmark: every case that is asked for, with the peaks of the machine that runs it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from musclewire.errors import CallerError, nearest_hint
from musclewire.speed.cases import cases
from musclewire.speed.machine import Machine, measured_machine
from musclewire.speed.measure import Case, Comparison, comparison, paired_us

__all__ = ["Benchmark", "bench"]

TURNS, QUICK_TURNS = 15, 5


@dataclass(frozen=True)
class Benchmark:
    """What a benchmark found.

    Parameters
    ----------
    machine
        Measured peaks of the machine.
    rows
        The comparisons that were measured.
    left_out
        Name of each comparison that was not measured, and the extra that the other program needs.
    quick
        Whether there were few turns.
    """

    machine: Machine
    rows: tuple[Comparison, ...]
    left_out: tuple[tuple[str, str], ...]
    quick: bool


def bench(
    only: str | None = None, *, quick: bool = False, on_case: Callable[[str, int, int], None] | None = None
) -> Benchmark:
    """Measure our speed compared with what one would use instead, as ratios of medians in one process.

    Ours and theirs run in turns, so that whatever else the machine does falls on both. Run it on a machine with little
    else to do.

    Parameters
    ----------
    only
        Beginning of the names of the comparisons to measure, as "step"; all if None.
    quick
        Whether to take 5 turns of each instead of 15, and shorter ones.
    on_case
        Called before each comparison with its name, its number from 0, and the number of all.

    Returns
    -------
    The comparisons, and the measured peaks of the machine.

    Raises
    ------
    CallerError
        If no name begins with ``only``.

    Examples
    --------
    >>> from musclewire.speed.bench import bench
    >>> found = bench("closed_loop", quick=True)
    >>> found.rows[0].ratio > 1.0
    True
    """
    chosen = [case for case in cases() if case.name.startswith(only or "")]
    if not chosen:
        names = sorted({case.name.partition("[")[0] for case in cases()})
        raise CallerError(f"no comparison begins with '{only}'{nearest_hint(only or '', names)}")
    possible = [case for case in chosen if not case.needs]
    rows = []
    for number, case in enumerate(possible):
        if on_case is not None:
            on_case(case.name, number, len(possible))
        rows.append(measured(case, quick))
    left_out = tuple((case.name, case.needs) for case in chosen if case.needs)
    return Benchmark(measured_machine(), tuple(rows), left_out, quick)


def measured(case: Case, quick: bool) -> Comparison:
    """Return the row of a case."""
    pairs = paired_us(*case.sides(quick), QUICK_TURNS if quick else TURNS, case.clock)
    return comparison(case.name, case.work, case.theirs, pairs)
