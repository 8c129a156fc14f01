"""How long a user waits: `musclewire --help`, warm, beside a bare interpreter; and compiling in a first demo.

The bars are 0.3 s for the help and 8 s for compiling, from an empty cache, on a machine that does nothing else. The
demo's seconds are of its processor; the package is the one that PYTHONPATH or the environment names, so that two
checkouts are compared by two runs. Prints a table, or one JSON document with --json; --quick takes fewer runs of the
help; --functions prints the functions that took longest.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

HELP_BAR_S, COMPILING_BAR_S = 0.3, 8.0
# In a process of its own: every event of Numba's compiler while the demo runs, less those within it.
COLD_DEMO = """
import json, sys, time
from pathlib import Path
import numba.core.event as events

class Compilations(events.Listener):
    def __init__(self):
        self.open, self.taken = [], []
    def on_start(self, event):
        self.open.append([time.process_time(), 0.0])
    def on_end(self, event):
        began_s, within_s = self.open.pop()
        whole_s = time.process_time() - began_s
        if self.open:
            self.open[-1][1] += whole_s
        self.taken.append((whole_s - within_s, event.data["dispatcher"].py_func.__qualname__))

compilations = Compilations()
events.register("numba:compile", compilations)
from musclewire.experiment import run_demo
run_demo(Path(sys.argv[1]))
print(json.dumps(sorted(compilations.taken, reverse=True)))
"""


def seconds(command: list[str], runs: int) -> list[float]:
    """Return the wall time of each of ``runs`` whole processes, after one that is not counted."""
    times = []
    for _ in range(runs + 1):
        start = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        times.append(time.perf_counter() - start)
    return times[1:]


def compiled_in_a_cold_demo() -> list[tuple[float, str]]:
    """Return seconds and name of every function that a demo compiles from an empty cache, the longest first."""
    with TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(Path(folder) / "cache")}
        command = [sys.executable, "-c", COLD_DEMO, str(Path(folder) / "demo")]
        done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    return [(taken_s, name) for taken_s, name in json.loads(done.stdout.splitlines()[-1])]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--functions", type=int, default=0, metavar="N")
    arguments = parser.parse_args()
    runs = 5 if arguments.quick else 21
    ours = statistics.median(seconds([sys.executable, "-m", "musclewire", "--help"], runs))
    bare = statistics.median(seconds([sys.executable, "-c", "pass"], runs))
    compiled = compiled_in_a_cold_demo()
    compiling_s = sum(taken_s for taken_s, _ in compiled)
    rows = [
        {
            "name": "musclewire --help",
            "ours_us": 1e6 * ours,
            "theirs_us": 1e6 * bare,
            "theirs": "bare interpreter",
            "ratio": bare / ours,
            "bar_us": 1e6 * HELP_BAR_S,
        },
        {
            "name": "compiling in a cold demo",
            "ours_us": 1e6 * compiling_s,
            "functions": len(compiled),
            "bar_us": 1e6 * COMPILING_BAR_S,
        },
    ]
    if arguments.json:
        print(json.dumps({"rows": rows}, indent=2))
        return
    print(f"musclewire --help {ours:.3f} s (bar {HELP_BAR_S} s), bare interpreter {bare:.3f} s, {runs} runs")
    print(f"compiling in a cold demo {compiling_s:.2f} s (bar {COMPILING_BAR_S:g} s), {len(compiled)} functions")
    for taken_s, name in compiled[: arguments.functions]:
        print(f"{taken_s:8.3f} s  {name}")


if __name__ == "__main__":
    main()
