"""Draw all pictures and write all generated numbers on committed pages: python docs/images/draw.py

After a change of the shipped parameters or of the physics, run it once and commit what changed:

- README.md's pictures, from a run of the demo (``python docs/images/draw.py physics`` leaves these out),
- the pictures of docs/explanation/physics.md and the numbers in it,
- what docs/explanation/parameters.md says of other fits, from the vectors in studies/vectors
  (``python docs/images/draw.py alternatives`` writes these alone),
- the picture of docs/explanation/turns_and_minor_loops.md and the numbers in it
  (``python docs/images/draw.py turns`` draws and writes these alone),
- the Bode plot of docs/how-to/tune_a_controller.md (``python docs/images/draw.py margins`` draws it alone),
- the closed loop on docs/explanation/estimators.md and control.md (``python docs/images/draw.py loop`` draws it alone),
- point B on docs/explanation/why_resistance_tells_strain.md (``python docs/images/draw.py point_b`` draws it alone).

Pages of which nothing is written by hand are not committed: docs/site/written_pages.py.
"""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

import alternatives_page
import balance_numbers
import balance_picture
import loop_pictures
import matplotlib as mpl
import physics_numbers
import physics_pictures
import physics_runs
import point_b_picture
import turns_numbers
import turns_pictures

from musclewire.app import loops_figure, staircase_figure
from musclewire.experiment import run_demo
from musclewire.extras.interfaces import bode_axes, linearise
from musclewire.pages import STYLE

HERE = Path(__file__).parent
PHYSICS_PAGE = HERE.parent / "explanation" / "physics.md"
TURNS_PAGE = HERE.parent / "explanation" / "turns_and_minor_loops.md"
FOUND_PAGE = HERE.parent / "explanation" / "parameters.md"
BLOCK = re.compile(r"(<!-- written by docs/images/draw\.py: (\w+) -->\n).*?(<!-- end -->)", re.S)
DPI = 110
# Displacement of the operating points in the Bode plot.
MARGINS_AT_M = 2e-3


def draw_readme_pictures() -> None:
    """Run the demo and write both pictures into this folder."""
    with tempfile.TemporaryDirectory() as folder:
        result = run_demo(Path(folder))
    with mpl.rc_context(STYLE):
        staircase_figure(result.run).savefig(HERE / "staircase.png", dpi=DPI)
        loops_figure(result.loops, result.gaps).savefig(HERE / "loops.png", dpi=DPI)


def draw_physics_pictures(loops: tuple[physics_runs.LoopTruth, ...]) -> None:
    """Write the pictures of the page on physics into this folder."""
    with mpl.rc_context(STYLE):
        physics_pictures.pretension_figure(loops).savefig(HERE / "phases_over_strain.png", dpi=DPI)
        balance_picture.balance_figure().savefig(HERE / "gap_balance.png", dpi=DPI)
        physics_pictures.isobar_figure().savefig(HERE / "isobars.png", dpi=DPI)
        physics_pictures.grains_figure().savefig(HERE / "grains.png", dpi=DPI)
        physics_pictures.diagram_figure(loops).savefig(HERE / "phase_diagram.png", dpi=DPI)


def draw_margins() -> None:
    """Write the Bode plot of docs/how-to/tune_a_controller.md into this folder."""
    with mpl.rc_context(STYLE):
        bode_axes(linearise(MARGINS_AT_M)).figure.savefig(HERE / "margins.png", dpi=DPI)


def draw_turns() -> None:
    """Write the picture of docs/explanation/turns_and_minor_loops.md into this folder, and the page's numbers."""
    with mpl.rc_context(STYLE):
        turns_pictures.branches_figure().savefig(HERE / "isobar_branches.png", dpi=DPI)
    TURNS_PAGE.write_text(with_blocks(TURNS_PAGE.read_text("utf-8"), turns_numbers.blocks()), encoding="utf-8")


def draw_loop() -> None:
    """Write the picture of the closed loop into this folder."""
    with mpl.rc_context(STYLE):
        loop_pictures.loop_figure().savefig(HERE / "loop.png", dpi=DPI)


def draw_point_b() -> None:
    """Write the picture of point B into this folder."""
    with mpl.rc_context(STYLE):
        point_b_picture.point_b_figure().savefig(HERE / "point_b.png", dpi=DPI)


def write_alternatives() -> None:
    """Write what held-out fits predict, and what published values cost, into docs/explanation/parameters.md."""
    page = with_blocks(FOUND_PAGE.read_text("utf-8"), {"alternatives": alternatives_page.block()})
    FOUND_PAGE.write_text(page, encoding="utf-8")


def physics_blocks(loops: tuple[physics_runs.LoopTruth, ...]) -> dict[str, str]:
    """Return every generated text of docs/explanation/physics.md."""
    return physics_numbers.blocks(loops) | balance_numbers.blocks()


def with_blocks(text: str, blocks: dict[str, str]) -> str:
    """Return a page with new text between its markers."""
    return BLOCK.sub(lambda found: f"{found[1]}\n{blocks[found[2]]}\n\n{found[3]}", text)


def main() -> None:
    """Draw and write everything; with ``physics`` all but the demo's pictures, with a name of ``ALONE`` that alone."""
    if len(sys.argv) == 2 and sys.argv[1] in ALONE:
        ALONE[sys.argv[1]]()
        return
    if sys.argv[1:] != ["physics"]:
        draw_readme_pictures()
    loops = physics_runs.loops_of_the_sweep()
    draw_physics_pictures(loops)
    page = with_blocks(PHYSICS_PAGE.read_text("utf-8"), physics_blocks(loops))
    PHYSICS_PAGE.write_text(page, encoding="utf-8")
    for draw_or_write in ALONE.values():
        draw_or_write()


ALONE = {
    "margins": draw_margins,
    "turns": draw_turns,
    "loop": draw_loop,
    "point_b": draw_point_b,
    "alternatives": write_alternatives,
}


if __name__ == "__main__":
    main()
