"""What the front doors are; ``front_doors.py`` follows them, where nothing but README's first command has installed."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import pytest
from checks.words_on_the_way import MOST, words_by_page
from emulation.board import rig_file_text
from tests.house.docs.front_doors import DOORS, MOVED, own_wire, type_in_a_clone
from tests.places import CHECKOUT
from tests.tools import require_tool

from musclewire.rigs import own_circuit

# Of the emulated Arduino.
TOOLS = {"simavr": "simavr libsimavr-dev libelf-dev gcc libc6-dev", "avr-gcc": "gcc-avr avr-libc"}


@pytest.mark.parametrize(
    ("wire", "period", "reference"),
    [
        # Minutes by the board's clock. The maker's door goes the same way with the paper's wire, and the way of another
        # wire on a simulated rig is tests/app/test_a_wire_from_table_to_loop.py.
        pytest.param("flexinol-0.15-lt", "20 s", "1.2 % to 1.8 % by 0.6 %", marks=pytest.mark.full),
        # It cools too slowly for steps of 6 s: it is 39 % of the last target away when they end.
        pytest.param("flexinol-0.25-lt", "90 s", "1.2 % to 2.4 % by 0.6 % for 20 s", marks=pytest.mark.full),
    ],
)
def test_another_wire_comes_from_the_table_to_a_closed_loop(
    wire: str, period: str, reference: str, tmp_path: Path
) -> None:
    for tool, packages in TOOLS.items():
        require_tool(tool, packages)
    type_in_a_clone(own_wire(wire, period, reference), MOVED.format(file="moved.h5"), tmp_path, Path(sys.prefix))


def test_a_maker_reads_no_more_words_than_that_on_the_way_to_a_wire() -> None:
    counts = words_by_page()
    assert {"README.md", "docs/start/maker.md", "docs/how-to/wire_the_circuit.md"} < set(counts)
    assert sum(counts.values()) <= MOST, "run: python checks/words_on_the_way.py"


def test_the_rig_file_of_an_emulated_board_has_what_the_table_says_of_its_wire() -> None:
    said = tomllib.loads(rig_file_text("arduino-uno", "flexinol-0.15-lt", "socket://127.0.0.1:35017"))
    own = own_circuit("flexinol-0.15-lt", wire_length_m=0.14)
    stated = [
        said[key].split()[0] for key in ("shunt", "sense_voltage", "drive_amplitude", "maximum_voltage", "pretension")
    ]
    told = (own.shunt_ohm, own.sense_voltage_v, own.amplitude_v, own.maximum_v, own.pretension_n)
    assert [float(number) for number in stated] == pytest.approx(told, abs=1e-3)


@pytest.mark.parametrize("board", ["arduino-uno", "mps2-an386"])
def test_the_rig_file_of_an_emulated_board_is_the_included_one_with_its_port(board: str) -> None:
    said = tomllib.loads(rig_file_text(board, "paper-100um", "socket://127.0.0.1:35017"))
    assert (said["port"], said["wire"], said["kind"]) == ("socket://127.0.0.1:35017", "paper-100um", "serial")


def test_every_page_of_the_start_is_a_door() -> None:
    followed = {page for door in DOORS.values() for page in door.pages}
    assert {path.relative_to(CHECKOUT).as_posix() for path in (CHECKOUT / "docs/start").glob("*.md")} <= followed
