"""One wire through time against SciPy on an easier wire, with the bars of the issue that made the step fast.

    python -m benchmarks.step

Ours is the whole wire: three phases with minor loops, heat in enthalpy form with Churchill and Chu's convection,
spring with guide friction, voltage divider, resistance. Theirs is what one writes with SciPy today
(``speed.easier_wire``). Both go through one 90 s cycle of the slow sine, in turns; each row compares the same stretch
of wire time. Open loop, SciPy chooses its own steps and returns the state every 10 ms; in closed loop the drive is new
every 10 ms, so either is called 9,000 times. ``musclewire bench`` compares more. Prints a table, or one JSON document
with --json; --quick takes fewer turns.
"""

from __future__ import annotations

import argparse
import json
import math
from time import thread_time

from benchmarks.speed.easier_wire import PERIOD_S, ScipyLoop, drive_v, scipy_cycle
from benchmarks.speed.our_wire import one_period

from musclewire.app import TimedProgram, comparison, cycle, paired_us, paper_wire
from musclewire.wire import CHOSEN, OneWire, StepControl, WireConstants, WireState, fixed_steps, resting_state

__all__ = ["our_cycle", "our_wire", "resting_state"]

CONTROL_PERIOD_S, SAMPLE_S = 0.01, 0.05
TURNS, QUICK_TURNS = 15, 5
# Cycles of ours in a turn: one takes less than a millisecond.
CYCLES = 10
PERIODS = round(PERIOD_S / CONTROL_PERIOD_S)


def our_wire() -> WireConstants:
    return paper_wire()


def our_cycle(wire: WireConstants, start: WireState, dt_s: float, hold_s: float) -> None:
    """Advance through the cycle in steps of ``dt_s``, holding the drive for ``hold_s``."""
    state, stepping = start, fixed_steps(dt_s)
    for number in range(round(PERIOD_S / hold_s)):
        state = one_period(state, wire, drive_v((number + 0.5) * hold_s), hold_s, stepping)
    assert math.isfinite(state.temperature_k)


def fixed(step_s: float) -> TimedProgram:
    """A fixed step of ours in one call; a unit is a step."""
    wire = our_wire()
    start = resting_state(wire)
    return TimedProgram(lambda _: cycle(wire, start, SAMPLE_S, fixed_steps(step_s)), PERIOD_S / step_s, repeats=CYCLES)


def chosen() -> TimedProgram:
    """A whole loop of ours at the rig's sample period, steps chosen by tolerance."""
    wire = our_wire()
    start = resting_state(wire)
    return TimedProgram(lambda _: cycle(wire, start, SAMPLE_S, CHOSEN), 1.0, repeats=CYCLES)


def called(stepping: StepControl) -> TimedProgram:
    """10 ms of ours, called from Python for each period; a unit is a call."""
    wire = our_wire()
    drives = [drive_v((number + 0.5) * CONTROL_PERIOD_S) for number in range(PERIODS)]

    def run(running: OneWire) -> None:
        for voltage_v in drives:
            running.advance(voltage_v, CONTROL_PERIOD_S, stepping)

    return TimedProgram(run, PERIODS, lambda: OneWire(wire))


def theirs_open(unit_s: float) -> TimedProgram:
    """One call of SciPy's over the whole cycle, the state every 10 ms; a unit is so much wire time."""
    return TimedProgram(lambda _: scipy_cycle(CONTROL_PERIOD_S), PERIOD_S / unit_s)


def theirs_called() -> TimedProgram:
    """A call of SciPy's for each period; a unit is a call."""

    def run(loop: ScipyLoop) -> None:
        for number in range(PERIODS):
            loop.advance(drive_v(number * CONTROL_PERIOD_S))

    return TimedProgram(run, PERIODS, lambda: ScipyLoop(CONTROL_PERIOD_S))


def measured(turns: int) -> list[dict[str, object]]:
    """Return the rows of the table."""
    each = "a call each"
    rows = [
        ("one step of 10 ms, open loop", "10 ms of wire time", fixed(1e-2), theirs_open(1e-2), 0.12, None),
        ("one step of 1 ms, open loop", "1 ms of wire time", fixed(1e-3), theirs_open(1e-3), 0.12, None),
        ("90 s in samples of 50 ms, steps chosen", "90 s of wire time", chosen(), theirs_open(PERIOD_S), 300.0, 25.0),
        ("10 ms in one step, called from Python", each, called(fixed_steps(1e-2)), theirs_called(), 1.5, 40.0),
        (
            "10 ms in steps of 1 ms, called from Python",
            "a call each",
            called(fixed_steps(1e-3)),
            theirs_called(),
            None,
            None,
        ),
    ]
    answer = []
    for name, work, ours, theirs, bar_us, bar_ratio in rows:
        row = comparison(name, work, "SciPy LSODA", paired_us(ours, theirs, turns, thread_time))
        found = {"name": name, "ours_us": row.ours_us, "theirs_us": row.theirs_us, "theirs": f"{row.theirs}, {work}"}
        answer.append({**found, "ratio": row.ratio, "bar_us": bar_us, "bar_ratio": bar_ratio})
    return answer


def bar_text(row: dict[str, object]) -> str:
    """Return what the issue asks of a row."""
    bars = [f"at most {row['bar_us']:g} us"] if row["bar_us"] else []
    bars += [f"at least {row['bar_ratio']:g} times"] if row["bar_ratio"] else []
    return f"   (bar: {', '.join(bars)})" if bars else ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer turns")
    parser.add_argument("--json", action="store_true", help="one JSON document instead of a table")
    arguments = parser.parse_args()
    rows = measured(QUICK_TURNS if arguments.quick else TURNS)
    if arguments.json:
        print(json.dumps({"rows": rows}, indent=2))
        return
    print(f"{'one wire':44}{'ours us':>10}{'theirs us':>12}{'ratio':>8}  theirs")
    for row in rows:
        print(
            f"{row['name']:44}{row['ours_us']:10.3f}{row['theirs_us']:12.3f}{row['ratio']:8.1f}  "
            f"{row['theirs']}{bar_text(row)}"
        )


if __name__ == "__main__":
    main()
