"""The drawn circuits join what the parts lists say: the nets are followed along the drawn lines."""

from __future__ import annotations

import sys
from collections.abc import Callable, Set
from typing import Any

import pytest
from tests.places import CHECKOUT

from musclewire.extras.board import PartsList, load_parts, parts_names

sys.path.insert(0, str(CHECKOUT / "docs/images"))
import board_circuit
import card_circuit

DRAWN: dict[str, Callable[[], Any]] = {
    "board": board_circuit.board,
    "button": board_circuit.button,
    "ni-card": card_circuit.ni_card,
}
# The half of U1 that rests is written in words; the wire itself joins two screws of the board, so it is in no net.
IN_WORDS = {"U1.5", "U1.6", "U1.7"}


def wanted(parts: PartsList, left_out: Set[str]) -> set[frozenset[str]]:
    """What the list joins, without the pins that the drawing leaves out."""
    nets = (frozenset(f"{label}.{pin.pin}" for label, pin in joined) - left_out for joined in parts.nets().values())
    return {net for net in nets if net}


@pytest.mark.parametrize("name", ["button", "ni-card"])
def test_a_drawing_joins_what_its_list_joins(name: str) -> None:
    assert DRAWN[name]().nets() == wanted(load_parts(name), set())


def test_the_boards_drawing_joins_what_its_list_joins() -> None:
    wire = {"wire.upper", "wire.upper tap", "wire.lower"}
    drawn = {net - wire for net in board_circuit.board().nets()} - {frozenset()}
    assert drawn == wanted(load_parts("board"), wire | IN_WORDS)


def test_every_list_has_its_drawing() -> None:
    assert set(DRAWN) == set(parts_names())


def test_a_line_that_only_crosses_another_does_not_join_it() -> None:
    circuit = card_circuit.Circuit(load_parts("board"))
    for number, place in (("1", (0.0, 0.0)), ("2", (2.0, 0.0)), ("3", (1.0, -1.0))):
        circuit.pin("T1", number, place)
    circuit.line((0.0, 0.0), (2.0, 0.0))
    circuit.line((1.0, -1.0), (1.0, 1.0))
    assert circuit.nets() == {frozenset({"T1.1", "T1.2"}), frozenset({"T1.3"})}
