"""What commands answer with ``--json`` is as the schemas say, and they end with the codes of the page about them.

In the process of the tests, for a process of its own takes a second or two to import what it needs: one answer and one
exit code are those of a process, as a shell starts it.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from tests.command_line import Answer
from tests.house.docs.doc_pages import tables_of
from tests.places import CHECKOUT
from tests.tools import made_once

import musclewire as mw
from musclewire.app import json_schema

PAGE = (CHECKOUT / "docs/reference/command_line.md").read_text("utf-8")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a loop and its model."""
    return made_once(tmp_path_factory, "commands", prepare)


@pytest.fixture
def folder(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of that folder, in which the test runs."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    return tmp_path


def prepare(path: Path) -> None:
    with mw.open_rig("simulated") as rig:
        loop = mw.characterize(rig, path=path / "loop.h5")
    mw.fit(loop).save(path / "model.json")
    with mw.open_rig("simulated") as rig:
        mw.characterize(rig, cycles=1, period_s=12.0, path=path / "short.h5")
    (path / "study.toml").write_text(STUDY, "utf-8")
    shutil.copy(CHECKOUT / "tests/unit/signals/old_recordings/journal-1-cut-off.h5.journal", path / "cut.h5.journal")


def as_a_process(*arguments: str) -> Answer:
    """Return what a command answers that a shell has started."""
    command = [sys.executable, "-m", "musclewire", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return Answer(done.returncode, done.stdout, done.stderr)


STUDY = """
format = "musclewire-study"
version = 1
name = "two pretensions"
run = { kind = "characterize", cycles = 1, period = "20 s" }
parameters.pretension.values = ["1.5 N", "1.9 N"]
"""

CALLS = {
    "demo": ["--output", "demo"],
    "reproduce": ["--only", "eq1", "--workers", "1", "--output", "reproduced"],
    "doctor": ["simulated"],
    "flash": ["nano", "--wire", "paper-100um", "--dry-run"],
    "characterize": ["simulated", "-o", "again.h5", "--cycles", "1"],
    "pretension": ["simulated", "--at", "1.1 N", "--cycles", "1"],
    "control": ["simulated", "model.json"],
    "home": ["simulated", "model.json", "-o", "homed.json"],
    "grip": ["--learned", "gripper.json"],
    "train": ["simulated"],
    "simulate": ["--wire", "flexinol-0.20-lt"],
    "catalogue": [],
    "linearise": ["simulated", "--displacement", "2 mm"],
    "design pretensioner": [
        *("--beams", "2", "--half-length", "6 mm", "--pitch", "3 mm", "--thickness", "0.8 mm", "--process", "mill"),
        *("--travel", "0.2 mm", "--finger-stiffness", "20000 N/m"),
    ],
    "design finger": ["--finger", "lan-fan-2010", "--compare", "--object-stiffness", "50 N/m", "--wire", "paper-100um"],
    "import": ["loop.h5"],
    "sweep": ["study.toml"],
    "calibrate": ["short.h5", "--effort", "quick", "-o", "wire.toml"],
    "fit": ["loop.h5"],
    "tune": ["model.json", "loop.h5"],
    "estimate": ["model.json", "loop.h5"],
    "protection": ["simulated"],
    "recover": ["cut.h5"],
    "rules": [],
    "export c": ["model.json", "-o", "library"],
    "export micropython": ["-o", "program"],
    "export fmu": ["model.json", "-o", "fmus"],
    "schema": ["model"],
    "cite": [],
}


# Commands whose answer may be that something does not hold: exit code 1, and the document all the same.
MAY_NOT_HOLD = ("catalogue",)


def test_every_command_but_serve_answers_with_json(commands: dict[str, Any]) -> None:
    """``serve`` answers on its page, until it is ended; ``tests/extras/live`` starts it."""
    with_json = {name for name, command in commands.items() if any(one.name == "json" for one in command.params)}
    assert set(commands) - with_json == {"serve"}
    assert with_json == set(CALLS)


@pytest.mark.documented
@pytest.mark.parametrize("name", CALLS)
@pytest.mark.usefixtures("folder")
def test_the_json_is_as_its_schema_says(name: str, musclewire: Callable[..., Answer]) -> None:
    command = as_a_process if name == "control" else musclewire
    answer = command(*name.split(), *CALLS[name], "--json")
    assert answer.code in ((0, 1) if name in MAY_NOT_HOLD else (0,)), answer.err
    Draft202012Validator(json_schema(f"output-{name.replace(' ', '-')}")).validate(answer.json)


@pytest.mark.documented
@pytest.mark.parametrize(
    ("code", "arguments"),
    [
        (1, ["train", "simulated", "--max-cycles", "2"]),
        (2, ["fit", "no-such-file.h5"]),
        (2, ["fit", "loop.h5", "--no-such-option"]),
        (2, ["no-such-command"]),
    ],
)
@pytest.mark.usefixtures("folder")
def test_the_exit_codes_are_as_said_and_errors_are_one_line(
    code: int, arguments: list[str], musclewire: Callable[..., Answer]
) -> None:
    assert any(row["code"] == str(code) for table in tables_of(PAGE) for row in table if "code" in row)
    answer = (as_a_process if "no-such-file.h5" in arguments else musclewire)(*arguments)
    assert answer.code == code, answer.err
    assert code == 1 or len(answer.err.strip().splitlines()) == 1
