"""docs/reference/command_line.md says what the command line has: no more, no less."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from tests.house.command_surface import alternatives
from tests.house.docs.doc_pages import code_words, tables_of
from tests.places import CHECKOUT

from musclewire.app import json_schema

PAGE = (CHECKOUT / "docs/reference/command_line.md").read_text("utf-8")
SECTIONS = dict(re.findall(r"^## `musclewire (\w+(?: \w+)?)`\n(.*?)(?=^## |\Z)", PAGE, re.M | re.S))


def documented_options(section: str) -> dict[str, str]:
    rows = [row for table in tables_of(section) for row in table if "Option" in row]
    return {row["Option"]: row["Default"] for row in rows}


def json_keys(section: str) -> set[str]:
    found = re.search(r"JSON keys: (.*?)(?:\n\n|\Z)", section, re.S)
    assert found
    return set(code_words(found[1]))


def own_options(command: Any) -> list[Any]:
    return [item for item in command.params if item.param_type_name == "option" and "--help" not in item.opts]


def test_every_command_has_its_section_and_every_section_its_command(commands: dict[str, Any]) -> None:
    assert set(SECTIONS) == set(commands)


@pytest.mark.parametrize("name", SECTIONS)
def test_every_option_and_its_default_are_as_said_and_none_is_missing(name: str, commands: dict[str, Any]) -> None:
    said = {
        frozenset(code_words(cell)): "".join(code_words(default))
        for cell, default in documented_options(SECTIONS[name]).items()
    }
    assert said == {
        frozenset(option.opts): "" if option.default in (None, False, ()) else str(option.default)
        for option in own_options(commands[name])
    }


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
    "design finger": ["--finger", "lan-fan-2010", "--compare", "--foam", "50 N/m", "--wire", "paper-100um"],
    "import": ["loop.h5"],
    "sweep": ["study.toml"],
    "robustness": ["--quick", "--condition", "none", "--track", "sines", "--controllers", "none"],
    "calibrate": ["short.h5", "--effort", "quick", "-o", "wire.toml"],
    "fit": ["loop.h5"],
    "tune": ["model.json", "loop.h5"],
    "estimate": ["model.json", "loop.h5"],
    "protection": ["simulated"],
    "bench": ["--quick", "--only", "step[10ms,numba]"],
    "recover": ["cut.h5"],
    "rules": [],
    "export c": ["model.json", "-o", "library"],
    "export fmu": ["model.json", "-o", "fmus"],
    "schema": ["model"],
    "cite": [],
}


# Commands whose answer may be that something does not hold: exit code 1, and the document all the same.
MAY_NOT_HOLD = ("catalogue", "robustness")


def test_every_command_but_serve_answers_with_json() -> None:
    """``serve`` answers on its page, until it is ended; ``tests/extras/live`` starts it."""
    assert [name for name, section in SECTIONS.items() if "`--json`" not in section] == ["serve"]


@pytest.mark.parametrize("name", [name for name in SECTIONS if name != "serve"])
def test_the_schema_of_the_json_has_its_keys(name: str) -> None:
    schema = json_schema(f"output-{name.replace(' ', '-')}")
    known = {key for one in alternatives(schema, schema.get("$defs", {})) for key in one.get("properties", ())}
    assert json_keys(SECTIONS[name]) <= known


@pytest.mark.documented
@pytest.mark.parametrize("name", [name for name in SECTIONS if name != "serve"])
def test_the_json_has_the_keys_as_said(name: str, folder: Path) -> None:
    document = json.loads(run(folder, *name.split(), *CALLS[name], "--json", may_not_hold=name in MAY_NOT_HOLD))
    assert set(document) == json_keys(SECTIONS[name])
    Draft202012Validator(json_schema(f"output-{name.replace(' ', '-')}")).validate(document)


@pytest.mark.documented
@pytest.mark.parametrize(
    ("code", "arguments"),
    [
        (1, ["train", "simulated", "--most-cycles", "2"]),
        (2, ["fit", "no-such-file.h5"]),
        (2, ["fit", "loop.h5", "--no-such-option"]),
        (2, ["no-such-command"]),
    ],
)
def test_the_exit_codes_are_as_said_and_errors_are_one_line(code: int, arguments: list[str], folder: Path) -> None:
    assert any(row["code"] == str(code) for table in tables_of(PAGE) for row in table if "code" in row)
    last = run(folder, *arguments, expect=code).strip().splitlines()
    assert code == 1 or len(last) == 1
