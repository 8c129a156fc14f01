"""How long whole jobs take here compared with another checkout: `reproduce`, and calibrating a wire of its own.

Both checkouts run the same job with the same seed in turns, each with a cache of compiled code of its own, which a run
that does not count fills first. Compared is CPU time, of all threads: a shared machine hardly changes it. Bar: at most
a third of the other checkout's.

    python benchmarks/whole_jobs.py PARENT HERE [--rounds N] [--only reproduce|calibrate]

PARENT and HERE are folders of checkouts; N is 3 by default. Exit 1 where a bar fails.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

BAR = 1.0 / 3.0
JOBS = {
    "reproduce": ("-m", "musclewire", "reproduce", "--seed", "1"),
    "calibrate": ("benchmarks/calibrate_own_wire.py", "--quick"),
}


def cpu_s(checkout: Path, cache: Path, job: str) -> float:
    """Return the CPU time of a job in a checkout [s], of all its processes and threads."""
    arguments = [*JOBS[job]]
    if job == "calibrate":
        arguments[0] = str(checkout / arguments[0])
    environment = {
        **os.environ,
        "PYTHONPATH": f"{checkout / 'src'}{os.pathsep}{checkout}",
        "NUMBA_CACHE_DIR": str(cache),
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):  # 1: rows that fail are counted, and known ones fail in both checkouts
        sys.exit(f"{job} in {checkout} ended with {done.returncode}:\n{done.stderr}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> int:
    """Run the jobs in turns and print medians and ratios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parent", type=Path)
    parser.add_argument("here", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", choices=JOBS)
    given = parser.parse_args()
    checkouts = {"parent": given.parent.resolve(), "here": given.here.resolve()}
    holds = True
    print("job          parent, CPU s    here, CPU s    ratio of medians    bar")
    with tempfile.TemporaryDirectory() as caches:
        for job in [given.only] if given.only else JOBS:
            times: dict[str, list[float]] = {name: [] for name in checkouts}
            for turn in range(given.rounds + 1):
                for name, checkout in checkouts.items():
                    taken_s = cpu_s(checkout, Path(caches) / name, job)
                    if turn:  # the first one fills the cache
                        times[name].append(taken_s)
            parent_s, here_s = (statistics.median(times[name]) for name in ("parent", "here"))
            ratio = here_s / parent_s
            holds &= ratio <= BAR
            print(
                f"{job:10}  {parent_s:14.2f} {here_s:14.2f} {ratio:19.3f}    at most {BAR:.3f} "
                f"{'holds' if ratio <= BAR else 'FAILS'}",
                flush=True,
            )
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
