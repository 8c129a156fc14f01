"""What a simulated step costs, as a ratio to fixed work in the same process, beside the ratios on record.

    python checks/step_cost.py                       compares, exit code 1 where a step is much dearer
    python checks/step_cost.py --record "why"        adds what it finds to checks/step_cost.toml

Seconds say as much about the machine and its other programs as about the code; a ratio to work whose lines never change
says what the code costs. The fixed work is compiled arithmetic for what runs compiled, plain Python and NumPy for what
is called from Python. Both run in turns, by the processor time of the thread, so that a turn in which other programs
run counts like any other; shown is the median of the turns' ratios. What seems dearer is measured again, twice at most,
and the smallest ratio counts. From ``WARNED`` on the answer is a warning, from ``FAILED`` on an exit code
(docs/explanation/decisions/dependencies.md says why so).
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import tomllib
from collections.abc import Callable
from datetime import date
from functools import partial
from pathlib import Path
from time import thread_time
from typing import Any

import numba
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmarks.speed.machine import processor_name  # noqa: E402
from benchmarks.speed.measuring import TimedProgram, paired_us  # noqa: E402
from benchmarks.speed.our_wire import PERIOD_S, cycle, drive_v, paper_wire  # noqa: E402

from musclewire.arrays import FloatArray  # noqa: E402
from musclewire.rigs import GuardedRig, open_rig  # noqa: E402
from musclewire.signals import Drive  # noqa: E402
from musclewire.wire import CHOSEN, ConnectorLoad, OneWire, fixed_steps, resting_state  # noqa: E402

RECORDS = Path(__file__).with_name("step_cost.toml")
# A step that has become dearer by this is seen by whoever reads the run, and by the larger one the run ends. Repeated
# runs differ by 1 % alone on a machine and by 5 % next to three busy programs, and by more on another processor.
WARNED, FAILED = 0.07, 0.20
TURNS = 31
ATTEMPTS = 3
SAMPLE_S = 0.05
ARITHMETIC_ROUNDS, PYTHON_ROUNDS = 100_000, 2_000


def arithmetic(rounds: int, table: FloatArray) -> float:
    """Do what a step consists of, so many times: products, quotients, roots, exponentials, a table, comparisons.

    These lines must not change: every ratio on record is to them.
    """
    value, other = 0.3, 1.7
    for number in range(rounds):
        place = 10.0 * value
        index = min(int(place), table.shape[0] - 2)
        found = table[index] + (place - index) * (table[index + 1] - table[index])
        other = 0.5 * (other + (2.0 + found) / (1.0 + other * other))
        other += 1e-3 * math.exp(-value * found) + 1e-4 * math.sqrt(1.0 + found * found)
        if other > 1.2 + 1e-6 * (number % 7):
            value = min(value + 0.37 * other, 9.0 - value)
        else:
            value = max(value - 0.11, 0.05)
        value = abs(value - 5.0 * math.floor(0.2 * value))
    return value + other


# Without a cache on disk: that of the package is named by its own sources only.
fixed_arithmetic: Any = numba.njit(error_model="numpy")(arithmetic)


class Fixed:
    """State of the fixed work in Python."""

    __slots__ = ("numbers", "total")

    def __init__(self) -> None:
        """Start at nothing."""
        self.numbers = np.zeros(64)
        self.total = 0.0


def fixed_python(rounds: int) -> None:
    """Do what a call from Python consists of, so many times: objects, attributes, tuples, copies of small arrays.

    These lines must not change: every ratio on record is to them.
    """
    state = Fixed()
    for number in range(rounds):
        after = Fixed()
        after.numbers = state.numbers.copy()
        after.numbers[number % 64] = 0.5 * number
        values = (state.total, float(after.numbers[3]), number)
        after.total = round(min(max(values[0] + 1e-3 * values[1], -1.0), 1.0), 9)
        state = after


def arithmetic_side() -> TimedProgram:
    """Return the fixed compiled work in units of a round."""
    table = np.linspace(0.0, 1.0, 101) ** 2
    return TimedProgram(lambda _: fixed_arithmetic(ARITHMETIC_ROUNDS, table), ARITHMETIC_ROUNDS)


def python_side() -> TimedProgram:
    """Return the fixed work in Python in units of a round."""
    return TimedProgram(lambda _: fixed_python(PYTHON_ROUNDS), PYTHON_ROUNDS)


def step_side(step_s: float, load: ConnectorLoad | None = None) -> TimedProgram:
    """Return a step along the slow sine; a unit is a step."""
    wire = paper_wire(load)
    start = resting_state(wire)
    return TimedProgram(lambda _: cycle(wire, start, SAMPLE_S, fixed_steps(step_s)), PERIOD_S / step_s)


def spring_and_stop() -> ConnectorLoad:
    """Return a load with a table: the bench's spring, and a second one that begins to pull after 1 mm."""
    displacement_m = np.linspace(0.0, 5e-3, 501)
    force_n = 200.0 * np.maximum(displacement_m - 1e-3, 0.0)
    return ConnectorLoad(588.6, float(displacement_m[1]), force_n, np.zeros_like(force_n))


