"""The limit of a step: operations and bytes it needs, what this machine does at its peak, and how near we come.

    python -m benchmarks.step_limit

Operations are counted by running the functions of the kernel as plain Python on numbers that count; a step is one
evaluation of both balances, as nearly all are. Bytes are those of the records' fields and of the table's cells that a
step reads and writes. A wire alone is limited by the chain of operations that wait for each other, many wires by how
many operations the machine does at all.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter
from statistics import median
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

KINDS = ("+", "*", "/", "compare")
FLAG = "NUMBA_DISABLE_JIT"
# Additions that pass while a chain waits for one division: 13 cycles to 4 on the processors that we know.
DIVISION = 3
WIRES, SAMPLES, STEPS = 4096, 20, 5


class Counted:
    """A number that counts what is done with it, and the length of the longest chain that led to it, in operations."""

    counts: ClassVar[Counter[str]] = Counter()

    def __init__(self, value: float, depth: int = 0) -> None:
        self.value, self.depth = float(value), depth

    def _with(self, other: Any, kind: str, value: float, *, cost: int = 1) -> Counted:
        Counted.counts[kind] += 1
        return Counted(value, max(self.depth, getattr(other, "depth", 0)) + cost)

    def __add__(self, other: Any) -> Counted:
        return self._with(other, "+", self.value + number(other))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Counted:
        return self._with(other, "+", self.value - number(other))

    def __rsub__(self, other: Any) -> Counted:
        return self._with(other, "+", number(other) - self.value)

    def __mul__(self, other: Any) -> Counted:
        return self._with(other, "*", self.value * number(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Counted:
        return self._with(other, "/", quotient(self.value, number(other)), cost=DIVISION)

    def __rtruediv__(self, other: Any) -> Counted:
        return self._with(other, "/", quotient(number(other), self.value), cost=DIVISION)

    def __neg__(self) -> Counted:
        return Counted(-self.value, self.depth)

    def __abs__(self) -> Counted:
        return Counted(abs(self.value), self.depth)

    def __int__(self) -> int:
        return int(self.value)

    def __float__(self) -> float:
        return self.value

    def _compared(self, truth: bool) -> bool:
        Counted.counts["compare"] += 1
        return truth

    def __lt__(self, other: Any) -> bool:
        return self._compared(self.value < number(other))

    def __gt__(self, other: Any) -> bool:
        return self._compared(self.value > number(other))

    def __le__(self, other: Any) -> bool:
        return self._compared(self.value <= number(other))

    def __ge__(self, other: Any) -> bool:
        return self._compared(self.value >= number(other))

    def __eq__(self, other: object) -> bool:
        return self._compared(self.value == number(other))

    __hash__ = None  # type: ignore[assignment]  # equal numbers may have come another way


def number(value: Any) -> float:
    """Return the plain number of a counted or a plain one."""
    return value.value if isinstance(value, Counted) else float(value)


def quotient(above: float, below: float) -> float:
    """Return a quotient as compiled code has it: not finite for a division by 0."""
    return above / below if below else float("inf")


class CountedRecord:
    """A record whose single numbers are counted; tables stay what they are."""

    def __init__(self, record: Any) -> None:
        for name in record.dtype.names:
            value = record[name]
            setattr(
                self,
                name,
                Counted(value)
                if value.ndim == 0
                else np.array([Counted(item) for item in value.ravel()], dtype=object),
            )

    def __repr__(self) -> str:
        return "CountedRecord"


def counted_step() -> tuple[Counter[str], int]:
    """Return the operations of one step of a wire on a spring in the middle of its transformation, and its chain."""
    from musclewire.parameters import load_alloy, load_bench, load_wire
    from musclewire.wire import (
        VOLTAGE,
        RunningWire,
        SourceOutput,
        accept_step,
        attempt,
        constants_from,
        drive_path,
        fixed_steps,
        instant_of,
    )

    wire = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
    _, state = drive_path(wire, np.full(40, 2.4), sample_s=0.05, stepping=fixed_steps(0.05))
    derived, cells, load = wire.step_arrays()
    table = derived[0]["convection_w_per_m2_k"]
    constants: Any = CountedRecord(derived[0])
    constants.convection_w_per_m2_k = table
    moving: Any = CountedRecord(state.row[0])
    running = RunningWire(moving, constants, cells[0], load[0])
    drive: Any = SourceOutput(Counted(2.5), VOLTAGE)
    started = instant_of(constants, drive, moving.resistance_ohm, moving.temperature_k)
    Counted.counts.clear()
    tried = attempt(running, drive, started, 0.01)
    accept_step(running, tried, started, 0.01)
    return Counter(Counted.counts), int(moving.carried_heat_j.depth)


def bytes_of_a_step() -> tuple[int, int]:
    """Return the bytes that a step reads and writes: single numbers of both records, and cells of two tables."""
    from musclewire.wire import StepConstants, WireState

    constants = sum(item.length is None for item in StepConstants.fields)
    state = sum(item.length is None for item in WireState.fields) + 2
    cells = 2 * 4 + 2 * 2  # two cubics of the distribution, two intervals of the air's table
    return 8 * (constants + state + cells), 8 * state


def counted_elsewhere() -> tuple[dict[str, int], int]:
    """Return the operations of a step and its longest chain, counted in a process that compiles nothing."""
    found = subprocess.run(
        [sys.executable, __file__, "--count"],
        env={**os.environ, FLAG: "1"},
        check=True,
        capture_output=True,
        text=True,
    )
    counts, chain = json.loads(found.stdout)
    return counts, chain


def measured_s() -> tuple[float, float]:
    """Return the time of a step of one wire alone, and of a step and wire of a batch on one thread [s], medians."""
    from musclewire.parameters import load_alloy, load_bench, load_wire
    from musclewire.wire import WireBatch, constants_from, drive_path, fixed_steps

    wire = constants_from(load_alloy("flexinol"), load_wire("paper-100um"), load_bench("paper"))
    drive = 0.3 + 1.45 * (1.0 - np.cos(2.0 * np.pi * (np.arange(1800) + 0.5) / 1800))
    ten_ms = fixed_steps(0.01)
    batch = WireBatch([wire] * WIRES, stepping=ten_ms, threads=1)
    alone, many = [], []
    for _ in range(9):
        began = perf_counter()
        drive_path(wire, drive, sample_s=0.05, stepping=ten_ms)
        alone.append((perf_counter() - began) / (len(drive) * STEPS))
        began = perf_counter()
        batch.drive(drive[900 : 900 + SAMPLES], 0.05, ())
        many.append((perf_counter() - began) / (WIRES * SAMPLES * STEPS))
    return median(alone[1:]), median(many[1:])


def main() -> None:
    """Count in a process of its own, measure here, and print both."""
    if sys.argv[1:] == ["--count"]:
        counts, chain = counted_step()
        print(json.dumps([counts, chain]))
        return
    from benchmarks.speed.machine import measured_machine

    counts, chain = counted_elsewhere()
    read, written = bytes_of_a_step()
    machine = measured_machine()
    alone_s, many_s = measured_s()
    arithmetic = counts["+"] + counts["*"]
    chain_ns = 1e9 * chain / machine.chained_flops_per_s
    vector_ns = 1e9 * (arithmetic + counts["compare"] + 8 * counts["/"]) / machine.vector_flops_per_s
    print(
        f"{machine.processor}, {machine.cores} cores; one thread: {machine.vector_flops_per_s / 1e9:.1f} G operations/s"
    )
    print(f"in vectors, {machine.chained_flops_per_s / 1e9:.2f} G/s one after the other")
    print(f"a step: {counts['+']} additions, {counts['*']} multiplications, {counts['/']} divisions, ", end="")
    print(f"{counts['compare']} comparisons; longest chain {chain} (a division counts as {DIVISION})")
    print(f"bytes a step: {read} read, {written} written, all in the nearest cache")
    print(f"{'':28}{'limit ns':>10}{'measured':>10}{'of limit':>10}")
    for name, limit, found in (
        ("one wire, the chain", chain_ns, 1e9 * alone_s),
        ("many wires, vector registers", vector_ns, 1e9 * many_s),
    ):
        print(f"{name:28}{limit:10.1f}{found:10.1f}{limit / found:10.2f}")


if __name__ == "__main__":
    main()
