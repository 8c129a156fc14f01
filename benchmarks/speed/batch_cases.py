"""The comparisons of many wires at once, with one thread and with as many as there are cores."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from time import perf_counter

import numpy as np
from benchmarks.speed.compiled_wires import EXPLICIT_STEP_S, numba_batch
from benchmarks.speed.easier_wire import START
from benchmarks.speed.machine import usable_cores
from benchmarks.speed.measuring import PreparedComparison, TimedProgram
from benchmarks.speed.our_wire import different_wires

from musclewire.arrays import FloatArray

__all__ = ["batch_cases"]

WIRES, QUICK_WIRES = 10_000, 1_000
STEP_S, DURATION_S = 1e-2, 0.5
EXPLICIT_STEPS = round(STEP_S / EXPLICIT_STEP_S)
Explicit = Callable[[FloatArray, FloatArray, FloatArray, int], None]


def batch_cases() -> Iterator[PreparedComparison]:
    """Yield the comparisons of a step of 10 ms of one of many wires."""
    cores = usable_cores()
    differ = f"ours is one step of wires that all differ, theirs {EXPLICIT_STEPS} of an easier one"
    work = f"10 ms of one of {WIRES:,} wires (--quick: {QUICK_WIRES:,}), one thread; {differ}"
    loop = f"a Numba loop of explicit steps of {1e3 * EXPLICIT_STEP_S:g} ms"
    yield PreparedComparison("batch[numba]", work, loop, partial(batch_sides, numba_batch, 1))
    if cores > 1:
        work = f"10 ms of one of {WIRES:,} wires (--quick: {QUICK_WIRES:,}), {cores} threads; {differ}"
        sides = partial(batch_sides, numba_batch, cores)
        yield PreparedComparison(
            f"batch[numba,{cores} threads]", work, f"{loop}, in threads", sides, clock=perf_counter
        )


def batch_sides(explicit: Explicit, threads: int, quick: bool) -> tuple[TimedProgram, TimedProgram]:
    """Return both sides of a batch; a unit is 10 ms of one wire."""
    count = QUICK_WIRES if quick else WIRES
    voltages = np.linspace(1.0, 3.0, count)
    batch = different_wires(count, STEP_S, threads)
    kelvin, martensite = np.full(count, START[0]), np.full(count, START[1])
    units = count * DURATION_S / STEP_S
    cuts = [slice(count * part // threads, count * (part + 1) // threads) for part in range(threads)]
    pool = ThreadPoolExecutor(threads)

    def theirs(_: object) -> None:
        steps = round(DURATION_S / EXPLICIT_STEP_S)
        if threads == 1:
            explicit(kelvin, martensite, voltages, steps)
            return
        parts = [pool.submit(explicit, kelvin[cut], martensite[cut], voltages[cut], steps) for cut in cuts]
        for part in parts:
            part.result()

    return TimedProgram(lambda _: batch.advance(voltages, DURATION_S), units), TimedProgram(theirs, units)
