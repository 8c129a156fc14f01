"""Run the tutorial's blocks and keep the pictures they write: python docs/images/draw_tutorial.py"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
PAGE = HERE.parent / "tutorials" / "from_a_stroke_to_a_moving_finger.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
PICTURES = ("finger", "pretensioner", "sweep", "run")


def main() -> None:
    """Run every block of the page in one folder, then copy its pictures into this folder."""
    with tempfile.TemporaryDirectory() as folder:
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        for language, text in BLOCK.findall(PAGE.read_text("utf-8")):
            command = ["sh", "-eu", "-c", text] if language == "sh" else [sys.executable, "-c", text]
            subprocess.run(command, cwd=folder, env={**os.environ, "PATH": path, "MPLBACKEND": "Agg"}, check=True)
        for name in PICTURES:
            shutil.copy(Path(folder) / f"{name}.png", HERE / f"tutorial_{name}.png")


if __name__ == "__main__":
    main()
