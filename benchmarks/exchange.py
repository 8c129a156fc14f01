"""What one exchange with the default simulated rig costs: physics, instruments and protection, no recorder.

The rig goes through cycles of the paper's slow sine, so that the wire transforms in most samples. Prints JSON: wall
time of ``rig.exchange`` and its CPU time on this thread, with the bar of 25 us for the median; the part of the device
(physics and instruments) and that of the protection around it; the median also in units of a fixed workload that is
measured in the same process (``fixed_work.py``). ``--quick`` takes one cycle. Exit code 1 where the bar is not met in a
run that is not quick.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from array import array

import numpy as np
from fixed_work import fixed_work_us

import musclewire as mw
from musclewire.experiment import slow_sine
from musclewire.rigs import GuardedRig
from musclewire.signals import Drive

BAR_US = 25.0
PERIOD_S = 90.0
CYCLES = 20
PERCENTILES = {"p50": 50.0, "p99": 99.0, "p999": 99.9}


def exchanged(rig: GuardedRig, cycles: int) -> dict[str, array[int]]:
    """Drive a rig through slow sines and return times of each exchange [ns]."""
    waveform = slow_sine(rig.drive_amplitude_v, rig.sense_voltage_v, PERIOD_S)
    samples = round(PERIOD_S / rig.sample_period_s)
    commands = [Drive(waveform(index * rig.sample_period_s)) for index in range(samples)]
    times: dict[str, array[int]] = {name: array("q") for name in ("wall", "cpu", "device")}
    for command in commands * cycles:
        cpu_ns, wall_ns = time.thread_time_ns(), time.perf_counter_ns()
        rig.exchange(command)
        times["wall"].append(time.perf_counter_ns() - wall_ns)
        times["cpu"].append(time.thread_time_ns() - cpu_ns)
        times["device"].append(rig.sample_at_ns - rig.drive_at_ns)
    return times


def percentiles_us(times_ns: np.ndarray) -> dict[str, float]:
    """Return the percentiles of times [us]."""
    found = np.percentile(times_ns / 1e3, list(PERCENTILES.values()))
    return {name: round(float(value), 2) for name, value in zip(PERCENTILES, found, strict=True)}


def measured(cycles: int) -> dict[str, object]:
    """Return the figures."""
    with mw.open_rig("simulated") as rig:
        exchanged(rig, 1)  # compiles or loads, and warms up
        fixed_us = fixed_work_us()
        times = {name: np.array(values, dtype=np.float64) for name, values in exchanged(rig, cycles).items()}
        fixed_us = min(fixed_us, fixed_work_us())
    wall = percentiles_us(times["wall"])
    return {
        "samples": times["wall"].size,
        "exchange_us": wall,
        "exchange_cpu_us": percentiles_us(times["cpu"]),
        "device_us": percentiles_us(times["device"]),
        "protection_us": percentiles_us(times["wall"] - times["device"]),
        "fixed_work_us": round(fixed_us, 2),
        "exchange_per_fixed_work": round(wall["p50"] / fixed_us, 3),
        "bar_p50_us": BAR_US,
        "bar_met": wall["p50"] <= BAR_US,
    }


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="one cycle")
    quick = parser.parse_args().quick
    answer = measured(1 if quick else CYCLES)
    print(json.dumps(answer, indent=2))
    return 0 if answer["bar_met"] or quick else 1


if __name__ == "__main__":
    sys.exit(main())
