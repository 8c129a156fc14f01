"""What ``musclewire bench`` times: four rows with fixed work, and in a checkout those of benchmarks/speed.

A checkout is a folder with ``src/musclewire`` and ``benchmarks/speed``: the source tree that the package is in, or else
the current folder. In an installed wheel elsewhere the rows of the checkout, and the measured peaks of the machine, are
left out. This is the only file of the command line that calls the simulator.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

import musclewire
from musclewire.app._bench_measure import (
    Comparison,
    MachinePeaks,
    PreparedComparison,
    TimedProgram,
    arithmetic_side,
    comparison,
    paired_us,
    processor_name,
    python_side,
    usable_cores,
)
from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import load_alloy, load_bench, load_wire
from musclewire.wire import (
    CHOSEN,
    ConnectorLoad,
    OneWire,
    StepControl,
    WireConstants,
    WireState,
    constants_of,
    drive_path,
    fixed_steps,
    resting_state,
)

TURNS, QUICK_TURNS = 15, 5
# The slow sine of the paper's bench.
PERIOD_S, SENSE_V, AMPLITUDE_V = 90.0, 0.3, 3.2
CONTROL_PERIOD_S, SAMPLE_S = 0.01, 0.05
# Cycles in a turn, where one takes less than a millisecond.
CYCLES = 10
# Rounds of the fixed work in a unit of its side.
ROUNDS = 100
# Beginnings of the names of the rows that only a checkout has; a test holds them to benchmarks/speed/cases.py.
CHECKOUT_ROWS = (
    "step[1ms]",
    "step[10ms]",
    "step[10ms,numba]",
    "slow_loop",
    "closed_loop_period",
    "exchange",
    "batch[numba]",
    "closed_loops",
    "vector_environment",
    "fuzzy_pid_tick[zhao-1993]",
    "fuzzy_pid_tick[liu-7x7]",
    "fuzzy_pid_tick[fixed]",
    "first_step",
)


@dataclass(frozen=True)
class Benchmark:
    """What a benchmark found.

    Parameters
    ----------
    machine
        The machine, in a checkout with its measured peaks.
    rows
        The comparisons that were measured.
    left_out
        Name of each comparison that was not measured, and the extra that the other program needs; None if it needs a
        checkout.
    quick
        Whether there were few turns.
    """

    machine: MachinePeaks
    rows: tuple[Comparison, ...]
    left_out: tuple[tuple[str, str | None], ...]
    quick: bool


def bench(
    only: str | None = None, *, quick: bool = False, on_case: Callable[[str, int, int], None] | None = None
) -> Benchmark:
    """Measure our speed compared with what one would use instead, as ratios of medians in one process.

    Ours and theirs run in turns, so that whatever else the machine does falls on both. Run it on a machine with little
    else to do. Outside a checkout there are four comparisons with fixed work.

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
    The comparisons, and the machine, in a checkout with its measured peaks.

    Raises
    ------
    CallerError
        If no name begins with ``only``.

    Examples
    --------
    >>> from musclewire.app._bench_rows import bench
    >>> found = bench("closed_loop_period", quick=True)
    >>> found.rows[0].ratio > 1.0
    True
    """
    folder = checkout()
    known = [*(() if folder is None else checkout_module(folder, "cases").cases()), *cases_with_fixed_work()]
    elsewhere = CHECKOUT_ROWS if folder is None else ()
    chosen = [case for case in known if case.name.startswith(only or "")]
    left_out = [(name, None) for name in elsewhere if name.startswith(only or "")]
    if not chosen and not left_out:
        names = sorted({name.partition("[")[0] for name in (*(case.name for case in known), *elsewhere)})
        raise CallerError(f"no comparison begins with '{only}'{nearest_hint(only or '', names)}")
    possible = [case for case in chosen if not case.needs]
    rows = []
    for number, case in enumerate(possible):
        if on_case is not None:
            on_case(case.name, number, len(possible))
        rows.append(measured(case, quick))
    missing = [(case.name, case.needs) for case in chosen if case.needs]
    return Benchmark(machine_of(folder), tuple(rows), (*missing, *left_out), quick)


def measured(case: PreparedComparison, quick: bool) -> Comparison:
    """Return the row of a case."""
    pairs = paired_us(*case.sides(quick), QUICK_TURNS if quick else TURNS, case.clock)
    return comparison(case.name, case.work, case.theirs, pairs)


def checkout() -> Path | None:
    """Return the source tree that the package is in, else the current folder if it is one; None if neither is."""
    own = Path(musclewire.__file__).resolve().parents[2]
    return next((folder for folder in (own, Path.cwd()) if is_checkout(folder)), None)


def is_checkout(folder: Path) -> bool:
    """Return whether a folder has the package's sources and the other rows."""
    return all((folder / name).is_file() for name in ("src/musclewire/__init__.py", "benchmarks/speed/cases.py"))


def checkout_module(folder: Path, name: str) -> Any:
    """Return a module of benchmarks/speed of a checkout."""
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    return import_module(f"benchmarks.speed.{name}")


def machine_of(folder: Path | None) -> MachinePeaks:
    """Return this machine, with its peaks as a checkout measures them."""
    if folder is None:
        return MachinePeaks(processor_name(), usable_cores())
    found: MachinePeaks = checkout_module(folder, "machine").measured_machine()
    return found


