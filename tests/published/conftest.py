from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from tests.tools import made_once


def run_demo(folder: Path) -> None:
    command = [sys.executable, "-m", "musclewire", "demo", "--json", "--output", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    (folder / "answer.json").write_text(done.stdout, "utf-8")
    (folder / "screen.txt").write_text(done.stderr, "utf-8")


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What `musclewire demo --json` says, run as a user runs it; ``folder`` is where it wrote."""
    folder = made_once(tmp_path_factory, "demo", run_demo)
    answer: dict[str, Any] = json.loads((folder / "answer.json").read_text("utf-8"))
    return {**answer, "folder": folder, "page": Path(answer["report"]).read_text("utf-8")}
