"""The circuit board in hardware/board: its nets are those of the parts list, and KiCad has judged these very files.

Schematic and board are edited in KiCad; nothing in the repository writes them. What judges them is here, and reads the
committed files. After an edit the lines in hardware/board/README.md let KiCad judge again and make the rest.
"""

from __future__ import annotations

import csv
import hashlib
import json
import re
import xml.etree.ElementTree as ET
from collections import Counter
from typing import Any

import pytest
from tests.places import CHECKOUT

from musclewire.extras.board import load_parts

BOARD = CHECKOUT / "hardware/board"
PARTS = {part.label: part for part in load_parts("board").part if part.symbol}
SUMS = dict(line.split(maxsplit=1)[::-1] for line in (BOARD / "checks/SHA256SUMS").read_text("utf-8").splitlines())
WANTED = {(label, pin.pin): pin.net for label, part in PARTS.items() for pin in part.pins}
# What carries the wire's current.
WIDE_NETS = {"SUPPLY", "FUSED", "FUSED_12V", "+12V", "REGULATED", "LIMITED", "EMITTER", "OUTPUT", "SHUNT"}
TOKEN = re.compile(r'(\()|(\))|"((?:[^"\\]|\\.)*)"|([^\s()"]+)')


def label_of(reference: str) -> str:
    """KiCad wants a number at the end of a name; two labels of the list have none."""
    return {"RCL1": "RCL", "RS1": "RS"}.get(reference, reference)


def expression(text: str) -> list[Any]:
    """Nested lists of words: KiCad's files, read by a reader of the test's own."""
    stack: list[list[Any]] = [[]]
    for opening, closing, quoted, bare in TOKEN.findall(text):
        if opening:
            stack.append([])
        elif closing:
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(bare or quoted)
    return stack[0][0]


def inner(tree: list[Any], name: str) -> list[Any]:
    """The lists in a list that begin with a name."""
    return [item for item in tree if isinstance(item, list) and item[0] == name]


@pytest.fixture(scope="module")
def board() -> list[Any]:
    return expression((BOARD / "board.kicad_pcb").read_text("utf-8"))


@pytest.fixture(scope="module")
def footprints(board: list[Any]) -> dict[str, list[Any]]:
    found = {}
    for item in inner(board, "footprint"):
        names = {entry[1]: entry[2] for entry in inner(item, "property")}
        if not names["Reference"].startswith("H"):  # holes for screws
            found[label_of(names["Reference"])] = item
    return found


def test_the_schematic_joins_what_the_parts_list_joins() -> None:
    nets = ET.parse(BOARD / "checks/netlist.xml").getroot().iter("net")
    joined = {
        (label_of(str(node.get("ref"))), str(node.get("pin"))): str(net.get("name"))
        for net in nets
        for node in net.iter("node")
    }
    assert {pin: net for pin, net in joined.items() if not net.startswith("unconnected-")} == WANTED


def test_the_board_joins_what_the_parts_list_joins(footprints: dict[str, list[Any]]) -> None:
    joined = {
        (label, pad[1]): net[0][-1]
        for label, item in footprints.items()
        for pad in inner(item, "pad")
        if (net := inner(pad, "net"))
    }
    assert {pin: net for pin, net in joined.items() if not net.startswith("unconnected-")} == WANTED


def test_the_board_has_the_parts_of_the_list_with_their_values(footprints: dict[str, list[Any]]) -> None:
    there = {
        label: (item[1], {entry[1]: entry[2] for entry in inner(item, "property")}["Value"])
        for label, item in footprints.items()
    }
    assert there == {label: (part.footprint, part.value) for label, part in PARTS.items()}


def test_the_bill_of_materials_is_the_list() -> None:
    rows = list(csv.DictReader((BOARD / "fabrication/bom.csv").read_text("utf-8").splitlines()))
    wanted = Counter((part.value, part.footprint) for part in PARTS.values())
    assert {(row["Value"], row["Footprint"]): int(row["QUANTITY"]) for row in rows} == wanted


def test_kicad_has_judged_these_very_files() -> None:
    now = {name: hashlib.sha256((BOARD / name).read_bytes()).hexdigest() for name in SUMS}
    assert now == SUMS, "let KiCad judge what was edited: the lines are in hardware/board/README.md"
    made = {f"fabrication/{path.name}" for path in (BOARD / "fabrication").iterdir()}
    edited = {path.name for path in BOARD.glob("board.kicad_*")}
    assert set(SUMS) == made | edited | {"checks/netlist.xml"}


def test_no_rule_is_broken_and_no_pin_is_left_unconnected() -> None:
    drc = json.loads((BOARD / "checks/drc.json").read_text("utf-8"))
    erc = json.loads((BOARD / "checks/erc.json").read_text("utf-8"))
    assert (drc["source"], erc["source"]) == ("board.kicad_pcb", "board.kicad_sch")
    assert drc["kicad_version"] == erc["kicad_version"]
    assert int(drc["kicad_version"].split(".")[0]) >= 8
    assert drc["violations"] == drc["unconnected_items"] == drc["schematic_parity"] == []
    assert [sheet["violations"] for sheet in erc["sheets"]] == [[]]


def test_the_wires_current_flows_in_wide_tracks(board: list[Any]) -> None:
    names = {item[1]: item[2] for item in inner(board, "net")}
    widths: dict[str, set[float]] = {}
    for track in inner(board, "segment"):
        net = names[inner(track, "net")[0][1]]
        widths.setdefault(net, set()).add(float(inner(track, "width")[0][1]))
    assert set(widths) >= WIDE_NETS
    assert all(max(widths[net]) == 1.2 for net in WIDE_NETS)
    # Narrow only where a pad of U2 is reached, which carries no current.
    assert {net for net in WIDE_NETS if min(widths[net]) < 1.2} <= {"SHUNT"}
