"""What the benchmark measures: each case makes two sides with equal work, ours and what one would use instead."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from time import perf_counter

import numpy as np
from benchmarks.speed import fuzzy_tick
from benchmarks.speed.batch_cases import batch_cases
from benchmarks.speed.compiled_wires import EXPLICIT_STEP_S, numba_cycle
from benchmarks.speed.easier_wire import PERIOD_S, ScipyLoop, drive_v, scipy_cycle
from benchmarks.speed.loop_cases import loop_cases
from benchmarks.speed.measuring import PreparedComparison, TimedProgram
from benchmarks.speed.our_wire import cycle, paper_wire

from musclewire.controllers import DriveLimits, FuzzyPidController, FuzzyPidSettings
from musclewire.rigs import GuardedRig, open_rig
from musclewire.signals import Drive, QuantityEstimate
from musclewire.wire import CHOSEN, OneWire, fixed_steps, resting_state

__all__ = ["cases"]

CONTROL_PERIOD_S, SAMPLE_S = 0.01, 0.05
# Cycles in a turn, where one takes less than a millisecond.
CYCLES = 10
EASIER = "theirs is an easier wire: two phases, no minor loops, no friction"
# The first 10 ms of a wire in a process of its own, which finds this package from the checkout's folder.
ROOT = Path(__file__).resolve().parents[2]
OUR_PROCESS = """
from benchmarks.speed.our_wire import paper_wire
from musclewire.wire import advance, resting_state
wire = paper_wire()
advance(resting_state(wire), wire, 1.0, 0.01)
"""
SCIPY_PROCESS = """
from benchmarks.speed.easier_wire import ScipyLoop
ScipyLoop(0.01).advance(1.0)
"""


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


def step_side(step_s: float) -> TimedProgram:
    """Return our side of a fixed step; a unit is a step."""
    wire = paper_wire()
    start = resting_state(wire)
    return TimedProgram(lambda _: cycle(wire, start, SAMPLE_S, fixed_steps(step_s)), PERIOD_S / step_s, repeats=CYCLES)


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
    first_s, last_s = (20.0, 26.0) if quick else (0.0, PERIOD_S)
    periods = round((last_s - first_s) / CONTROL_PERIOD_S)
    voltages = [drive_v(first_s + number * CONTROL_PERIOD_S) for number in range(periods)]

    def run(wire: OneWire) -> None:
        for voltage_v in voltages:
            wire.advance(voltage_v, CONTROL_PERIOD_S, CHOSEN)

    return TimedProgram(run, periods, partial(OneWire, paper_wire())), loop_side(voltages, CONTROL_PERIOD_S)


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
    """Return both sides of a sample, while the wire heats."""
    voltages = [drive_v(20.0 + number * SAMPLE_S) for number in range(100 if quick else 400)]
    drives = [Drive(voltage_v) for voltage_v in voltages]

    def run(rig: GuardedRig) -> None:
        for drive in drives:
            rig.exchange(drive)
        rig.close()

    return TimedProgram(run, len(drives), partial(open_rig, "simulated")), loop_side(voltages, SAMPLE_S)


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
    """Return both sides of a tick, with measurements that differ."""
    inferences, ticks = (5, 2000) if quick else (20, 20_000)
    controller = FuzzyPidController(FuzzyPidSettings(rule_base=rule_base), DriveLimits(0.3, 3.2))
    strains = np.random.default_rng(1).uniform(0.014, 0.022, ticks).tolist()
    estimates = [QuantityEstimate(strain, 0.0, True) for strain in strains]

    def run(_: object) -> None:
        state = controller.start(1.0)
        for estimate in estimates:
            state = controller.step(state, 0.018, estimate, 0.05).state

    theirs = TimedProgram(fuzzy_tick.scikit_fuzzy_inferences(inferences), inferences)
    return TimedProgram(run, ticks), theirs


def first_step() -> PreparedComparison:
    """Return the comparison of a new process until its first step is done."""
    work = f"a new process of Python, 10 ms of one wire, and its end; kernels from the cache; {EASIER}"
    other = "a process that imports SciPy and solves the same"
    return PreparedComparison("first_step", work, other, first_step_sides, clock=perf_counter)


def first_step_sides(_quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of a first step."""
    return TimedProgram(process(OUR_PROCESS), 1.0), TimedProgram(process(SCIPY_PROCESS), 1.0)


def process(program: str) -> Callable[[object], object]:
    """Return a call that runs a program in a new process of this Python. Its error is raised if it fails."""
    return lambda _: subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, cwd=ROOT)
