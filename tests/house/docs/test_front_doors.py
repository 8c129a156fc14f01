"""Each front door leads to its end, in a clone, by what its pages say."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from emulation.board import rig_file_text
from tests.house.docs.front_doors import DOORS, follow
from tests.places import CHECKOUT
from tests.tools import require_tool

# The maker's board is an Arduino in an emulator.
GROUPS = {"maker": pytest.mark.emulated}
TOOLS = {"maker": {"simavr": "simavr libsimavr-dev libelf-dev gcc libc6-dev", "avr-gcc": "gcc-avr avr-libc"}}


@pytest.mark.parametrize("door", [pytest.param(door, marks=GROUPS.get(door, pytest.mark.documented)) for door in DOORS])
def test_the_door_leads_to_its_end(door: str, tmp_path: Path) -> None:
    for tool, packages in TOOLS.get(door, {}).items():
        require_tool(tool, packages)
    follow(DOORS[door], tmp_path)


@pytest.mark.parametrize("board", ["arduino-uno", "mps2-an386"])
def test_the_rig_file_of_an_emulated_board_is_the_included_one_with_its_port(board: str) -> None:
    said = tomllib.loads(rig_file_text(board, "paper-100um", "socket://127.0.0.1:35017"))
    assert (said["port"], said["wire"], said["kind"]) == ("socket://127.0.0.1:35017", "paper-100um", "serial")


def test_every_page_of_the_start_is_a_door() -> None:
    followed = {page for door in DOORS.values() for page in door.pages}
    assert {path.relative_to(CHECKOUT).as_posix() for path in (CHECKOUT / "docs/start").glob("*.md")} <= followed
