"""The wiring guide shows the parts lists and the table of wires as the data files and the command have them."""

from __future__ import annotations

import sys

import pytest
from doc_pages import ROOT

from musclewire.parameters.parts import parts_names

sys.path.insert(0, str(ROOT / "docs/images"))
import parts_page

PAGE = (ROOT / "docs/how-to/wire_the_circuit.md").read_text("utf-8")


@pytest.mark.parametrize("name", [parts_page.WIRES, *parts_names()])
def test_what_is_printed_is_what_the_code_says(name: str) -> None:
    assert parts_page.block(name) in PAGE, "run: python docs/images/draw_circuits.py"
