"""A study of 20,000 characterizations: on local cores, on a Dask cluster of processes, and with workers killed.

    python benchmarks/sweep.py [--runs 20000] [--kill-every 3] [--kills 10] [--only local|cluster|killed]

A run is one cycle of the slow sine of 90 s on a wire of its own; the gap and the extremes of its resistance are kept.
Prints the seconds of each way (the whole command, with the data set, its indices and its page, for local cores), and
whether the numbers are the same to the bit. The cluster is dask_cluster.py of tests/extras/studies: a scheduler and
two workers.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "extras" / "studies"))

from dask_cluster import DaskCluster

from musclewire.experiment import cores
from musclewire.extras.studies import StudyResult, Workers, read_study, sweep, write_study


def study_of(runs: int) -> dict[str, Any]:
    """Return the study: six numbers of wire, alloy and bench vary."""
    return {
        "format": "musclewire-study",
        "version": 1,
        "name": "20,000 characterizations",
        "run": {
            "kind": "characterize",
            "cycles": 1,
            "period": "90 s",
            "keep": ["strain_gap", "resistance_min_ohm", "resistance_max_ohm"],
        },
        "sampling": {"method": "latin-hypercube", "samples": runs},
        "parameters": {
            "pretension": {"low": "1.2 N", "high": "2.4 N"},
            "diameter_m": {"low": "0.098 mm", "high": "0.102 mm"},
            "ambient_temperature": {"distribution": "normal", "mean": "22 degC", "std": "2 K"},
            "martensite_temperature_k": {"distribution": "normal", "mean": 320.0, "std": 2.0},
            "martensite_barrier_k": {"low": 7.0, "high": 9.0},
            "convection_factor": {"distribution": "normal", "mean": 0.9, "std": 0.03},
        },
    }


def same(one: StudyResult, other: StudyResult) -> bool:
    """Return whether two results are equal to the bit."""
    return one.errors == other.errors and all(
        one.columns[name].tobytes() == other.columns[name].tobytes() for name in one.columns
    )


def processor_s() -> float:
    """Return the processor time of this process and of those that it has waited for [s]."""
    parts = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(part.ru_utime + part.ru_stime for part in parts)


def locally(study: dict[str, Any]) -> StudyResult:
    """Run the study on local cores, as the command does, and print its time."""
    started = time.perf_counter()
    plan, before_s = read_study(study), processor_s()
    with tempfile.TemporaryDirectory() as folder:
        result = sweep(plan, Path(folder) / "study")
        evaluated = time.perf_counter() - started
        write_study(result, Path(folder) / "study")
    whole = time.perf_counter() - started
    print(f"local cores: {evaluated:.1f} s to evaluate {len(result)} runs, {whole:.1f} s with data set, indices, page; "
          f"{processor_s() - before_s:.1f} s of processor time on {cores()} cores, load {os.getloadavg()[0]:.1f}; "
          f"{result.failed} failed", flush=True)  # fmt: skip
    return result


def on_cluster(study: dict[str, Any], kill_every_s: float, kills: int) -> StudyResult:
    """Run the study on a cluster of two workers; the older one is killed every so many seconds, so many times."""
    done = threading.Event()
    with tempfile.TemporaryDirectory() as folder, DaskCluster(Path(folder)) as cluster:

        def kill() -> None:
            while cluster.killed < kills and not done.wait(kill_every_s):
                cluster.kill_a_worker()

        killer = threading.Thread(target=kill)
        started = time.perf_counter()
        killer.start()
        try:
            workers = Workers(scheduler=cluster.address, retries=50)
            result = sweep(study, Path(folder) / "study", workers=workers)
        finally:
            done.set()
            killer.join()
        took = time.perf_counter() - started
        print(f"Dask cluster of 2 workers, {cluster.killed} killed: {took:.1f} s", flush=True)
        return result


def main() -> None:
    """Run the ways and compare them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--runs", type=int, default=20_000)
    parser.add_argument("--kill-every", type=float, default=3.0, metavar="SECONDS")
    # On a busy machine a worker may take longer to start than it lives: then no number of workers would ever finish.
    parser.add_argument("--kills", type=int, default=10, help="stop killing after so many")
    parser.add_argument("--only", choices=("local", "cluster", "killed"))
    asked = parser.parse_args()
    study = study_of(asked.runs)
    here = locally(study)
    for name, kills in (("cluster", 0), ("killed", asked.kills)):
        if asked.only in (None, name):
            there = on_cluster(study, asked.kill_every, kills)
            print(f"the same to the bit: {same(here, there)}", flush=True)


if __name__ == "__main__":
    main()
