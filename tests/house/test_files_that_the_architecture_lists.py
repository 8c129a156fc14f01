"""One sample, and one key of a rig file, pass through few files; ARCHITECTURE.md lists them."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from tests.places import CHECKOUT

MAX_FILES, MAX_FILES_OF_A_KEY = 17, 8
MAX_LINES = 700
CONTAINERS = ["RigConfiguration.pretension", "Parameter.value", "WireConstants.pretension_n"]


def section(heading: str) -> str:
    """Return a section of ARCHITECTURE.md."""
    return (CHECKOUT / "ARCHITECTURE.md").read_text(encoding="utf-8").split(heading)[1].split("\n#")[0]


def listed_files(text: str) -> list[str]:
    """Return the files that a section lists."""
    rows = re.findall(r"^    (\w+/) +(.+)$", text, flags=re.MULTILINE)
    return sorted(room + name for room, names in rows for name in names.split())


def printed_by(check: str) -> str:
    """Return what a check prints."""
    script = CHECKOUT / "checks" / check
    ran = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False, timeout=600)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@pytest.mark.slow
def test_one_sample_passes_through_the_files_that_the_architecture_lists() -> None:
    printed = printed_by("files_in_one_sample.py")
    lengths = {name: int(lines) for lines, name in re.findall(r"^ *(\d+) (\S+\.py)$", printed, flags=re.MULTILINE)}
    assert sorted(lengths) == listed_files(section("### Files to open for it"))
    assert len(lengths) <= MAX_FILES
    assert max(lengths.values()) <= MAX_LINES


@pytest.mark.slow
def test_a_key_passes_through_the_files_and_containers_that_the_architecture_lists() -> None:
    printed, text = printed_by("files_of_a_rig_key.py"), section("### Files a key passes through")
    files = listed_files(text)
    assert re.findall(r"^file (\S+)$", printed, flags=re.MULTILINE) == files
    assert re.findall(r"^container (\S+)$", printed, flags=re.MULTILINE) == CONTAINERS
    assert len(files) <= MAX_FILES_OF_A_KEY
    assert f"{len(files)} files" in " ".join(text.split())
    assert all(f"`{container}`" in text for container in CONTAINERS)
