"""A key of a rig file passes few files and containers on its way to the wire, and ARCHITECTURE.md lists them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SECTION = (
    (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8").split("### Files a key passes through")[1].split("\n#")[0]
)
CONTAINERS = ["RigConfiguration.pretension", "Parameter.value", "WireConstants.pretension_n"]


def listed_files() -> list[str]:
    """Return the files that ARCHITECTURE.md lists for a key."""
    rows = re.findall(r"^    (\w+/) +(.+)$", SECTION, flags=re.MULTILINE)
    return sorted(room + name for room, names in rows for name in names.split())


@pytest.mark.slow
def test_a_key_passes_through_the_files_and_containers_that_the_architecture_lists() -> None:
    script = ROOT / "checks" / "files_of_a_rig_key.py"
    ran = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False, timeout=600)
    assert ran.returncode == 0, ran.stderr
    assert re.findall(r"^file (\S+)$", ran.stdout, flags=re.MULTILINE) == listed_files()
    assert re.findall(r"^container (\S+)$", ran.stdout, flags=re.MULTILINE) == CONTAINERS
    assert f"{len(listed_files())} files" in " ".join(SECTION.split())
    assert all(f"`{container}`" in SECTION for container in CONTAINERS)
