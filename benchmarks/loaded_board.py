"""Runs on the emulated Arduino Uno while every core of this machine is busy: how many a fault ends, and which.

    python -m benchmarks.loaded_board [--runs 100] [--quick]

A run drives the wire up and down by the clock for 10 s. A host that a busy machine makes late must not count as a
device whose clock is wrong, nor may what comes late heat the estimate to its limit. Exit code 1 if a fault ended a run.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import sys
import tempfile
from collections import Counter
from pathlib import Path

from emulation.board import EmulatedBoard, rig_file_text

from musclewire.rigs import GuardedRig, ProtectionTripError, open_rig

RUNS, QUICK_RUNS, RUN_S = 100, 3, 10.0
COLD_K = 295.15


def busy() -> None:
    """Keep a core busy."""
    while True:
        pass


def ended(rig: GuardedRig) -> str:
    """Drive a run; return the event that ended it, "" for a sound one."""
    samples = round(RUN_S / rig.sample_period_s)
    swing_v = 0.5 * (rig.drive_amplitude_v - rig.sense_voltage_v)
    try:
        with rig:
            for sample in range(samples):
                rig.exchange(rig.sense_voltage_v + swing_v * (1.0 - math.cos(4.0 * math.pi * sample / samples)))
    except ProtectionTripError as trip:
        return trip.event.name.lower()
    return ""


def main() -> int:
    """Run, print, and return the exit code."""
    parser = argparse.ArgumentParser(description="Runs of the emulated Uno on a busy machine.")
    parser.add_argument("--runs", type=int, default=None)
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    runs = given.runs or (QUICK_RUNS if given.quick else RUNS)
    others = [multiprocessing.Process(target=busy, daemon=True) for _ in range(os.cpu_count() or 1)]
    for one in others:
        one.start()
    faults: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder, EmulatedBoard(board="arduino-uno") as board:
        path = Path(folder) / "uno.toml"
        path.write_text(rig_file_text("arduino-uno", "paper-100um", board.port_url), "utf-8")
        for number in range(runs):
            faults[ended(open_rig(path, wire_temperature_k=COLD_K if number == 0 else None))] += 1
    for one in others:
        one.terminate()
    sound = faults.pop("")
    said = ", ".join(f"{count} {event}" for event, count in faults.items())
    print(f"{sound} of {runs} runs of {RUN_S:g} s on {len(others)} busy cores without a fault; {said or 'no fault'}")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
