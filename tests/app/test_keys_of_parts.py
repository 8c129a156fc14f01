"""A key of rig files, or a part of a load, that a part offers by its manifest: without that one line names the part."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

# Parts are looked for once, when rigs are first asked for.
WITHOUT_PARTS = """
import sys
import musclewire.manifest as parts
parts.own_manifests = lambda: iter(())
from musclewire.app import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    ("key", "part"), [('[[fault]]\nkind = "wire_open"', "instruments"), ('[[load]]\npart = "antagonist"', "grip")]
)
def test_a_key_of_a_part_that_is_not_there_is_one_line_that_names_the_part(key: str, part: str, tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(key, "utf-8")
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_PARTS, "doctor", str(file)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    (said,) = done.stderr.splitlines()
    assert f"belongs to the part '{part}'" in said
    assert str(file) in said
