"""Draw the pictures of README.md from a run of the main job: python docs/images/draw.py"""

from __future__ import annotations

import tempfile
from pathlib import Path

import matplotlib as mpl

from musclewire.app.report.figures import STYLE, loops_figure, staircase_figure
from musclewire.experiment.demo import run_demo

HERE = Path(__file__).parent


def main() -> None:
    """Run the demo and write both pictures beside this file."""
    with tempfile.TemporaryDirectory() as folder:
        result = run_demo(Path(folder))
    with mpl.rc_context(STYLE):
        staircase_figure(result.run).savefig(HERE / "staircase.png", dpi=110)
        loops_figure(result.loops, result.gaps).savefig(HERE / "loops.png", dpi=110)


if __name__ == "__main__":
    main()