def period_side() -> TimedProgram:
    """Return 10 ms of wire time called from Python; a unit is a call."""
    wire = paper_wire()
    voltages = [drive_v(20.0 + 0.01 * number) for number in range(400)]

    def run(wire: OneWire) -> None:
        for voltage_v in voltages:
            wire.advance(voltage_v, 0.01, CHOSEN)

    return TimedProgram(run, len(voltages), partial(OneWire, wire))


def exchange_side() -> TimedProgram:
    """Return a sample of the default rig; a unit is an exchange."""
    drives = [Drive(drive_v(20.0 + SAMPLE_S * number)) for number in range(100)]

    def run(rig: GuardedRig) -> None:
        for drive in drives:
            rig.exchange(drive)
        rig.close()

    return TimedProgram(run, len(drives), partial(open_rig, "simulated"))


# What is measured, and the fixed work that it is a ratio to.
MEASURED: dict[str, tuple[Callable[[], TimedProgram], Callable[[], TimedProgram]]] = {
    "step of 1 ms": (partial(step_side, 1e-3), arithmetic_side),
    "step of 10 ms": (partial(step_side, 1e-2), arithmetic_side),
    "step of 10 ms, load with a table": (lambda: step_side(1e-2, spring_and_stop()), arithmetic_side),
    "10 ms called from Python": (period_side, python_side),
    "exchange of the default rig": (exchange_side, python_side),
}


def cost_ratio(name: str, turns: int) -> float:
    """Return how many rounds of its fixed work a measured item takes, median of the turns."""
    ours, fixed = MEASURED[name]
    pairs = paired_us(ours(), fixed(), turns, clock=thread_time)
    return statistics.median(our_us / fixed_us for our_us, fixed_us in pairs)


def records() -> list[dict[str, Any]]:
    """Return every record of the file, the oldest first."""
    return list(tomllib.loads(RECORDS.read_text("utf-8")).get("record", []))


def last_ratios(processor: str) -> tuple[dict[str, float], str]:
    """Return the newest ratios for a processor, or those of another one, and whose and when in words."""
    known = records()
    own = [record for record in known if record["processor"] == processor]
    if not known:
        return {}, "nothing is on record"
    newest = (own or known)[-1]
    return dict(newest["ratios"]), f"{newest['processor']}, {newest['date']}: {newest['why']}"


def measured_ratio(name: str, recorded: float | None, turns: int) -> float:
    """Return an item's ratio; measured again while it seems dearer than on record, and then the smallest."""
    ratio = cost_ratio(name, turns)
    for _ in range(ATTEMPTS - 1):
        if recorded is None or ratio <= (1.0 + WARNED) * recorded:
            break
        ratio = min(ratio, cost_ratio(name, turns))
    return ratio


def record_text(ratios: dict[str, float], processor: str, why: str) -> str:
    """Return a record as lines of TOML."""
    lines = ["[[record]]", f'date = "{date.today()}"', f"processor = {json.dumps(processor)}"]
    lines += [f"why = {json.dumps(why)}", "[record.ratios]"]
    lines += [f"{json.dumps(name)} = {ratio:.4g}" for name, ratio in ratios.items()]
    return "\n".join(["", *lines, ""])


def verdict(change: float | None, same_processor: bool) -> str:
    """Return in words what a change of the ratio means."""
    if change is None:
        return "not on record"
    if change <= WARNED:
        return "" if change > -WARNED else "cheaper: record it (--record)"
    if not same_processor:
        return "WARNING: dearer, but on record for another processor"
    return "WARNING: dearer" if change <= FAILED else "FAILED: much dearer"


def main() -> int:
    """Measure, compare, print; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--turns", type=int, default=TURNS, help="turns of each measurement")
    parser.add_argument("--record", metavar="WHY", help="add the ratios to the record, with the reason for the change")
    arguments = parser.parse_args()
    processor = processor_name()
    recorded, whose = last_ratios(processor)
    same = whose.startswith(f"{processor},")
    print(f"{'rounds of the fixed work':36}{'now':>9}{'on record':>11}{'change':>9}   on record: {whose}")
    ratios, failed = {}, False
    for name in MEASURED:
        before = recorded.get(name)
        ratios[name] = now = measured_ratio(name, before, arguments.turns)
        change = None if before is None else now / before - 1.0
        said = verdict(change, same)
        failed |= said.startswith("FAILED")
        shown = f"{'-':>11}{'-':>9}" if change is None else f"{before:11.4g}{100 * change:+8.1f}%"
        print(f"{name:36}{now:9.4g}{shown}   {said}")
    if arguments.record:
        with RECORDS.open("a", encoding="utf-8") as file:
            file.write(record_text(ratios, processor, arguments.record))
        return 0
    if failed:
        print("a step costs much more than on record: find out why, or record the new cost and its reason (--record)")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
