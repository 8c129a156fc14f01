"""The parts lists of the wiring guide: complete, with reasons, and about the parts that are drawn."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import pytest

from musclewire.errors import CallerError
from musclewire.parameters.parts import load_parts, parts_names

DRAWN = (Path(__file__).resolve().parents[3] / "docs/images/draw_circuits.py").read_text("utf-8")
SYMBOL = re.compile(r"^(?:[A-Z]\d|RCL|RS)$")


@pytest.mark.parametrize("name", parts_names())
def test_every_part_has_one_label_a_source_and_a_price(name: str) -> None:
    parts = load_parts(name)
    labels = [part.label for part in parts.part]
    assert len(labels) == len(set(labels))
    assert parts.total_eur == pytest.approx(sum(part.price_eur for part in parts.part))
    assert all(part.source and part.why for part in parts.part)


@pytest.mark.parametrize("name", parts_names())
def test_every_symbol_of_a_list_is_drawn(name: str) -> None:
    symbols = [part.label for part in load_parts(name).part if SYMBOL.match(part.label)]
    assert len(symbols) >= 9
    assert [label for label in symbols if f'"{label}"' not in DRAWN] == []


def test_the_board_costs_less_than_thirty_euros() -> None:
    assert sum(part.price_eur for part in load_parts("board").part if part.board) < 30.0


def test_the_current_limits_are_what_their_formulas_say() -> None:
    amplifier = load_parts("ni-card").values()["RCL"]
    assert 15000 * 4.75 / (13750 + 1e3 * float(amplifier.split()[0])) == pytest.approx(0.30, abs=0.01)
    transistor = load_parts("board").values()["RCL"]
    assert 0.65 / float(transistor.split()[0]) == pytest.approx(0.30, abs=0.01)


def test_the_low_passes_of_the_board_leave_a_ten_thousandth_of_the_pulses() -> None:
    values = load_parts("board").values()
    corner_hz = 1.0 / (2.0 * math.pi * 1e3 * float(values["R2"].split()[0]) * 1e-9 * float(values["C1"].split()[0]))
    assert corner_hz == pytest.approx(159.0, abs=0.5)
    assert values["R3"] == values["R2"]
    assert values["C2"] == values["C1"]
    assert (corner_hz / 15.6e3) ** 2 == pytest.approx(1e-4, rel=0.1)


def test_the_board_is_wired_as_its_firmware_reads_it() -> None:
    file = Path(__file__).resolve().parents[3] / "firmware/boards/arduino-uno/board.toml"
    board, values = tomllib.loads(file.read_text("utf-8")), load_parts("board").values()
    assert board["shunt_resistance_ohm"] == float(values["RS"].split()[0])
    assert values["U2"] == "INA180A1"
    assert (board["shunt_gain"], board["divider_share"]) == (20.0, 1.0)
    assert 1e3 * board["converter_range_v"] / board["shunt_gain"] == 250.0


def test_a_list_that_is_not_there_suggests_the_nearest() -> None:
    with pytest.raises(CallerError, match="did you mean 'board'"):
        load_parts("boards")
