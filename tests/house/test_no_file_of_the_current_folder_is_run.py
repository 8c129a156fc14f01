"""Processes of ours that are started where a stranger's files lie: none of these is imported, whatever it is called."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

SOURCES = Path(__file__).parents[2] / "src" / "musclewire"
# Modules that our processes import, from the standard library and from elsewhere.
NAMES = ("random", "json", "pickle", "pathlib", "numpy", "h5py", "numba", "musclewire")
LEAVES_A_MARK = "from os import open, O_CREAT, O_WRONLY\nopen(__file__ + '.ran', O_CREAT | O_WRONLY)\n"


@pytest.fixture
def strange(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, full of files that leave a mark when they are run; an interactive Python would find them."""
    folder = tmp_path / "strange"
    folder.mkdir()
    for name in NAMES:
        (folder / f"{name}.py").write_text(LEAVES_A_MARK, encoding="utf-8")
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that this process imports from, next to the current one, which it has in two ways."""
    folder = tmp_path / "own"
    folder.mkdir()
    monkeypatch.setattr(sys, "path", ["", os.curdir, *sys.path, str(folder)])
    return folder


def marks(folder: Path) -> list[str]:
    """Return which files of a folder were run."""
    return sorted(path.name for path in folder.glob("*.ran"))


def test_the_marks_are_left_by_a_python_that_looks_into_the_current_folder(strange: Path) -> None:
    """Otherwise the tests below would say nothing."""
    subprocess.run([sys.executable, "-c", "import random"], check=True)
    assert marks(strange) == ["random.py.ran"]


@pytest.mark.slow
def test_a_worker_imports_from_this_processs_path_and_not_from_the_current_folder(strange: Path, own: Path) -> None:
    """Run apart, by a Python that looks into the current folder itself once it has started: loky's helpers are new."""
    (own / "own_work.py").write_text("import random, sys\ndef path_of(_): return sys.path\n", encoding="utf-8")
    code = (
        "import json, sys\nfrom musclewire.experiment import evaluate_in_processes\n"
        f"sys.path += {[str(own)]!r}\nimport own_work\nsys.path[:0] = ['', '.']\nfound = {{}}\n"
        "evaluate_in_processes(own_work.path_of, range(3), found.__setitem__, workers=2, named=str)\n"
        "print(json.dumps(found[0]))\n"
    )
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True)
    import_path = json.loads(done.stdout)
    assert marks(strange) == []
    assert str(own) in import_path
    assert not {"", os.curdir, str(strange)} & set(import_path)


def test_every_python_that_is_started_leaves_the_current_folder_out() -> None:
    """By the sources: ``-P`` or ``-I`` is the first option wherever this Python is started."""
    started = {
        path.relative_to(SOURCES).as_posix(): re.findall(r'sys\.executable,\s*(?:\*\()?"(-\w)"', text)
        for path in SOURCES.rglob("*.py")
        if "sys.executable" in (text := path.read_text("utf-8"))
    }
    assert len(started) >= 3
    for name, options in started.items():
        assert len(options) == (SOURCES / name).read_text("utf-8").count("sys.executable"), name
        assert set(options) <= {"-P", "-I"}, name


def command(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a command in a folder as its console script does, which has no current folder on its path."""
    return subprocess.run(
        [sys.executable, "-P", "-m", "musclewire", *arguments], cwd=folder, capture_output=True, text=True, check=False
    )


@pytest.mark.slow
def test_importing_a_file_runs_nothing_that_lies_next_to_it(strange: Path) -> None:
    with h5py.File(strange / "ext.h5", "w") as file:
        file["time_s"] = np.linspace(0.0, 10.0, 201)
        file["drive_voltage_v"] = file["wire_voltage_v"] = file["shunt_voltage_v"] = np.ones(201)
    done = command(strange, "import", "ext.h5")
    assert "Traceback" not in done.stderr
    assert marks(strange) == []


@pytest.mark.slow
def test_reproducing_runs_nothing_of_the_current_folder(strange: Path) -> None:
    done = command(strange, "reproduce", "--only", "fig3b", "--seeds", "3", "--workers", "2", "--json")
    assert json.loads(done.stdout)
    assert marks(strange) == []