def cases_with_fixed_work() -> Iterator[PreparedComparison]:
    """Yield the comparisons with fixed work, which need nothing but the package."""
    arithmetic = f"fixed work in compiled code, {ROUNDS} rounds"
    python = f"fixed work in Python, {ROUNDS} rounds"
    work = "10 ms of wire time along the slow sine, one step"
    yield PreparedComparison("step[fixed work]", work, arithmetic, lambda _: (step_side(1e-2), arithmetic_side(ROUNDS)))
    work = "10 ms of wire time at a drive that Python gives each period"
    yield PreparedComparison(
        "closed_loop_period[fixed work]", work, python, lambda quick: (period_side(quick), python_side(ROUNDS))
    )
    work = "50 ms of wire time: a sample of the default rig with protection, noise and instruments"
    yield PreparedComparison(
        "exchange[fixed work]", work, python, lambda quick: (exchange_side(quick), python_side(ROUNDS))
    )
    work = "one tick at a fresh measurement: inference, PID, limits, checks"
    yield PreparedComparison(
        "fuzzy_pid_tick[fixed work]", work, python, lambda quick: (tick_side(quick), python_side(ROUNDS))
    )


def step_side(step_s: float, load: ConnectorLoad | None = None) -> TimedProgram:
    """Return a fixed step along a cycle of the slow sine in one call; a unit is a step."""
    wire = paper_wire(load)
    start = resting_state(wire)
    return TimedProgram(lambda _: cycle(wire, start, SAMPLE_S, fixed_steps(step_s)), PERIOD_S / step_s, repeats=CYCLES)


def period_side(quick: bool) -> TimedProgram:
    """Return periods along a whole cycle of the slow sine or, if quick, while the wire heats; a unit is a period."""
    wire = paper_wire()
    voltages = period_voltages(quick)

    def run(wire: OneWire) -> None:
        for voltage_v in voltages:
            wire.advance(voltage_v, CONTROL_PERIOD_S, CHOSEN)

    return TimedProgram(run, len(voltages), partial(OneWire, wire))


def period_voltages(quick: bool) -> list[float]:
    """Return the drive [V] of each period."""
    first_s, last_s = (20.0, 26.0) if quick else (0.0, PERIOD_S)
    periods = round((last_s - first_s) / CONTROL_PERIOD_S)
    return [drive_v(first_s + number * CONTROL_PERIOD_S) for number in range(periods)]


def exchange_side(quick: bool) -> TimedProgram:
    """Return samples of the default rig while the wire heats; a unit is a sample."""
    # Imported here, as in the next one: the benchmark of a new process needs neither.
    from musclewire.rigs import open_rig
    from musclewire.signals import Drive

    samples = [Drive(voltage_v) for voltage_v in sample_voltages(quick)]

    def run(rig: Any) -> None:
        for drive in samples:
            rig.exchange(drive)
        rig.close()

    return TimedProgram(run, len(samples), partial(open_rig, "simulated"))


def sample_voltages(quick: bool) -> list[float]:
    """Return the drive [V] of each sample."""
    return [drive_v(20.0 + number * SAMPLE_S) for number in range(100 if quick else 400)]


def tick_side(quick: bool, rule_base: str = "zhao-1993") -> TimedProgram:
    """Return ticks of the fuzzy PID with measurements that differ; a unit is a tick."""
    from musclewire.controllers import DriveLimits, FuzzyPidController, FuzzyPidSettings
    from musclewire.signals import QuantityEstimate

    ticks = 2000 if quick else 20_000
    controller = FuzzyPidController(FuzzyPidSettings(rule_base=rule_base), DriveLimits(0.3, 3.2))
    strains = np.random.default_rng(1).uniform(0.014, 0.022, ticks).tolist()
    estimates = [QuantityEstimate(strain, 0.0, True) for strain in strains]

    def run(_: object) -> None:
        state = controller.start(1.0)
        for estimate in estimates:
            state = controller.step(state, 0.018, estimate, 0.05).state

    return TimedProgram(run, ticks)


def paper_wire(load: ConnectorLoad | None = None, scale: float = 1.0) -> WireConstants:
    """Return the paper's 100 um wire on its bench: all of the physics, on its spring or on another load.

    ``scale`` multiplies pretension, length and the spread of martensite's transformation temperature, for wires that
    differ.
    """
    alloy, wire, bench = (
        load_alloy("flexinol").values(),
        load_wire("paper-100um").values(),
        load_bench("paper").values(),
    )
    alloy["martensite_spread_k"] *= scale
    bench["pretension_n"] *= scale
    bench["wire_length_m"] *= scale
    return constants_of(alloy, wire, bench, load=load)


def drive_v(time_s: float) -> float:
    """Return the slow sine [V]."""
    return SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - math.cos(2.0 * math.pi * time_s / PERIOD_S))


def slow_sine(sample_s: float) -> FloatArray:
    """Return one cycle of the slow sine [V], each sample's mean drive."""
    time_s = (np.arange(round(PERIOD_S / sample_s)) + 0.5) * sample_s
    drive: FloatArray = SENSE_V + (AMPLITUDE_V - SENSE_V) * 0.5 * (1.0 - np.cos(2.0 * np.pi * time_s / PERIOD_S))
    return drive


def cycle(wire: WireConstants, start: WireState, sample_s: float, stepping: StepControl = CHOSEN) -> None:
    """Follow one cycle of the slow sine in one call."""
    drive_path(wire, slow_sine(sample_s), sample_s=sample_s, stepping=stepping, state=start)
