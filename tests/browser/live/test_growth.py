"""The page with five plots for 30 s: at least 25 pictures a second, and nobody grows (benchmarks/live_page.py)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from tests.browser.live.opened import chromium_path, require_playwright

ROOT = Path(__file__).parents[3]


@pytest.mark.browser
def test_the_page_does_not_grow() -> None:
    require_playwright()
    chromium_path()
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.live_page", "--growth", "--quick"],
        cwd=ROOT, check=False, capture_output=True, text=True, timeout=400,
    )  # fmt: skip
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
