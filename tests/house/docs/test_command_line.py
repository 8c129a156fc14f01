"""What commands answer with ``--json`` is as the schemas say, and they end with the codes of the page about them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from tests.house.docs.doc_pages import tables_of
from tests.places import CHECKOUT

from musclewire.app import json_schema

PAGE = (CHECKOUT / "docs/reference/command_line.md").read_text("utf-8")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a loop and its model, as the commands make them."""
    return prepared(tmp_path_factory.mktemp("commands"))


def prepared(path: Path) -> Path:
    run(path, "characterize", "simulated", "-o", "loop.h5")
    run(path, "fit", "loop.h5", "-o", "model.json")
    run(path, "characterize", "simulated", "-o", "short.h5", "--cycles", "1", "--period", "12 s")
    (path / "study.toml").write_text(STUDY, "utf-8")
    shutil.copy(CHECKOUT / "tests/unit/signals/old_recordings/journal-1-cut-off.h5.journal", path / "cut.h5.journal")
    return path


def run(folder: Path, *arguments: str, expect: int = 0, may_not_hold: bool = False) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "musclewire", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        env={**os.environ, "MPLBACKEND": "Agg"},
        check=False,
    )
    assert done.returncode == expect or (may_not_hold and done.returncode == 1), done.stderr
    return done.stdout if expect == 0 else done.stderr


STUDY = """
format = "musclewire-study"
version = 1
name = "two pretensions"
run = { kind = "characterize", cycles = 1, period = "20 s" }
parameters.pretension.values = ["1.5 N", "1.9 N"]
"""

CALLS = {
    "demo": ["--output", "demo"],
    "reproduce": ["--only", "eq5", "--output", "reproduced"],
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
def test_the_json_is_as_its_schema_says(name: str, folder: Path) -> None:
    document = json.loads(run(folder, *name.split(), *CALLS[name], "--json", may_not_hold=name in MAY_NOT_HOLD))
    Draft202012Validator(json_schema(f"output-{name.replace(' ', '-')}")).validate(document)


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
def test_the_exit_codes_are_as_said_and_errors_are_one_line(code: int, arguments: list[str], folder: Path) -> None:
    assert any(row["code"] == str(code) for table in tables_of(PAGE) for row in table if "code" in row)
    last = run(folder, *arguments, expect=code).strip().splitlines()
    assert code == 1 or len(last) == 1
