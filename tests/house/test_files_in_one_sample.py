"""One sample of the default control passes through few files, and ARCHITECTURE.md lists them."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from tests.places import CHECKOUT

MAX_FILES = 18
MAX_LINES = 700


def listed_files() -> set[str]:
    """Return the files that ARCHITECTURE.md lists for one sample."""
    text = (CHECKOUT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    section = text.split("### Files to open for it")[1].split("\n#")[0]
    rows = re.findall(r"^    (\w+/) +(.+)$", section, flags=re.MULTILINE)
    return {room + name for room, names in rows for name in names.split()}


@pytest.mark.slow
def test_one_sample_passes_through_the_files_that_the_architecture_lists() -> None:
    script = CHECKOUT / "checks" / "files_in_one_sample.py"
    ran = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False, timeout=600)
    assert ran.returncode == 0, ran.stderr
    lengths = {name: int(lines) for lines, name in re.findall(r"^ *(\d+) (\S+\.py)$", ran.stdout, flags=re.MULTILINE)}
    assert set(lengths) == listed_files()
    assert len(lengths) <= MAX_FILES
    assert max(lengths.values()) <= MAX_LINES
