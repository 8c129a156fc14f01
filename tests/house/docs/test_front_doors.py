"""Each front door leads to its end, in a clone, by what its pages say; the ways are short enough."""

from __future__ import annotations

import subprocess
import sys
import tomllib

import pytest
from emulation.board import rig_file_text
from tests.places import CHECKOUT
from tests.tools import require_tool

sys.path.insert(0, str(CHECKOUT / "checks"))
import follow_doors
import word_budgets

# The maker's board is an Arduino in an emulator.
GROUPS = {"maker": pytest.mark.emulated}
TOOLS = {"maker": {"simavr": "simavr libsimavr-dev libelf-dev gcc libc6-dev", "avr-gcc": "gcc-avr avr-libc"}}


@pytest.mark.parametrize(
    "door", [pytest.param(door, marks=GROUPS.get(door, pytest.mark.documented)) for door in follow_doors.DOORS]
)
def test_the_door_leads_to_its_end(door: str) -> None:
    for tool, packages in TOOLS.get(door, {}).items():
        require_tool(tool, packages)
    command = [sys.executable, str(CHECKOUT / "checks/follow_doors.py"), door, "--installed"]
    done = subprocess.run(command, cwd=CHECKOUT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr


@pytest.mark.parametrize("board", ["arduino-uno", "mps2-an386"])
def test_the_rig_file_of_an_emulated_board_is_the_included_one_with_its_port(board: str) -> None:
    said = tomllib.loads(rig_file_text(board, "paper-100um", "socket://127.0.0.1:35017"))
    assert (said["port"], said["wire"], said["kind"]) == ("socket://127.0.0.1:35017", "paper-100um", "serial")


def test_every_page_of_the_start_is_a_door() -> None:
    followed = {page for door in follow_doors.DOORS.values() for page in door.pages}
    assert {path.relative_to(CHECKOUT).as_posix() for path in (CHECKOUT / "docs/start").glob("*.md")} <= followed


def test_no_way_has_more_words_than_its_budget(capsys: pytest.CaptureFixture[str]) -> None:
    assert word_budgets.main() == 0, capsys.readouterr().out


def test_words_are_those_that_a_page_shows() -> None:
    seen = "# Two words\n[a link](there.md)\n\n| one |\n|---|\n| - |\n```sh\nmusclewire fit\n```\n"
    assert word_budgets.words(seen) == len(["Two", "words", "a", "link", "one", "musclewire", "fit"])
    assert word_budgets.words("<!-- hidden -->\n![picture](a.png)\n") == 0
