"""A key of rig files, or a part of a load, that a part offers by its manifest: without that one line names the part."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

# Parts are looked for once, when rigs are first asked for.
WITHOUT_PARTS = """
import sys
import musclewire.manifest as parts
parts.own_manifests = lambda: iter(())
from musclewire.app import run
print([run(["doctor", file]) for file in sys.argv[1:]])
"""
KEYS = {"instruments": '[[fault]]\nkind = "wire_open"', "grip": '[[load]]\npart = "antagonist"'}


def test_a_key_of_a_part_that_is_not_there_is_one_line_that_names_the_part(tmp_path: Path) -> None:
    files = {part: tmp_path / f"{part}_rig.toml" for part in KEYS}
    for part, file in files.items():
        file.write_text(KEYS[part], "utf-8")
    given = [sys.executable, "-c", WITHOUT_PARTS, *map(str, files.values())]
    done = subprocess.run(given, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [str([2] * len(files))]
    for (part, file), said in zip(files.items(), done.stderr.splitlines(), strict=True):
        assert f"belongs to the part '{part}'" in said
        assert str(file) in said
