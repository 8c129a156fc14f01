"""Kills recordings of a 1 kHz loop with SIGKILL at random moments, and fills disks; prints what the files then held.

The loop appends a row every millisecond, as a run's recorder does, and shows the killer when it appended which. Half
of the moments are in the first second. A row is lost if it had been appended and is not in the file; its age is that
at the kill, and on a machine with more to do than cores it also counts the time in which the program was not let run.

Then disks of random size are filled: a tmpfs, which only root can mount, and a limit on the length of files. A run must
end with one line, or without an error if it fitted, and every row that was written must be there. ``--quick`` kills 20
times. Exit code 1 if a file cannot be read or holds a wrong row, or if a row is lost that was older than a second.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import mmap
import os
import random
import resource
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from musclewire.errors import MusclewireError, RecordingNotWrittenError
from musclewire.experiment import Recorder
from musclewire.files import read_hdf5
from musclewire.signals import Recording, recover_recording

PERIOD_S = 1e-3
OLDEST_LOST_S = 1.0
LONGEST_S = 3.0
COLUMNS = (
    *("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v", "displacement_m", "force_n", "cycle"),
    *("target_strain", "estimated_strain", "valid", "proportional_gain", "integral_gain", "derivative_gain"),
    *("estimate_std", "health"),
)
# Full disks: rows of a run that needs about 180 kB for its journal and as much for its HDF5 file.
ROWS_TO_DISK = 1500
DISK_BYTES = (16_384, 420_000)


class Shown(ctypes.Structure):
    """What the host shows the killer, in memory of both: when it appended which row."""

    _fields_ = [("rows", ctypes.c_long), ("at_s", ctypes.c_double * 20_000)]


def row_of(index: int) -> list[float]:
    """Return a row in which every number differs from those of all other rows."""
    return [PERIOD_S * (index + 1), *(index + place / 32.0 for place in range(1, len(COLUMNS)))]


def is_right(recording: Recording) -> bool:
    """Return whether a recording has whole rows in their order, from the first one on."""
    table = np.column_stack([recording[name] for name in COLUMNS])
    return bool(
        np.array_equal(table, np.array([row_of(index) for index in range(len(recording))]).reshape(table.shape))
    )


def in_another_process(work: Callable[[], None]) -> int:
    """Do some work in a process of its own, as forked as it is; return its id."""
    child = os.fork()
    if child == 0:
        try:
            work()
        finally:
            os._exit(0)
    return child


def record_for_ever(path: Path, shown: Shown) -> None:
    """Append a row every millisecond until somebody kills this."""
    with Recorder(COLUMNS, {"wire": "none"}, path) as recorder:
        begun_s = time.monotonic()
        for index in range(len(shown.at_s)):
            time.sleep(max(0.0, begun_s + PERIOD_S * index - time.monotonic()))
            shown.at_s[index] = time.monotonic()
            recorder.append(row_of(index))  # type: ignore[arg-type]
            shown.rows = index + 1


class Kill(NamedTuple):
    """One killed recording: whether its file is right, and how many rows are lost, of which age [s] at the kill."""

    run_s: float
    right: bool
    lost_old: int = 0
    oldest_lost_s: float = 0.0


def killed(moment_s: float, folder: Path) -> Kill:
    """Start a recording, kill it, and say what is left."""
    path = folder / "run.h5"
    shown = Shown.from_buffer(mmap.mmap(-1, ctypes.sizeof(Shown)))
    host = in_another_process(lambda: record_for_ever(path, shown))
    while not shown.rows:
        time.sleep(0.001)
    time.sleep(moment_s)
    killed_s = time.monotonic()
    os.kill(host, signal.SIGKILL)
    os.waitpid(host, 0)
    return judged(path, shown, killed_s)


def judged(path: Path, shown: Shown, killed_s: float) -> Kill:
    """Compare what is in the file with what had been appended, and recover it as plain HDF5."""
    run_s = killed_s - shown.at_s[0]
    try:
        recording = read_hdf5(path)
        recovered = recover_recording(path)
    except MusclewireError as problem:
        print(f"killed after {run_s:.3f} s: {problem}")
        return Kill(run_s, False)
    right = is_right(recording) and recovered == recording == read_hdf5(path)
    path.unlink()
    ages_s = [killed_s - shown.at_s[row] for row in range(len(recording), shown.rows)]
    return Kill(run_s, right, sum(age_s > OLDEST_LOST_S for age_s in ages_s), max(ages_s, default=0.0))


def kill_all(count: int, folder: Path) -> list[Kill]:
    """Kill so many recordings, every other one in its first second."""
    moments_s = [random.uniform(0.0, 1.0) if number % 2 else random.uniform(1.0, LONGEST_S) for number in range(count)]
    return [killed(moment_s, folder) for moment_s in moments_s]


def show_kills(kills: list[Kill]) -> bool:
    """Print what was left; return whether all of it is as it must be."""
    ages_ms = [1e3 * kill.oldest_lost_s for kill in kills]
    print(f"kills: {len(kills)}, {sum(kill.run_s < 1.0 for kill in kills)} of them in the first second")
    print(f"files that cannot be read or hold a wrong row: {sum(not kill.right for kill in kills)}")
    print(f"rows lost older than {OLDEST_LOST_S:g} s: {sum(kill.lost_old for kill in kills)}")
    print(f"age of the oldest row lost: worst {max(ages_ms):.1f} ms, median {statistics.median(ages_ms):.1f} ms")
    return all(kill.right and not kill.lost_old for kill in kills)


class Filled(NamedTuple):
    """One run on a disk too small: what it said, and what was kept."""

    kind: str
    disk_bytes: int
    said: str
    rows: int
    right: bool


def record_to_small_disk(path: Path, said: Path, limit_bytes: int | None) -> None:
    """Record a run of ordinary length where there may be no room for it, and keep all that is said."""
    with said.open("w") as file:
        os.dup2(file.fileno(), 2)
    os.environ["TMPDIR"] = str(said.parent)
    if limit_bytes is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))
    try:
        with Recorder(COLUMNS, {}, path) as recorder:
            for index in range(ROWS_TO_DISK):
                recorder.append(row_of(index))  # type: ignore[arg-type]
                if index % 100 == 0:
                    time.sleep(0.02)
    except RecordingNotWrittenError as problem:
        os.write(2, f"{problem}\n".encode())


def filled(kind: str, path: Path, disk_bytes: int, folder: Path) -> Filled:
    """Let a run find a disk full, and say what is left of it."""
    said = folder / "said.txt"
    limit = disk_bytes if kind == "limit" else None
    os.waitpid(in_another_process(lambda: record_to_small_disk(path, said, limit)), 0)
    try:
        recording = read_hdf5(path)
    except MusclewireError as problem:
        return Filled(kind, disk_bytes, f"{said.read_text()}{problem}\n", 0, False)
    return Filled(kind, disk_bytes, said.read_text(), len(recording), is_right(recording))


@contextlib.contextmanager
def small_disk(folder: Path, disk_bytes: int) -> Iterator[Path]:
    """Mount a small disk in memory. Raises PermissionError if that is not permitted."""
    place = folder / "disk"
    place.mkdir(exist_ok=True)
    command = ["mount", "-t", "tmpfs", "-o", f"size={disk_bytes}", "tmpfs", str(place)]
    if subprocess.run(command, capture_output=True, check=False).returncode:
        raise PermissionError("a tmpfs cannot be mounted here")
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def fill_disks(count: int, folder: Path) -> list[Filled]:
    """Fill so many disks of each kind; where nothing can be mounted, say so."""
    found = []
    for number in range(count):
        disk_bytes = random.randrange(*DISK_BYTES)
        limited = folder / f"limited-{number}"
        limited.mkdir()
        found.append(filled("limit", limited / "run.h5", disk_bytes, folder))
        try:
            with small_disk(folder, disk_bytes) as place:
                found.append(filled("tmpfs", place / "run.h5", disk_bytes, folder))
        except PermissionError as problem:
            if number == 0:
                print(f"not run: {problem}")
    return found


def show_fillings(fillings: list[Filled]) -> bool:
    """Print a table of what full disks left; return whether all of it is as it must be."""
    print(f"\n{'full disk':10} {'runs':>5} {'all fitted':>11} {'one line said':>14} {'rows kept':>12} {'wrong':>6}")
    for kind in dict.fromkeys(one.kind for one in fillings):
        of_it = [one for one in fillings if one.kind == kind]
        kept = [one.rows for one in of_it]
        print(f"{kind:10} {len(of_it):5} {sum(not one.said for one in of_it):11} "
              f"{sum(is_one_line(one) for one in of_it if one.said):14} {min(kept):5} to {max(kept):<4} "
              f"{sum(not one.right for one in of_it):5}")  # fmt: skip
    return all(one.right and is_one_line(one) for one in fillings)


def is_one_line(one: Filled) -> bool:
    """Return whether a run that did not fit said one line, and one that fitted said nothing."""
    return one.said.count("\n") == 1 if one.rows < ROWS_TO_DISK else one.said.count("\n") <= 1


def main() -> int:
    """Kill, fill, print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="20 kills and 6 disks instead of 200 and 40")
    parser.add_argument("--seed", type=int, default=1, help="seed of the moments and of the sizes of disks")
    parser.add_argument("--output", type=Path, help="folder to record in, by default a temporary one")
    arguments = parser.parse_args()
    random.seed(arguments.seed)
    print(f"seed {arguments.seed}; a row of {len(COLUMNS)} columns every {1e3 * PERIOD_S:g} ms; "
          f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")  # fmt: skip
    with TemporaryDirectory(dir=arguments.output) as name:
        folder = Path(name)
        kept = show_kills(kill_all(20 if arguments.quick else 200, folder))
        kept &= show_fillings(fill_disks(6 if arguments.quick else 40, folder))
    print("\nno row is wrong, none older than a second is lost" if kept else "\nnot as it must be")
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
