"""Compare every recorded sample of the main jobs in two checkouts, to the bit: did a structural change alter results?

    python checks/same_samples.py BEFORE AFTER

Each is a checkout, or a folder that an earlier call filled with ``--keep``. Runs ``demo``, the finger's staircase and
``grip`` with each checkout's own sources, by this Python's packages, and compares each column of each recording. Where
columns were added or left out it says so; samples that differ end with exit code 1.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

MUSCLEWIRE = (sys.executable, "-m", "musclewire")
FINGER = ("--quantity", "displacement")
STAIRCASE = ("--reference", "2.5 mm to 6 mm by 0.5 mm")
JOBS: dict[str, tuple[tuple[str, ...], ...]] = {
    "demo": (("demo", "--out", "demo"),),
    "finger": (
        ("characterize", "finger", "-o", "finger-loop.h5"),
        ("fit", "finger-loop.h5", *FINGER, "-o", "finger-model.json"),
        ("control", "finger", "finger-model.json", *FINGER, *STAIRCASE, "-o", "finger-run.h5"),
    ),
    "grip": (("grip", "gripper", "-o", "grip.h5"),),
}  # fmt: skip


def run_jobs(checkout: Path, folder: Path, names: list[str]) -> None:
    """Run the named jobs with the sources of a checkout; each leaves its recordings in a folder of its name."""
    environment = {**os.environ, "PYTHONPATH": str(checkout.resolve() / "src")}
    for name in names:
        (folder / name).mkdir(parents=True)
        for arguments in JOBS[name]:
            done = subprocess.run(
                [*MUSCLEWIRE, *arguments],
                cwd=folder / name,
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode not in (0, 1):  # 1: done, and a tolerance is missed; the samples are there
                raise SystemExit(
                    f"{checkout}: musclewire {' '.join(arguments)} ended with {done.returncode}: {done.stderr[-600:]}"
                )


def recordings_in(folder: Path, names: list[str]) -> dict[str, Path]:
    """Return every recording of the named jobs under a folder, by its name relative to it."""
    found = [path for name in names for path in sorted((folder / name).rglob("*.h5"))]
    return {path.relative_to(folder).as_posix(): path for path in found}


def columns_of(path: Path) -> dict[str, np.ndarray]:
    """Return all data sets of a recording by name."""
    columns: dict[str, np.ndarray] = {}
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, item: columns.update({name: item[()]} if isinstance(item, h5py.Dataset) else {}))
    return columns


def differences(before: Path, after: Path, names: list[str]) -> list[str]:
    """Return what differs in the samples of two folders, one line each."""
    first, second = recordings_in(before, names), recordings_in(after, names)
    lines = [f"{name}: only in one of the two" for name in sorted(first.keys() ^ second.keys())]
    for name in sorted(first.keys() & second.keys()):
        one, other = columns_of(first[name]), columns_of(second[name])
        lines += [f"{name}: column {column} only in one of the two" for column in sorted(one.keys() ^ other.keys())]
        for column in sorted(one.keys() & other.keys()):
            if one[column].shape != other[column].shape:
                lines.append(f"{name}: {column} has {one[column].shape} and {other[column].shape} samples")
            elif one[column].tobytes() != other[column].tobytes():
                differ = one[column] != other[column]
                lines.append(f"{name}: {column} differs in {int(np.sum(differ))} of {differ.size} samples")
    return lines


def filled(given: Path, names: list[str], keep: Path | None) -> Path:
    """Return a folder of recordings: the given one, or one that is filled now from a checkout."""
    if not (given / "src" / "musclewire").is_dir():
        return given
    folder = keep or Path(tempfile.mkdtemp(prefix="same-samples-"))
    run_jobs(given, folder, names)
    return folder


def main() -> None:
    """Run both checkouts and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--only", choices=sorted(JOBS), action="append", help="run only this job")
    parser.add_argument("--keep", type=Path, help="keep the recordings of BEFORE here, to be given as BEFORE next time")
    given = parser.parse_args()
    names = given.only or list(JOBS)
    before, after = filled(given.before, names, given.keep), filled(given.after, names, None)
    compared = len(recordings_in(after, names))
    if not compared:
        raise SystemExit("no recordings to compare")
    lines = differences(before, after, names)
    print("\n".join(lines) if lines else f"{compared} recordings are equal to the bit")
    raise SystemExit(1 if lines else 0)


if __name__ == "__main__":
    main()
