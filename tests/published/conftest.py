from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What `musclewire demo --json` says, run as a user runs it; ``folder`` is where it wrote."""
    folder = tmp_path_factory.mktemp("demo")
    command = [sys.executable, "-m", "musclewire", "demo", "--json", "--output", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    answer: dict[str, Any] = json.loads(done.stdout)
    return {**answer, "folder": folder, "page": Path(answer["report"]).read_text("utf-8")}
