"""How fast two checkouts simulate a wire, side by side: python checks/step_ratio.py BEFORE AFTER [--cold]

Both run their own ``benchmarks/step.py`` wire through the 90 s cycle, in turns, so that what else the machine does
falls on both alike; shown is the smallest CPU time of all turns. With --cold also the CPU time of `musclewire demo` in
a fresh environment, nothing compiled yet. Prints a table; run it on a machine with little else to do.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ONE_TURN = """
import json, time
import step

wire = step.our_wire()
start = step.resting_state(wire)

def us(dt_s, hold_s, parts):
    begin = time.process_time()
    step.our_cycle(wire, start, dt_s, hold_s)
    return 1e6 * (time.process_time() - begin) / parts

us(1e-3, 0.01, 1)
print(json.dumps({
    "a step of 1 ms [us]": min(us(1e-3, 0.2, 90_000) for _ in range(5)),
    "10 ms in steps of 1 ms, called from Python [us]": min(us(1e-3, 0.01, 9_000) for _ in range(5)),
}))
"""


def environment_of(checkout: Path, cache: Path | None = None) -> dict[str, str]:
    """Return an environment in which Python finds this checkout, and an own cache of kernels if one is given."""
    paths = os.pathsep.join(str(checkout / folder) for folder in ("src", ".", "benchmarks"))
    own = {} if cache is None else {"NUMBA_CACHE_DIR": str(cache)}
    return {**os.environ, "PYTHONPATH": paths, **own}


def one_turn(checkout: Path) -> dict[str, float]:
    """Return the times of one process."""
    done = subprocess.run(
        [sys.executable, "-c", ONE_TURN], env=environment_of(checkout), check=True, capture_output=True, text=True
    )
    return dict(json.loads(done.stdout))


def cold_demo(checkout: Path) -> dict[str, float]:
    """Return the CPU time of the demo with nothing compiled."""
    with tempfile.TemporaryDirectory() as folder:
        environment = environment_of(checkout, Path(folder) / "kernels")
        command = [sys.executable, "-m", "musclewire", "demo", "--out", str(Path(folder) / "demo")]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, env=environment, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {"demo, nothing compiled [s of CPU]": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}


def smallest(turns: list[dict[str, float]]) -> dict[str, float]:
    """Return the smallest of each time."""
    return {name: min(turn[name] for turn in turns) for name in turns[0]}


def main() -> None:
    """Measure both checkouts in turns and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path, help="checkout from before a change")
    parser.add_argument("after", type=Path, help="checkout with it")
    parser.add_argument("--turns", type=int, default=5, help="processes for each checkout")
    parser.add_argument("--cold", action="store_true", help="also the demo in a fresh environment, two turns each")
    arguments = parser.parse_args()
    measures = [(one_turn, arguments.turns)] + ([(cold_demo, 2)] if arguments.cold else [])
    print(f"{'':50}{'before':>10}{'after':>10}{'ratio':>8}")
    for measure, turns in measures:
        found: tuple[list[dict[str, float]], list[dict[str, float]]] = ([], [])
        for _ in range(turns):
            for checkout, times in zip((arguments.before, arguments.after), found, strict=True):
                times.append(measure(checkout.resolve()))
        before, after = smallest(found[0]), smallest(found[1])
        for name in before:
            print(f"{name:50}{before[name]:10.3f}{after[name]:10.3f}{after[name] / before[name]:8.2f}")


if __name__ == "__main__":
    main()
