"""The wiring guides show parts lists, wiring tables and the table of wires as data files and command have them."""

from __future__ import annotations

import sys

import pytest
from tests.places import CHECKOUT

from musclewire.extras.board._parts import parts_names

sys.path.insert(0, str(CHECKOUT / "docs/images"))
import parts_page

GUIDES = "\n".join(
    (CHECKOUT / "docs" / name).read_text("utf-8")
    for name in ("how-to/wire_the_circuit.md", "how-to/wire_an_ni_card.md", "reference/circuits.md")
)
BLOCKS = [parts_page.WIRES, *(f"{kind} {name}" for kind in ("list", "wiring", "reasons") for name in parts_names())]


@pytest.mark.parametrize("name", BLOCKS)
def test_what_is_printed_is_what_the_code_says(name: str) -> None:
    assert parts_page.block(name) in GUIDES, "run: python docs/images/draw_circuits.py"
