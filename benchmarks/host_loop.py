"""The closed loop at 1 kHz on the simulated rig, in real time: the host's own time, drift, missed deadlines, jitter.

Prints JSON. The host's own time is all that it does between a sample and the next drive: policy (resistance, estimate,
tracking, fuzzy PID), protection and recorder; the simulated wire is the plant and not counted. ``cpu_us`` is that time
by the clock of the thread's CPU time, which stands still while another program has the core; its bars are 25 us at the
median and 45 us at the 99th percentile. ``compute_us`` is the same by the wall's clock. ``back_to_back_cpu_us`` is the
CPU time of a loop that waits for no clock, with all it needs in the nearest caches: what other programs leave in them
meanwhile makes the difference. Its median also in units of a fixed workload that is measured in the same process
(``fixed_work.py``).

The loop records to a file, in a temporary folder or where ``--output`` says; ``--memory`` goes without. ``--seconds``
and ``--quick`` (ten seconds) run shorter than ten minutes. Real-time priority is taken where the system permits it
(``--ordinary`` goes without), ``--cpu`` keeps the loop on one core. Exit code 1 where a bar is not met in a run that is
not quick.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import sys
import time
from array import array
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from fixed_work import fixed_work_us

import musclewire as mw
from musclewire.controllers import staircase
from musclewire.experiment import ControlRun, timing_json
from musclewire.rigs import Answer, Device, pin_to_cpu, take_priority
from musclewire.signals import Command

PERIOD_S = 1e-3
BARS_US = {"p50": 25.0, "p99": 45.0}
PERCENTILES = {"p50": 50.0, "p90": 90.0, "p99": 99.0, "p999": 99.9}
APPROACH_S = 2.0
BACK_TO_BACK_S = 30.0
STEPS = 11


class Collections:
    """Watches the garbage collector: how often it ran and how long at most."""

    def __init__(self) -> None:
        """Start to watch."""
        self.count, self.longest_us, self._began_s = 0, 0.0, 0.0
        gc.callbacks.append(self)

    def __call__(self, phase: str, _facts: dict[str, int]) -> None:
        """Take down one collection."""
        if phase == "start":
            self._began_s = time.perf_counter()
            return
        self.count += 1
        self.longest_us = max(self.longest_us, 1e6 * (time.perf_counter() - self._began_s))


class TimedDevice:
    """A device that notes the thread's CPU time between its sample and the next drive; otherwise the one it holds."""

    def __init__(self, device: Device) -> None:
        """Hold a device; no sample yet."""
        self._device = device
        self._sample_at_ns: int | None = None
        self.host_ns = array("q")

    def __getattr__(self, name: str) -> Any:
        """Return what the held device has."""
        return getattr(self._device, name)

    def exchange(self, command: Command) -> Answer:
        """Let the held device exchange."""
        drive_at_ns = time.thread_time_ns()
        if self._sample_at_ns is not None:
            self.host_ns.append(drive_at_ns - self._sample_at_ns)
        answer = self._device.exchange(command)
        self._sample_at_ns = time.thread_time_ns()
        return answer


def fitted() -> mw.SensingModel:
    """Return the model of the paper's wire."""
    with mw.open_rig("simulated") as rig:
        return mw.fit(mw.characterize(rig))


def run_at_1_khz(
    model: mw.SensingModel, seconds: float, path: Path | None, *, paced: bool = True
) -> tuple[ControlRun, TimedDevice, Collections]:
    """Return a closed loop of so many seconds at 1 kHz, its device, and what the garbage collector did meanwhile."""
    hold_s = (seconds - APPROACH_S) / STEPS
    with mw.open_rig("simulated", sample_period_s=PERIOD_S, real_time=paced) as rig:
        device = rig.device = TimedDevice(rig.device)
        reference = staircase(hold_s=hold_s)
        watched = Collections()
        run = mw.control(rig, model, reference, approach_s=APPROACH_S, path=path, overwrite=True)
        gc.callbacks.remove(watched)
    return run, device, watched


def cpu_percentiles_us(device: TimedDevice) -> dict[str, float]:
    """Return the percentiles of the host's CPU time between a sample and the next drive [us]."""
    found = np.percentile(np.array(device.host_ns, dtype=np.float64) / 1e3, list(PERCENTILES.values()))
    return {name: round(float(value), 1) for name, value in zip(PERCENTILES, found, strict=True)}


def back_to_back(model: mw.SensingModel) -> dict[str, Any]:
    """Return the host's own times in a loop that waits for no clock, and the fixed workload in the same process."""
    before_us = fixed_work_us()
    _, device, _ = run_at_1_khz(model, BACK_TO_BACK_S, None, paced=False)
    fixed_us, cpu_us = min(before_us, fixed_work_us()), cpu_percentiles_us(device)
    return {
        "back_to_back_cpu_us": cpu_us,
        "fixed_work_us": round(fixed_us, 2),
        "back_to_back_per_fixed_work": round(cpu_us["p50"] / fixed_us, 3),
    }


def measured(model: mw.SensingModel, seconds: float, path: Path | None, refused: list[str]) -> dict[str, Any]:
    """Return all figures of one run."""
    near, before = back_to_back(model), os.getloadavg()
    run, device, watched = run_at_1_khz(model, seconds, path)
    cpu_us = cpu_percentiles_us(device)
    return {
        "samples": len(run),
        "rate_hz": 1.0 / PERIOD_S,
        "seconds": run.duration_s + PERIOD_S,
        "cpu_us": cpu_us,
        "bars_cpu_us": BARS_US,
        "bars_met": all(cpu_us[name] <= bar_us for name, bar_us in BARS_US.items()),
        **near,
        **timing_json(run.metadata),
        "collections": watched.count,
        "longest_collection_us": round(watched.longest_us, 1),
        "real_time_priority": not refused,
        "refused": refused,
        "recorded_to": "memory" if path is None else "file",
        "cores": os.cpu_count(),
        "load_before": before,
        "load_after": os.getloadavg(),
        "mae_mean_pct": run.metrics.mae_mean_pct,
        "mae_mean_approached_pct": run.metrics.mae_mean_approached_pct,
        "approach_s": run.metrics.approach_s,
        "valid_share": run.metrics.valid_share,
    }


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--ordinary", action="store_true")
    parser.add_argument("--cpu", type=int)
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--output", type=Path)
    where.add_argument("--memory", action="store_true")
    arguments = parser.parse_args()
    model = fitted()
    if arguments.cpu is not None:
        pin_to_cpu(arguments.cpu)
    refused = ["not asked for"] if arguments.ordinary else take_priority()
    with TemporaryDirectory() as folder:
        path = None if arguments.memory else arguments.output or Path(folder) / "run.h5"
        answer = measured(model, 10.0 if arguments.quick else arguments.seconds, path, refused)
    print(json.dumps(answer, indent=2))
    return 0 if answer["bars_met"] or arguments.quick else 1


if __name__ == "__main__":
    sys.exit(main())
