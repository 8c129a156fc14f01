"""Draw the circuits of the wiring guides: python docs/images/draw_circuits.py

Each drawing is written into this folder, as .svg to build from and as .png to look at. Values and pin numbers come from
the parts lists in ``musclewire/extras/board/parts_lists``, so drawing and list cannot differ. Needs schemdraw (extra
``dev``).
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import board_circuit
import card_circuit

DRAWINGS = {
    "circuit_board": board_circuit.board,
    "circuit_button": board_circuit.button,
    "circuit_ni_card": card_circuit.ni_card,
    "circuit_monitor": card_circuit.monitor,
}


def main() -> None:
    """Draw every circuit."""
    for name, draw in DRAWINGS.items():
        draw().save(name)


if __name__ == "__main__":
    main()
