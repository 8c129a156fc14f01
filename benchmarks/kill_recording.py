"""Kills recordings of a 1 kHz loop with SIGKILL at random moments, and fills disks; prints what the files then held.

The loop appends a row every millisecond, as a run's recorder does, and shows the killer when it appended which. Killed
are the host (the program of the loop), the process that writes for it, or both at once; half of the moments are in the
first second. Where only the writing process is killed, the host goes on and is killed itself 0.15 to 0.5 s later. A row
is missing if it had been appended and is not in the file. What is missing counts from the first such row to the last
that was appended. The age of the first at the kill is printed next to it: on a machine with more to do than cores it
also counts the time in which the host was not let run.

Then disks of random size are filled: a tmpfs, which only root can mount, and a limit on the length of files. A run must
end with one line, or without an error if it fitted, and every row that was written must be there. ``--quick`` kills 20
times. Exit code 1 if a file cannot be read or holds a wrong row, if more than 0.1 s is missing, or a row
that was older than 0.1 s.
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
from musclewire.signals import AppendingProcess, Recording, read_hdf5, recover_recording

PERIOD_S = 1e-3
MISSING_BAR_S = 0.1
LONGEST_S = 3.0
VICTIMS = ("host", "writer", "both")
COLUMNS = (
    *("time_s", "drive_voltage_v", "wire_voltage_v", "shunt_voltage_v", "displacement_m", "force_n", "cycle"),
    *("target_strain", "estimated_strain", "valid", "proportional_gain", "integral_gain", "derivative_gain"),
    *("estimated_strain_std", "health"),
)
# Full disks: rows of a run that needs about 180 kB for its journal and as much for its HDF5 file.
ROWS_TO_DISK = 1500
DISK_BYTES = (16_384, 420_000)


class Shown(ctypes.Structure):
    """What the host shows the killer, in memory of both: its writer's process, and when it appended which row."""

    _fields_ = [("writer", ctypes.c_long), ("rows", ctypes.c_long), ("at_s", ctypes.c_double * 20_000)]


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
    with Recorder(COLUMNS, {"wire": "none"}, path, apart=True) as recorder:
        writer = recorder._writer
        assert writer is not None
        assert isinstance(writer._target, AppendingProcess)
        shown.writer = writer._target._process.pid
        begun_s = time.monotonic()
        for index in range(len(shown.at_s)):
            time.sleep(max(0.0, begun_s + PERIOD_S * index - time.monotonic()))
            shown.at_s[index] = time.monotonic()
            recorder.append(row_of(index))  # type: ignore[arg-type]
            shown.rows = index + 1


class Kill(NamedTuple):
    """One killed recording: the run, whether its file is readable and right, how much is missing and how old it is."""

    victim: str
    run_s: float
    readable: bool
    right: bool
    missing_s: float
    age_s: float


def killed(victim: str, moment_s: float, folder: Path) -> Kill:
    """Start a recording, kill it, and say what is left."""
    path = folder / "run.h5"
    shown = Shown.from_buffer(mmap.mmap(-1, ctypes.sizeof(Shown)))
    host = in_another_process(lambda: record_for_ever(path, shown))
    while not shown.rows:
        time.sleep(0.001)
    time.sleep(moment_s)
    if victim != "host":
        os.kill(shown.writer, signal.SIGKILL)
    if victim == "writer":
        time.sleep(random.uniform(0.15, 0.5))
    killed_s = time.monotonic()
    os.kill(host, signal.SIGKILL)
    os.waitpid(host, 0)
    return judged(victim, path, shown, killed_s)


def judged(victim: str, path: Path, shown: Shown, killed_s: float) -> Kill:
    """Compare what is in the file with what had been appended, and recover it as plain HDF5."""
    run_s = killed_s - shown.at_s[0]
    try:
        while read_hdf5(path).metadata["ended"] == "running":  # the writing process still has rows from the pipe
            time.sleep(0.005)
        recording = read_hdf5(path)
        recovered = recover_recording(path)
    except MusclewireError as problem:
        print(f"{victim} after {run_s:.3f} s: {problem}")
        return Kill(victim, run_s, False, False, run_s, run_s)
    right = is_right(recording) and recovered == recording == read_hdf5(path)
    path.unlink()
    if len(recording) >= shown.rows:
        return Kill(victim, run_s, True, right, 0.0, 0.0)
    first_s, last_s = shown.at_s[len(recording)], shown.at_s[shown.rows - 1]
    return Kill(victim, run_s, True, right, last_s + PERIOD_S - first_s, killed_s - first_s)


