"""The wiring guides show parts, wiring tables and the table of wires as data files and command have them."""

from __future__ import annotations

import sys

import pytest
from tests.places import CHECKOUT

from musclewire.extras.board._parts import parts_names

sys.path.insert(0, str(CHECKOUT / "docs/images"))
import parts_page

PAGE = (CHECKOUT / "docs/reference/circuits.md").read_text("utf-8")
BLOCKS = [parts_page.WIRES, *(f"{kind} {name}" for kind in ("wiring", "reasons") for name in parts_names())]


@pytest.mark.parametrize("name", BLOCKS)
def test_what_is_printed_is_what_the_code_says(name: str) -> None:
    assert parts_page.block(name) in PAGE, "run: python docs/images/draw_circuits.py"
