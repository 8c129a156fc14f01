"""Measures once which test runs which line, in several processes side by side, and keeps it."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from checks.mutants.tree import environment_of

__all__ = ["measured_tests"]

# Files and folders whose tests judge; of the rooms above, those that run much of the rooms below in little time.
TESTS = {
    "compiled": (
        "tests/unit/wire", "tests/unit/wire/in_time", "tests/unit/sensing", "tests/unit/controllers", "tests/unit/rigs",
        "tests/unit/identify", "tests/unit/experiment", "tests/extras/studies/unit/test_wires_of_a_study.py",
        "tests/contract", "tests/faults",
        "tests/extras/board/export/test_c_equals_python.py", "tests/extras/board/export/test_protection_in_c.py",
    ),
    # Of the rooms with the wire's kernels those of few steps: the others would take minutes only to be left out.
    "plain": (
        "tests/unit/wire/test_slopes.py", "tests/unit/wire/test_distribution.py", "tests/unit/wire/test_building.py",
        "tests/unit/wire/test_fronts_along_temperature_walks.py", "tests/unit/wire/test_hysteresis_memory.py",
        "tests/unit/wire/in_time/test_single_steps.py", "tests/unit/wire/in_time/test_single_steps_of_pairs.py",
        "tests/unit/wire/in_time/test_cycles.py", "tests/unit/wire/in_time/test_advance.py",
        "tests/unit/wire/in_time/test_warming.py", "tests/unit/wire/in_time/test_paths.py",
        "tests/unit/wire/in_time/test_loads.py", "tests/unit/sensing", "tests/unit/controllers",
        "tests/unit/rigs/test_instruments.py", "tests/unit/rigs/test_compiled_loop.py",
        "tests/unit/rigs/test_faults.py", "tests/unit/rigs/test_simulated.py",
        "tests/contract/test_estimator_contract.py", "tests/contract/test_controller_contract.py",
    ),
}  # fmt: skip
# A test that takes longer judges nothing [s of processor time].
LIMIT_S = {"compiled": 15.0, "plain": 3.0}
PARTS = 12


def measured_tests(
    mode: str, tree: Path, folder: Path, processes: int, only: Sequence[str] | None = None
) -> list[dict[str, Any]]:
    """Return what runs under coverage have found, each valid for some files of tests; run what is missing.

    All is measured again if a source or a helper of the tests has changed; of tests, only files that have changed.
    """
    files = {str(path.relative_to(tree)): digest([path]) for path in test_files(tree, only or TESTS[mode])}
    around = digest([*sorted((tree / "src").rglob("*.py")), *helpers(tree)])
    kept = folder / "measured" / f"{mode}-{around}"
    kept.mkdir(parents=True, exist_ok=True)
    parts = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(kept.glob("*.json"))]
    known = {name: found for part in parts for name, found in part["files"].items()}
    missing = sorted(name for name, found in files.items() if known.get(name) != found)
    if missing:
        print(f"measuring {len(missing)} files of tests, compilation {'off' if mode == 'plain' else 'on'}", flush=True)
        # Neighbours have much the same load of work: each part takes every n-th file.
        chunks = [missing[first::PARTS] for first in range(PARTS) if missing[first::PARTS]]
        with ThreadPoolExecutor(processes) as threads:
            parts += threads.map(
                lambda chunk: measured_part(mode, tree, kept, {name: files[name] for name in chunk}), chunks
            )
    return [valid_part(part, files) for part in parts]


def measured_part(mode: str, tree: Path, kept: Path, files: dict[str, str]) -> dict[str, Any]:
    """Measure some files of tests and keep what was found."""
    output = kept / f"{digest_of(json.dumps(files, sort_keys=True))}.json"
    command = [sys.executable, "-m", "checks.mutants.collecting", mode, str(LIMIT_S[mode]), str(output), *files]
    ran = subprocess.run(command, cwd=tree, env=environment_of(mode, tree), capture_output=True, text=True, check=False)
    if ran.returncode != 0:
        raise RuntimeError(f"pytest cannot run: {ran.stdout[-2000:]} {ran.stderr[-2000:]}")
    part: dict[str, Any] = {**json.loads(output.read_text(encoding="utf-8")), "files": files}
    output.write_text(json.dumps(part), encoding="utf-8")
    return part


def valid_part(part: dict[str, Any], files: dict[str, str]) -> dict[str, Any]:
    """Return what a part says of files that have not changed since."""
    valid = {name for name, found in part["files"].items() if files.get(name) == found}

    def of_valid(names: Iterable[str]) -> list[str]:
        return [name for name in names if name.removeprefix("import ").split("::")[0] in valid]

    return {
        "cpu_s": {name: part["cpu_s"][name] for name in of_valid(part["cpu_s"])},
        "left_out": {name: part["left_out"][name] for name in of_valid(part["left_out"])},
        "lines": {
            path: {line: of_valid(contexts) for line, contexts in lines.items()}
            for path, lines in part["lines"].items()
        },
    }


def test_files(tree: Path, named: Sequence[str]) -> list[Path]:
    """Return the files of tests among files and folders."""
    found = []
    for name in named:
        path = tree / name
        found += sorted(path.rglob("test_*.py")) if path.is_dir() else [path]
    return found


def helpers(tree: Path) -> list[Path]:
    """Return the files in tests/ that are not tests themselves."""
    return [path for path in sorted((tree / "tests").rglob("*.py")) if not path.name.startswith("test_")]


def digest(paths: Iterable[Path]) -> str:
    """Return a short hash of files."""
    return digest_of("".join(hashlib.sha256(path.read_bytes()).hexdigest() for path in paths))


def digest_of(text: str) -> str:
    """Return a short hash of a text."""
    return hashlib.sha256(text.encode()).hexdigest()[:16]
