"""Small files of every kind that musclewire writes, kept for good: what a released version wrote, later ones must read.

    python -m checks.files_of_release              writes tests/house/data/files_of/VERSION, with this musclewire
    python -m checks.files_of_release --overwrite  replaces them, before the version is released

Beside the files is ``manifest.json``: of each its kind, its SHA-256, and numbers that this version reads out of it.
``tests/house/test_files_of_releases.py`` holds today's code to the manifests of all versions. A folder is never changed
once its version is released (docs/reference/versions.md).
"""

from __future__ import annotations

import argparse
import hashlib
import json
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["FOLDER", "KINDS", "manifest_of", "read_as"]

FOLDER = Path(__file__).resolve().parents[1] / "tests/house/data/files_of"
Numbers = dict[str, Any]

RIG = """# The finger's bench, cooler and longer than the one that ships.
kind = "simulated"
wire = "flexinol-0.10-lt"
bench = "dead-weight"
drive_amplitude = "2.2 V"

[settings]
pretension_n = 1.2
"""
STUDY = """format = "musclewire-study"
version = 1
name = "two pretensions"
run = { kind = "characterize", cycles = 1, period = "12 s" }
parameters.pretension.values = ["1.5 N", "1.9 N"]
"""
FOREIGN = "Zeit [ms];U1 [V];U2;Weg [mm]\n0;1,60;100;0,000\n50;1,61;101;0,010\n100;1,62;102;0,021\n"
# Commands in their order, each with the files that it leaves and their kinds; what has no kind is not kept.
COMMANDS: tuple[tuple[str, dict[str, str]], ...] = (
    ("characterize simulated --cycles 1 --period 2s -o recording.h5", {"recording.h5": "recording"}),
    ("import recording.h5 -o recording.csv", {"recording.csv": "recording"}),
    ("import recording.h5 -o recording.mat", {"recording.mat": "recording"}),
    ("import recording.h5 -o recording.xlsx", {"recording.xlsx": "recording"}),
    ("import recording.h5 -o recording.parquet", {"recording.parquet": "recording"}),
    ("import foreign.csv -c wire_voltage_v=U1 -c shunt_voltage_v=U2:mV --save-mapping mapping.toml",
     {"foreign.csv": "", "mapping.toml": "mapping"}),
    ("characterize simulated -o loop.h5", {}),
    ("fit loop.h5 -o model.json", {"model.json": "model"}),
    ("home simulated model.json -o homed.json", {"homed.json": "model"}),
    ("tune model.json loop.h5 -o gains.toml", {"gains.toml": "gains"}),
    ("calibrate loop.h5 --effort quick -o wire.toml", {"wire.toml": "wire"}),
    ("characterize rig.toml --cycles 1 --period 2s -o rig.h5", {"rig.toml": "rig"}),
    ("sweep study.toml -o study", {"study.toml": "study", "study/data.parquet": "study data"}),
    ("grip --learned gripper.json", {"gripper.json": "gripper"}),
    ("design finger --finger lan-fan-2010 -o finger.toml", {"finger.toml": "finger"}),
    ("design pretensioner --beams 2 --half-length 6mm --pitch 3mm --thickness 0.8mm --process mill --travel 0.2mm "
     "--finger-stiffness 20000N/m -o pretensioner.toml", {"pretensioner.toml": "pretensioner"}),
)  # fmt: skip


def numbers_of_recording(path: Path) -> Numbers:
    """Return rows, metadata and the mean of each column."""
    from musclewire.files import read_recording

    recording = read_recording(path)
    means = {name: float(np.mean(recording[name])) for name in recording.names}
    return {"rows": len(recording), "ended": recording.metadata.get("ended"), "means": means}


def numbers_of_model(path: Path) -> Numbers:
    """Return what a model senses at three resistances, and its last home move."""
    from musclewire.sensing import load_model

    model = load_model(path)
    at = np.linspace(model.resistance_min_ohm, model.resistance_max_ohm, 3)
    return {"quantity": model.quantity, "resistance_ohm": at.tolist(), "read": [float(model.strain(r)) for r in at]}


def numbers_of_mapping(path: Path) -> Numbers:
    """Return what a foreign file is by its mapping."""
    from musclewire.files import read_recording

    recording = read_recording(path.with_name("foreign.csv"), mapping=path)
    return {name: recording[name].tolist() for name in recording.names}


def numbers_of_gains(path: Path) -> Numbers:
    """Return all settings."""
    from musclewire.controllers import load_gains

    return plain(load_gains(path))


def numbers_of_wire(path: Path) -> Numbers:
    """Return every number of the wire and its alloy."""
    from musclewire.parameters import read_wire_file

    return plain(read_wire_file(path).model_dump())


def numbers_of_rig(path: Path) -> Numbers:
    """Return every key of a rig file, with its default where the file has none."""
    from musclewire.rigs import read_rig_file

    return {key: value for key, value in plain(read_rig_file(path).model_dump()).items() if value is not None}