def kill_all(count: int, folder: Path) -> list[Kill]:
    """Kill so many recordings, each victim in turn, every other one in its first second."""
    kills = []
    for number in range(count):
        moment_s = random.uniform(0.0, 1.0) if number % 2 else random.uniform(1.0, LONGEST_S)
        kills.append(killed(VICTIMS[number % len(VICTIMS)], moment_s, folder))
    return kills


def show_kills(kills: list[Kill]) -> bool:
    """Print a table of what was left; return whether all of it meets the bar."""
    print(f"{'killed':8} {'times':>6} {'first second':>13} {'readable':>9} {'wrong rows':>11} "
          f"{'missing at most':>16} {'median':>8} {'age at most':>14}")  # fmt: skip
    for victim in VICTIMS:
        of_it = [kill for kill in kills if kill.victim == victim]
        missing_ms = [1e3 * kill.missing_s for kill in of_it]
        print(f"{victim:8} {len(of_it):6} {sum(kill.run_s < 1.0 for kill in of_it):13} "
              f"{sum(kill.readable for kill in of_it):9} {sum(not kill.right for kill in of_it):11} "
              f"{max(missing_ms):13.1f} ms {statistics.median(missing_ms):5.1f} ms "
              f"{1e3 * max(kill.age_s for kill in of_it):11.1f} ms")  # fmt: skip
    for kill in kills:
        if max(kill.missing_s, kill.age_s) > MISSING_BAR_S:
            print(
                f"{kill.victim} killed {kill.run_s:.3f} s after the first row: {kill.missing_s:.3f} s are missing, the "
                f"first row of them {kill.age_s:.3f} s old"
            )
    return all(kill.readable and kill.right and max(kill.missing_s, kill.age_s) <= MISSING_BAR_S for kill in kills)


class Filled(NamedTuple):
    """One run on a disk too small: what it said, and what was kept."""

    kind: str
    disk_bytes: int
    said: str
    rows: int
    right: bool


def record_to_small_disk(path: Path, apart: bool, said: Path, limit_bytes: int | None) -> None:
    """Record a run of ordinary length where there may be no room for it, and keep all that is said."""
    with said.open("w") as file:
        os.dup2(file.fileno(), 2)
    os.environ["TMPDIR"] = str(said.parent)
    if limit_bytes is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))
    try:
        with Recorder(COLUMNS, {}, path, apart=apart) as recorder:
            for index in range(ROWS_TO_DISK):
                recorder.append(row_of(index))  # type: ignore[arg-type]
                if index % 100 == 0:
                    time.sleep(0.02)
    except RecordingNotWrittenError as problem:
        os.write(2, f"{problem}\n".encode())


def filled(kind: str, path: Path, disk_bytes: int, apart: bool, folder: Path) -> Filled:
    """Let a run find a disk full, and say what is left of it."""
    said = folder / "said.txt"
    limit = disk_bytes if kind == "limit" else None
    os.waitpid(in_another_process(lambda: record_to_small_disk(path, apart, said, limit)), 0)
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
        found.append(filled("limit", limited / "run.h5", disk_bytes, bool(number % 2), folder))
        try:
            with small_disk(folder, disk_bytes) as place:
                found.append(filled("tmpfs", place / "run.h5", disk_bytes, bool(number % 2), folder))
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
    parser.add_argument("--output", type=Path, help="folder to record in, by default a temporary one")
    arguments = parser.parse_args()
    print(f"a row of {len(COLUMNS)} columns every {1e3 * PERIOD_S:g} ms; load {os.getloadavg()[0]:.1f} on "
          f"{os.cpu_count()} cores")  # fmt: skip
    with TemporaryDirectory(dir=arguments.output) as name:
        folder = Path(name)
        kept = show_kills(kill_all(20 if arguments.quick else 200, folder))
        kept &= show_fillings(fill_disks(6 if arguments.quick else 40, folder))
    print(
        "\nat most 0.1 s is missing, no missing row was older, and no row is wrong" if kept else "\nnot as it must be"
    )
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
