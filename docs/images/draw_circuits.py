"""Draw the circuits of the wiring guides and write their tables: python docs/images/draw_circuits.py

Each drawing is written into this folder, as .svg to build from and as .png to look at. Values, pin numbers and the
tables in the page come from the parts lists in ``musclewire/extras/board/parts_lists``, so drawing and list cannot
differ. Needs schemdraw (extra ``dev``).
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import board_circuit
import card_circuit
import parts_page

DOCS = Path(__file__).parents[1]
PAGE = DOCS / "reference/circuits.md"
BLOCK = re.compile(r"(<!-- written by docs/images/draw_circuits\.py: ([\w -]+) -->\n).*?(<!-- end -->)", re.S)
DRAWINGS = {
    "circuit_board": board_circuit.board,
    "circuit_button": board_circuit.button,
    "circuit_ni_card": card_circuit.ni_card,
    "circuit_monitor": card_circuit.monitor,
}


def main() -> None:
    """Draw every circuit and write the tables into their page."""
    for name, draw in DRAWINGS.items():
        draw().save(name)
    text = PAGE.read_text("utf-8")
    written = BLOCK.sub(lambda found: f"{found[1]}\n{parts_page.block(found[2])}\n\n{found[3]}", text)
    PAGE.write_text(written, encoding="utf-8")


if __name__ == "__main__":
    main()
