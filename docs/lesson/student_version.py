"""Make the students' notebook of the lecturer's: python docs/lesson/student_version.py

A code cell that begins with ``# solution`` becomes an empty one; so the two cannot differ in a question.
"""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
SOLUTIONS, STUDENTS = HERE / "solutions.ipynb", HERE / "lesson.ipynb"
MARK = "# solution"
TITLE = "# A wire that knows its length"
INTRODUCTION = (
    "For you who have 90 minutes and a simulated wire. Solve each question in the empty cell below it, and put your "
    'number into `answers`, as `answers["1 stroke, %"] = ...`. Write your own number into `SEED`: '
    "it makes the noise of your rig. The [sheet](sheet.md) says what is marked."
)


def student_version(solutions: dict[str, Any]) -> dict[str, Any]:
    """Return the students' notebook: without solutions, and without what follows from them."""
    notebook = copy.deepcopy(solutions)
    cells: list[dict[str, Any]] = []
    solved = False
    for cell in notebook["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "code":
            solved = text.startswith(MARK)
            cell["source"] = ["# your code"] if solved else cell["source"]
        elif solved:
            # What a solution is commented with stays with the lecturer; the next question begins with its heading.
            _, heading, question = f"\n{text}".partition("\n## ")
            if not heading:
                continue
            cell["source"] = f"## {question}".splitlines(keepends=True)
        cells.append(cell)
    cells[0]["source"] = [f"{TITLE}\n", "\n", INTRODUCTION]
    return {**notebook, "cells": cells}


def as_text(notebook: dict[str, Any]) -> str:
    """Return a notebook as its file has it."""
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    STUDENTS.write_text(as_text(student_version(json.loads(SOLUTIONS.read_text("utf-8")))), encoding="utf-8")
    print(STUDENTS)
