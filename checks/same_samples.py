"""Compare all that the main jobs record and write in two checkouts, to the bit: did a structural change alter results?

    python checks/same_samples.py BEFORE AFTER [--only JOB] [--relative TOLERANCE] [--keep FOLDER]

Each is a checkout, or a folder that an earlier call filled with ``--keep``. Every job runs with each checkout's own
sources, child processes included, by this Python's packages. What is compared:

- recordings (.h5) and data sets (.parquet): each column, sample by sample, and the facts in their metadata;
- models, gains, wire files and what a command prints with ``--json`` (.json, .toml): each number, each word and how
  the command ended; of a sentence, which may be put in other words, the numbers only;
- what is exported as C, and each file within an FMU, and tables (.csv): the whole text.

``--relative`` takes a tolerance in place of equality: for samples as a fraction of their column's range (of its largest
magnitude where it is constant), for all other numbers of their own magnitude. Exit code 1: something differs.

Not compared, because it may differ between two runs of the same sources:

- facts and columns whose names say that they are times by the wall clock: ``wall_s``, ``drift_us``, ``scheduling``,
  and ``compute``, ``jitter`` and ``latency`` with any ending that ends in ``_us``;
- what names the program, under the keys ``software_version``, ``created_by``, ``engine`` and ``fingerprint``, and in
  texts the number of a version after "musclewire " and after "version=";
- a model's ``checksum``, over all that the file says, which is compared itself: a home move writes its date;
- dates with a time of day, GUIDs (a hash over an FMU's texts, which are compared themselves) and absolute paths, in
  texts; within a recording or a result nothing else names a machine;
- the compiled binary of an FMU, made by this machine's compiler from the C sources next to it, and the times of the
  files within the archive;
- pages (.html) outside of an FMU, which are drawn from what is compared and say how long that took, and comments: of
  .toml files, which have the numbers of the JSON, rounded, and of C, which name modules.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import pyarrow.parquet

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from checks.compared_contents import Array, Contents, content_differences  # noqa: E402

BINARIES = "binaries/"
NOT_READ = (".html",)


class Job(NamedTuple):
    """Commands that are run in a folder of the job's name, next to the folders of the jobs it needs."""

    commands: tuple[str, ...]
    files: Mapping[str, str] = {}
    needs: tuple[str, ...] = ()


PULSES = """
[pwm]
frequency = "200 Hz"
supply = "5 V"
window = "on"
sample_delay = "50 us"
readings = 2
shunt_settling = "5 us"

[settings]
acquisition_bits = 12.0
acquisition_range_v = 5.0
acquisition_noise_v = 1.2e-3
"""
FAULTY = """
[[fault]]
kind = "bad_contact"
resistance = "0.1 ohm"
at = "11 s"
"""
SEGMENTED = """
kind = "segmented"
segments = 6
temperature_spread = "1.2 K"
convection_spread = 0.07
grains = [{ weight = 0.8, mean = 0.0, deviation = 1.0 }, { weight = 0.2, mean = -1.5, deviation = 2.0 }]
barriers = [{ weight = 0.5, barrier = "-1.5 K" }, { weight = 0.5, barrier = "1.5 K" }]

[conditions]
ambient = "30 degC"
draught = 0.1

[instruments]
lead_resistance = "0.5 ohm"
clock_jitter = 0.05
"""
STUDY = """
format = "musclewire-study"
version = 1
name = "two pretensions"
run = { kind = "simulate", supply = "3.2 V", duration = "3 s", keep = ["stroke", "energy_j", "strain"] }
sampling = { method = "sobol", samples = 64 }
parameters.pretension.values = ["1.5 N", "1.9 N"]
parameters.convection_factor = { low = 0.85, high = 0.95 }
"""
CONTROL = "control simulated ../loop/model.json --json --reference '1 % to 3 % by 1 %'"
SHORT = "--cycles 1 --period '20 s' --amplitude '2.9 V' --json"
JOBS = {
    "demo": Job(("demo --output demo --json",)),
    "finger": Job(
        (
            "characterize finger -o loop.h5 --json",
            "fit loop.h5 --quantity displacement -o model.json --json",
            "control finger model.json --quantity displacement --reference '2.5 mm to 6 mm by 0.5 mm' -o run.h5 --json",
        )
    ),
    "grip": Job(("grip gripper --learned learned.json -o grip.h5 --json",)),
    "loop": Job(("characterize simulated --cycles 1 -o loop.h5 --json", "fit loop.h5 -o model.json --json")),
    "calibrate": Job(
        (
            "characterize simulated --cycles 1 --period '12 s' --seed 5 -o short.h5 --json",
            "calibrate short.h5 --effort quick -o wire.toml --json",
        )
    ),
    "particle-filter": Job(
        (
            f"{CONTROL} --estimator particle-filter --wire-file ../calibrate/wire.toml -o run.h5",
            "estimate ../loop/model.json ../calibrate/short.h5 --estimator particle-filter"
            " --wire-file ../calibrate/wire.toml -o estimated.h5 --json",
        ),
        needs=("loop", "calibrate"),
    ),
    "inverse-model": Job(
        (
            "tune ../loop/model.json ../loop/loop.h5 -o gains.toml --json",
            f"{CONTROL} --controller inverse-model --gains gains.toml -o run.h5",
        ),
        needs=("loop",),
    ),
    "polynomial-pid": Job((f"{CONTROL} --estimator polynomial --controller pid -o run.h5",), needs=("loop",)),
    "home": Job(
        ("home simulated ../loop/model.json --ambient '24 degC' --sweep sweep.h5 -o homed.json --json",),
        needs=("loop",),
    ),
    "faults": Job(
        ("doctor faulty.toml --json", f"characterize faulty.toml {SHORT} -o faulty.h5"), files={"faulty.toml": FAULTY}
    ),
    "pulse-width": Job(
        (
            "simulate --duty '40 %' --off-after '4 s' --duration '8 s' -o duty.h5 --json",
            f"characterize pulses.toml {SHORT} -o pulses.h5",
        ),
        files={"pulses.toml": PULSES},
    ),
    "segmented": Job((f"characterize segmented.toml {SHORT} -o loop.h5",), files={"segmented.toml": SEGMENTED}),
    "train": Job(("train simulated --max-cycles 4 --period '12 s' -o cycles --json",)),
    "runs": Job((f"{CONTROL} --runs 3", f"{CONTROL} --runs 2 --in-python --seed 7"), needs=("loop",)),
    "sweep": Job(("sweep study.toml --workers 2 -o study --json",), files={"study.toml": STUDY}),
    "export-c": Job(
        (
            "export c ../loop/model.json -o single --json",
            "export c ../loop/model.json --estimator polynomial --controller fuzzy-pid --double -o double --json",
        ),
        needs=("loop",),
    ),
    "export-fmu": Job(
        (
            "export fmu simulated -o fmus --json",
            "export fmu finger --name finger -o fmus --json",
            "export fmu ../loop/model.json -o fmus --json",
        ),
        needs=("loop",),
    ),
}


