"""What the benchmark measures: each case makes two sides with equal work, ours and what one would use instead."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from time import perf_counter

from benchmarks.speed import fuzzy_tick
from benchmarks.speed.batch_cases import batch_cases
from benchmarks.speed.compiled_wires import EXPLICIT_STEP_S, numba_cycle
from benchmarks.speed.easier_wire import PERIOD_S, ScipyLoop, scipy_cycle
from benchmarks.speed.loop_cases import loop_cases
from benchmarks.speed.processes import first_period_of_ours, first_period_of_scipy

from musclewire.app import (
    CONTROL_PERIOD_S,
    CYCLES,
    SAMPLE_S,
    PreparedComparison,
    TimedProgram,
    cycle,
    exchange_side,
    paper_wire,
    period_side,
    period_voltages,
    sample_voltages,
    step_side,
    tick_side,
)
from musclewire.wire import resting_state

__all__ = ["cases"]

EASIER = "theirs is an easier wire: two phases, no minor loops, no friction"


def cases() -> list[PreparedComparison]:
    """Return every case in the order in which it is printed."""
    return [
        *steps(), slow_loop(), closed_loop_period(), exchange(), *batch_cases(), *loop_cases(), *fuzzy_pid_ticks(),
        first_step(),
    ]  # fmt: skip


def steps() -> Iterator[PreparedComparison]:
    """Yield the comparisons of a fixed step, along a cycle of the slow sine in one call."""
    lsoda = "SciPy LSODA, which chooses its own steps"
    for step_s in (1e-3, 1e-2):
        named = f"{1e3 * step_s:g}ms"
        work = f"{1e3 * step_s:g} ms of wire time along the slow sine; ours is one step; {EASIER}"
        yield PreparedComparison(f"step[{named}]", work, lsoda, partial(step_and_scipy, step_s))
    work = f"10 ms of wire time along the slow sine; ours is one step, theirs {10e-3 / EXPLICIT_STEP_S:g}; {EASIER}"
    yield PreparedComparison("step[10ms,numba]", work, "a Numba loop of explicit steps of 1 ms", step_and_numba)


def step_and_scipy(step_s: float, _quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of a step and SciPy's LSODA."""
    wanted_s = max(step_s, CONTROL_PERIOD_S)
    return step_side(step_s), TimedProgram(lambda _: scipy_cycle(wanted_s), PERIOD_S / step_s)


def step_and_numba(_quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of a step of 10 ms and a plain Numba loop."""
    steps_a_sample = round(SAMPLE_S / EXPLICIT_STEP_S)
    theirs = TimedProgram(lambda _: numba_cycle(round(PERIOD_S / SAMPLE_S), steps_a_sample), PERIOD_S / 1e-2)
    return step_side(1e-2), theirs


def slow_loop() -> PreparedComparison:
    """Return the comparison of a whole loop at the rig's sample period."""
    work = f"one cycle of the slow sine, 90 s in samples of 50 ms, from cold; {EASIER}"
    return PreparedComparison("slow_loop", work, "SciPy LSODA in one call", slow_loop_sides)


def slow_loop_sides(_quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of the loop."""
    wire = paper_wire()
    start = resting_state(wire)
    return TimedProgram(lambda _: cycle(wire, start, SAMPLE_S), 1.0, repeats=CYCLES), TimedProgram(
        lambda _: scipy_cycle(SAMPLE_S), 1.0
    )


def closed_loop_period() -> PreparedComparison:
    """Return the comparison of a period whose drive a program in Python chooses."""
    work = f"10 ms of wire time at a drive that Python gives each period; {EASIER}"
    return PreparedComparison(
        "closed_loop_period", work, "SciPy solve_ivp (LSODA), a call for each period", period_sides
    )


def period_sides(quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of a period, along a whole cycle of the slow sine or, if quick, while the wire heats."""
    return period_side(quick), loop_side(period_voltages(quick), CONTROL_PERIOD_S)


def loop_side(voltages: list[float], period_s: float) -> TimedProgram:
    """Return SciPy's side at the same drives, a call for each."""

    def run(loop: ScipyLoop) -> None:
        for voltage_v in voltages:
            loop.advance(voltage_v)

    return TimedProgram(run, len(voltages), partial(ScipyLoop, period_s))


def exchange() -> PreparedComparison:
    """Return the comparison of a whole sample of the default rig."""
    work = (
        "50 ms of wire time by one call; ours is a sample of the default rig with protection, noise and instruments; "
        "theirs is the wire alone, and an easier one"
    )
    return PreparedComparison("exchange", work, "SciPy solve_ivp (LSODA), a call for each sample", exchange_sides)


def exchange_sides(quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of a sample."""
    return exchange_side(quick), loop_side(sample_voltages(quick), SAMPLE_S)


def fuzzy_pid_ticks() -> Iterator[PreparedComparison]:
    """Yield the comparisons of a controller's tick, one for each kind of rule base."""
    work = (
        "one tick at a fresh measurement; ours is the whole tick (inference, PID, limits, checks), theirs the "
        "inference of liu-7x7 alone"
    )
    for rule_base in fuzzy_tick.RULE_BASES:
        yield PreparedComparison(
            f"fuzzy_pid_tick[{rule_base}]", work, "scikit-fuzzy's ControlSystemSimulation",
            partial(fuzzy_pid_tick_sides, rule_base), "" if fuzzy_tick.scikit_fuzzy_is_there() else "test",
        )  # fmt: skip


def fuzzy_pid_tick_sides(rule_base: str, quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of a tick."""
    inferences = 5 if quick else 20
    return tick_side(quick, rule_base), TimedProgram(fuzzy_tick.scikit_fuzzy_inferences(inferences), inferences)


def first_step() -> PreparedComparison:
    """Return the comparison of a new process until its first step is done."""
    work = f"a new process of Python, 10 ms of one wire, and its end; kernels from the cache; {EASIER}"
    other = "a process that imports SciPy and solves the same"
    return PreparedComparison("first_step", work, other, first_step_sides, clock=perf_counter)


def first_step_sides(_quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of a first step."""
    return TimedProgram(first_period_of_ours(), 1.0), TimedProgram(first_period_of_scipy(), 1.0)
