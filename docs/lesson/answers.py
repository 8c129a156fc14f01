"""The numbers of the lesson's questions, for each student's seed: python docs/lesson/answers.py --seeds 1 2 3

Runs the code of ``solutions.ipynb``, so that the table cannot differ from the solutions.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import sys
import tempfile
from pathlib import Path

SOLUTIONS = Path(__file__).with_name("solutions.ipynb")


def code_of(path: Path) -> str:
    """Return the code of a notebook, without the cell that sets the seed and the one that prints."""
    cells = json.loads(path.read_text("utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    return "\n\n".join(cell for cell in code if cell.startswith("# solution"))


def answers_of(seed: int) -> dict[str, float]:
    """Return a student's answers, by question."""
    names: dict[str, object] = {"SEED": seed, "answers": (answers := {})}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()):
        exec(compile(code_of(SOLUTIONS), str(SOLUTIONS), "exec"), names)
    return answers


def main() -> int:
    """Print a table: a row for each question, a column for each seed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3, 4, 5], metavar="SEED")
    parser.add_argument("--json", action="store_true", help="print a JSON document, by seed and question")
    options = parser.parse_args()
    os.environ.setdefault("MPLBACKEND", "Agg")
    found = {seed: answers_of(seed) for seed in options.seeds}
    if options.json:
        print(json.dumps({str(seed): answers for seed, answers in found.items()}, indent=1))
        return 0
    print(f"{'seed':36s}", *(f"{seed:>8d}" for seed in found))
    for question in found[options.seeds[0]]:
        print(f"{question:36s}", *(f"{answers[question]:8.4g}" for answers in found.values()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
