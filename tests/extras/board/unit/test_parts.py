"""The parts lists of the wiring guide: complete, with reasons, and about the parts that are drawn."""

from __future__ import annotations

import re

import pytest

from musclewire.extras.board import load_parts, parts_names
from musclewire.parameters import catalogue_row
from musclewire.rigs import own_circuit

SYMBOL = re.compile(r"^(?:[A-Z]\d|RCL|RS)$")


@pytest.mark.parametrize("name", parts_names())
def test_every_part_has_one_label_a_source_and_a_price(name: str) -> None:
    parts = load_parts(name)
    labels = [part.label for part in parts.part]
    assert len(labels) == len(set(labels))
    assert parts.total_eur == pytest.approx(sum(part.price_eur for part in parts.part))
    assert all(part.source and part.why for part in parts.part)


@pytest.mark.parametrize("name", parts_names())
def test_every_part_of_the_circuit_has_its_pins_and_no_net_has_one_end_only_but_the_supplies(name: str) -> None:
    parts = load_parts(name)
    assert [one.label for one in parts.part if SYMBOL.match(one.label) and len(one.pins) < 2] == []
    numbers = [(one.label, pin.pin) for one in parts.part for pin in one.pins]
    assert len(numbers) == len(set(numbers))
    lonely = {net for net, joined in parts.nets().items() if len(joined) == 1}
    assert lonely <= {"SUPPLY", "PLUS", "MINUS"}


@pytest.mark.parametrize("name", parts_names())
def test_every_rail_has_a_fuse(name: str) -> None:
    nets = load_parts(name).nets()
    fused = {"board": {"SUPPLY", "+5V"}, "button": {"SUPPLY"}, "ni-card": {"PLUS", "MINUS"}}[name]
    assert all(any(label.startswith("F") for label, _ in nets[net]) for net in fused)


@pytest.mark.parametrize("name", ["board", "button"])
def test_no_failed_transistor_drives_more_than_the_wire_may_carry_for_long(name: str) -> None:
    parts = load_parts(name)
    label = {"board": "R8", "button": "R1"}[name]
    limit_a = 1.25 / float(parts.values()[label].split()[0])
    own = own_circuit("flexinol-0.10-lt", wire_length_m=0.14)
    # Half a per cent is a kelvin; the regulator's own reference may be off by 4 %.
    assert catalogue_row("flexinol-0.10-lt").current_a < limit_a < 1.005 * own.lasting_current_a
    assert float(parts.values()["F1"].split()[0]) > limit_a


def test_the_current_limits_are_what_their_formulas_say() -> None:
    amplifier = load_parts("ni-card").values()["RCL"]
    assert 15000 * 4.75 / (13750 + 1e3 * float(amplifier.split()[0])) == pytest.approx(0.30, abs=0.01)
    transistor = load_parts("board").values()["RCL"]
    assert 0.65 / float(transistor.split()[0]) == pytest.approx(0.30, abs=0.01)