def contents_of(path: Path) -> Contents:
    """Return what is compared of a file, by its ending."""
    match path.suffix:
        case ".h5":
            return recording_contents(path)
        case ".parquet":
            return parquet_contents(path)
        case ".json":
            return Contents(facts=json.loads(path.read_text("utf-8")))
        case ".toml":
            return Contents(facts=tomllib.loads(path.read_text("utf-8")))
        case ".fmu":
            return archive_contents(path)
        case _:
            return Contents(texts={"": text_of(path.read_bytes())})


def recording_contents(path: Path) -> Contents:
    """Return data sets and attributes of an HDF5 file."""
    arrays: dict[str, Array] = {}
    facts: dict[str, Any] = {}

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            arrays[name] = np.asarray(item[()])
        facts[name] = plain(item.attrs)

    with h5py.File(path, "r") as file:
        facts["metadata"] = plain(file.attrs)
        file.visititems(visit)
    return with_texts_as_facts(arrays, facts)


def plain(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return attributes with plain numbers, texts and lists."""
    return {name: value.tolist() if hasattr(value, "tolist") else value for name, value in attributes.items()}


def parquet_contents(path: Path) -> Contents:
    """Return the columns of a Parquet file; its metadata has only the study itself, and what names the program."""
    table = pyarrow.parquet.read_table(path)
    return with_texts_as_facts({name: np.array(table[name].to_pylist()) for name in table.column_names}, {})


def with_texts_as_facts(arrays: Mapping[str, Array], facts: Mapping[str, Any]) -> Contents:
    """Return arrays of numbers as columns, and arrays of texts among the facts."""
    numbers = {name: array for name, array in arrays.items() if array.dtype.kind in "biuf"}
    texts = {f"{name} as texts": array.tolist() for name, array in arrays.items() if name not in numbers}
    return Contents(numbers, {**facts, **texts})


def archive_contents(path: Path) -> Contents:
    """Return the texts in an archive; of binaries only that they are there."""
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if not name.endswith("/")]
        return Contents(
            texts={name: "" if name.startswith(BINARIES) else text_of(archive.read(name)) for name in names}
        )


def text_of(data: bytes) -> str:
    """Return bytes as a text in which no two differ that are not the same bytes."""
    return data.decode("utf-8", errors="surrogateescape")


def with_needed(names: list[str]) -> list[str]:
    """Return the names of jobs, those they need among them, in the order of their running."""
    wanted = {*names, *(need for name in names for need in JOBS[name].needs)}
    return [name for name in JOBS if name in wanted]


def run_jobs(checkout: Path, folder: Path, names: list[str]) -> None:
    """Run the named jobs with the sources of a checkout; each leaves its files in a folder of its name."""
    sources = checkout.resolve() / "src"
    environment = {**os.environ, "PYTHONPATH": str(sources), "MPLBACKEND": "Agg"}
    hold_to_sources(sources, environment)
    for name in names:
        place = folder / name
        if place.exists():
            raise SystemExit(f"{place} exists: give --keep a new folder, or remove it")
        place.mkdir(parents=True)
        for file, text in JOBS[name].files.items():
            (place / file).write_text(text, "utf-8")
        began_s = time.monotonic()
        exit_codes = {}
        for number, command in enumerate(JOBS[name].commands, 1):
            answer = f"{number}-{command.split()[0]}"
            exit_codes[answer] = run_command(command, place, place / f"{answer}.json", environment)
        (place / "exit-codes.json").write_text(json.dumps(exit_codes), "utf-8")
        print(f"{checkout} {name}: {time.monotonic() - began_s:.1f} s", file=sys.stderr, flush=True)


def hold_to_sources(sources: Path, environment: Mapping[str, str]) -> None:
    """Raise SystemExit unless a process and its own child both import the package from these sources."""
    names = "import musclewire; print(musclewire.__file__, flush=True)"
    child = f"import subprocess, sys; {names}; subprocess.run([sys.executable, '-c', {names!r}], check=True)"
    with tempfile.TemporaryDirectory() as elsewhere:  # the folder of the caller comes before all others with "-c"
        done = subprocess.run(
            [sys.executable, "-c", child], cwd=elsewhere, env=environment, capture_output=True, text=True, check=True
        )
    found = {Path(line).resolve().parent for line in done.stdout.splitlines()}
    if found != {sources / "musclewire"}:
        raise SystemExit(f"the sources of {sources} are to run, and {', '.join(map(str, sorted(found)))} would")


def run_command(command: str, place: Path, answer: Path, environment: Mapping[str, str]) -> int:
    """Run one command in a folder, keep its JSON document and return its exit code."""
    done = subprocess.run(
        [sys.executable, "-m", "musclewire", *shlex.split(command)],
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )
    if done.returncode not in (0, 1):  # 1: done, and a tolerance is missed; the samples are there
        raise SystemExit(f"{place}: musclewire {command} ended with {done.returncode}: {done.stderr[-600:]}")
    answer.write_text(done.stdout, "utf-8")
    return done.returncode


def files_in(folder: Path, names: list[str]) -> dict[str, Path]:
    """Return every file of the named jobs that is compared, by its name relative to the folder."""
    found = [path for name in names for path in sorted((folder / name).rglob("*"))]
    return {
        path.relative_to(folder).as_posix(): path
        for path in found
        if path.is_file() and path.suffix not in NOT_READ
    }  # fmt: skip


def differences(before: Path, after: Path, names: list[str], tolerance: float | None) -> list[str]:
    """Return what differs between two folders of results, one line each."""
    first, second = files_in(before, names), files_in(after, names)
    lines = [f"{name}: only in one of the two" for name in sorted(first.keys() ^ second.keys())]
    for name in sorted(first.keys() & second.keys()):
        found = content_differences(contents_of(first[name]), contents_of(second[name]), tolerance)
        lines += [f"{name}: {line}" for line in found]
    return lines


def filled(given: Path, names: list[str], place: Path) -> Path:
    """Return a folder of results: the given one, or ``place``, filled now from the given checkout."""
    if not (given / "src" / "musclewire").is_dir():
        return given
    run_jobs(given, place, names)
    return place


def main() -> None:
    """Run both checkouts and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--only", choices=sorted(JOBS), action="append", help="run only this job and those it needs")
    parser.add_argument("--keep", type=Path, help="keep the results of BEFORE here, to be given as BEFORE next time")
    parser.add_argument("--relative", type=float, metavar="TOLERANCE", help="tolerance; without it, equal to the bit")
    given = parser.parse_args()
    names = with_needed(given.only or list(JOBS))
    place = Path(tempfile.mkdtemp(prefix="same-samples-"))
    before = filled(given.before, names, given.keep or place / "before")
    after = filled(given.after, names, place / "after")
    compared = len(files_in(after, names))
    if not compared:
        raise SystemExit("no results to compare")
    lines = differences(before, after, names, given.relative)
    if lines:
        print("\n".join(lines))
        raise SystemExit(f"{len(lines)} differences; before: {before}, after: {after}")
    shutil.rmtree(place)
    equal = "equal to the bit" if given.relative is None else f"equal within {given.relative:g}"
    print(f"{compared} files of {len(names)} jobs are {equal}")


if __name__ == "__main__":
    main()