def numbers_of_study(path: Path) -> Numbers:
    """Return every key of a study."""
    from musclewire.extras.studies import read_study_file

    return plain(read_study_file(path).model_dump())


def numbers_of_study_data(path: Path) -> Numbers:
    """Return the numbers of all runs."""
    import musclewire as mw

    found = mw.read_study_data(path)
    return {str(name): found[name].values.ravel().tolist() for name in found.data_vars if found[name].dtype.kind == "f"}


def numbers_of_gripper(path: Path) -> Numbers:
    """Return all that a gripper has learned."""
    from dataclasses import asdict

    from musclewire.extras.grip import load_knowledge

    return plain(asdict(load_knowledge(path)))


def numbers_of_finger(path: Path) -> Numbers:
    """Return every number of a finger."""
    from musclewire.parameters import load_finger

    return plain(load_finger(str(path)).model_dump())


def numbers_of_pretensioner(path: Path) -> Numbers:
    """Return every number of a pretensioner."""
    from musclewire.parameters import read_pretensioner

    return plain(read_pretensioner(path).model_dump())


KINDS: Mapping[str, Callable[[Path], Numbers]] = {
    "recording": numbers_of_recording,
    "model": numbers_of_model,
    "mapping": numbers_of_mapping,
    "gains": numbers_of_gains,
    "wire": numbers_of_wire,
    "rig": numbers_of_rig,
    "study": numbers_of_study,
    "study data": numbers_of_study_data,
    "gripper": numbers_of_gripper,
    "finger": numbers_of_finger,
    "pretensioner": numbers_of_pretensioner,
}


def plain(value: Any) -> Any:
    """Return what JSON knows of a value: dataclasses as their fields, arrays as lists."""
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__}
    if isinstance(value, Mapping):
        return {str(name): plain(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)


def read_as(kind: str, path: Path) -> Numbers:
    """Return what today's musclewire reads out of a file of a kind, as JSON would give it back, without its folder."""
    read: Numbers = json.loads(json.dumps(plain(KINDS[kind](path))).replace(f"{path.parent}/", ""))
    return read


def manifest_of(folder: Path) -> dict[str, Any]:
    """Return the manifest of a version's folder."""
    found: dict[str, Any] = json.loads((folder / "manifest.json").read_text("utf-8"))
    return found


def write_files(work: Path) -> dict[str, str]:
    """Run all commands in a folder, and return the files to keep, with their kinds."""
    for name, text in (("rig.toml", RIG), ("study.toml", STUDY), ("foreign.csv", FOREIGN)):
        (work / name).write_text(text, "utf-8")
    kept: dict[str, str] = {}
    for command, files in COMMANDS:
        done = subprocess.run(
            [sys.executable, "-m", "musclewire", *shlex.split(command)],
            cwd=work,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode > 1:  # 1: done, and the result does not hold, as of a recording too short to fit
            sys.exit(f"FAIL: musclewire {command}: exit code {done.returncode}\n{done.stderr}")
        kept |= files
    (work / "journal.h5.journal").write_bytes(journal_of(work))
    return kept | {"journal.h5.journal": "recording"}


def journal_of(work: Path) -> bytes:
    """Return the journal of a run that has not ended."""
    from musclewire.signals import RecordingWriter

    writer = RecordingWriter(work / "running.h5", ["time_s", "force_n"])
    for row in range(20):
        writer.append({"time_s": 0.1 * row, "force_n": 1.0 + 0.01 * row})
    text = (work / "running.h5.journal").read_bytes()
    writer.close()
    return text


def keep(work: Path, kept: Mapping[str, str], folder: Path) -> None:
    """Copy the files to a version's folder, and write its manifest."""
    entries = {}
    for name, kind in kept.items():
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(work / name, target)
        entries[name] = {"kind": kind, "sha256": hashlib.sha256(target.read_bytes()).hexdigest()}
    for name, entry in entries.items():
        if entry["kind"]:
            entry["reads"] = read_as(entry["kind"], folder / name)
    document = {"version": version("musclewire"), "files": entries}
    (folder / "manifest.json").write_text(json.dumps(document, indent=1) + "\n", "utf-8")


def main() -> None:
    """Write the folder of this version."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--overwrite", action="store_true", help="replace the folder of this version")
    overwrite = parser.parse_args().overwrite
    folder = FOLDER / version("musclewire")
    if folder.exists() and not overwrite:
        sys.exit(f"{folder} exists: files of a released version stay; before its release, --overwrite")
    with tempfile.TemporaryDirectory(prefix="musclewire-release-") as name:
        kept = write_files(Path(name))
        shutil.rmtree(folder, ignore_errors=True)
        keep(Path(name), kept, folder)
    size_kb = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e3
    print(f"{folder}: {len(kept)} files and their manifest, {size_kb:.0f} kB")


if __name__ == "__main__":
    main()
