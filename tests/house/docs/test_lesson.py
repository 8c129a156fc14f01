"""Notebooks are stored without outputs, the students' one follows from the solutions, and the marks are computed."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest
from tests.places import DOCS

NOTEBOOKS = sorted([*DOCS.glob("notebooks/*.ipynb"), *DOCS.glob("lesson/*.ipynb")])


def module(name: str) -> ModuleType:
    """Return a module of the lesson's folder."""
    spec = importlib.util.spec_from_file_location(name, DOCS / "lesson" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.name)
def test_a_notebook_is_stored_without_outputs(path: Path) -> None:
    cells = json.loads(path.read_text("utf-8"))["cells"]
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells)


def test_the_students_notebook_is_the_lecturers_without_solutions() -> None:
    maker = module("student_version")
    solutions = json.loads((DOCS / "lesson" / "solutions.ipynb").read_text("utf-8"))
    students = (DOCS / "lesson" / "lesson.ipynb").read_text("utf-8")
    assert students == maker.as_text(maker.student_version(solutions)), "run docs/lesson/student_version.py"
    assert "mw." not in "".join(
        "".join(cell["source"]) for cell in json.loads(students)["cells"] if cell["cell_type"] == "code"
    )


@pytest.mark.documented
def test_the_table_to_mark_by_is_what_the_simulator_answers() -> None:
    page = (DOCS / "lesson" / "README.md").read_text("utf-8")
    command = [sys.executable, str(DOCS / "lesson" / "answers.py"), "--seeds", "1", "2", "3", "4", "5"]
    said = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300).stdout
    shown = [line.strip() for line in page.splitlines() if line.startswith("    ")]
    assert [line.strip() for line in said.splitlines()] == [
        line for line in shown if ".venv" not in line and not line.startswith("$")
    ]
