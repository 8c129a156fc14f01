"""How long a user waits: `musclewire --help` compared with a bare interpreter, warm, as whole processes.

The bar is 0.3 s. Prints a table, or one JSON document with --json; --quick takes fewer runs.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time

HELP_BAR_S = 0.3


def seconds(command: list[str], runs: int) -> list[float]:
    """Return the wall time of each of ``runs`` whole processes, after one that is not counted."""
    times = []
    for _ in range(runs + 1):
        start = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        times.append(time.perf_counter() - start)
    return times[1:]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    runs = 5 if arguments.quick else 21
    ours = statistics.median(seconds([sys.executable, "-m", "musclewire", "--help"], runs))
    bare = statistics.median(seconds([sys.executable, "-c", "pass"], runs))
    row = {
        "name": "musclewire --help",
        "ours_us": 1e6 * ours,
        "theirs_us": 1e6 * bare,
        "theirs": "bare interpreter",
        "ratio": bare / ours,
        "bar_us": 1e6 * HELP_BAR_S,
    }
    if arguments.json:
        print(json.dumps({"rows": [row]}, indent=2))
    else:
        print(f"musclewire --help {ours:.3f} s (bar {HELP_BAR_S} s), bare interpreter {bare:.3f} s, {runs} runs")


if __name__ == "__main__":
    main()
