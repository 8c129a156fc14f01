"""How late a wait ends: a plain sleep, sharp timers, the last stretch awake; each with and without priority.

Prints JSON: [{wait, priority, cpu_share, late_us: {p50, p99, p999}}] for waits of 1 ms. ``--quick`` makes fewer waits.
Each way is tried in a process of its own, because a timer slack stays.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time

import numpy as np

from musclewire.rigs import take_priority, wake_on_time

PERIOD_S = 1e-3
WAYS = {"sleep": (False, 0.0), "sharp timer": (True, 0.0), "spin 0.1 ms": (True, 1e-4), "spin 0.2 ms": (True, 2e-4)}


def measured(way: str, priority: bool, waits: int) -> dict[str, object]:
    """Return how late waits on an absolute grid ended."""
    sharp, spin_s = WAYS[way]
    if sharp:
        wake_on_time()
    refused = take_priority() if priority else []
    late = np.empty(waits)
    busy_s = time.process_time()
    start_s = time.monotonic()
    for index in range(waits):
        due_s = start_s + (index + 1) * PERIOD_S
        left_s = due_s - spin_s - time.monotonic()
        if left_s > 0.0:
            time.sleep(left_s)
        while time.monotonic() < due_s:
            pass
        late[index] = time.monotonic() - due_s
    fraction = (time.process_time() - busy_s) / (waits * PERIOD_S)
    p50, p99, p999 = np.percentile(1e6 * late, [50.0, 99.0, 99.9])
    return {
        "wait": way,
        "priority": "refused" if refused else priority,
        "cpu_share": round(fraction, 3),
        "late_us": {"p50": round(p50, 1), "p99": round(p99, 1), "p999": round(p999, 1)},
    }


def main() -> None:
    """Try every way."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        way, priority, waits = arguments.one
        print(json.dumps(measured(way, priority == "True", int(waits))))
        return
    waits = 500 if arguments.quick else 5000
    rows = []
    for priority in (False, True):
        for way in WAYS:
            command = [sys.executable, __file__, "--one", way, str(priority), str(waits)]
            rows.append(json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout))
    print(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
