"""Every command, option, default, key of ``--json`` and public name is as the listing has it.

``command_surface.toml`` has one table for each command. A difference is a change that users notice. If it is meant,
``python -m tests.house.command_surface -w`` writes the listing anew, and its difference is reviewed; what was not meant
fails here. A command that is deleted on purpose is named in ``DELETED``, until its table is taken out.
"""

from __future__ import annotations

import copy
import tomllib
from typing import Any

import pytest
from tests.house import command_surface as surface

LISTED = tomllib.loads(surface.LISTING.read_text("utf-8"))
# Commands that are gone on purpose, though the listing still has their tables.
DELETED: frozenset[str] = frozenset()
COMMANDS = [name for name in LISTED["command"] if name not in DELETED]


def table(name: str) -> dict[str, Any]:
    return surface.command_table(name, surface.commands()[name])


def test_the_commands_are_those_of_the_listing() -> None:
    assert sorted(surface.commands()) == sorted(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_takes_and_answers_what_the_listing_has(name: str) -> None:
    assert table(name) == LISTED["command"][name]


def test_the_names_that_programs_and_files_use_are_those_of_the_listing() -> None:
    assert surface.listing(LISTED)["names"] == LISTED["names"]


def test_the_listing_is_written_as_it_is_read() -> None:
    assert tomllib.loads(surface.text_of(LISTED)) == LISTED
    assert surface.text_of(LISTED) == surface.LISTING.read_text("utf-8")


def test_an_option_that_is_gone_and_a_default_that_changed_are_noticed() -> None:
    command = copy.copy(surface.commands()["control"])
    command.params = [copy.copy(one) for one in command.params if one.name != "in_python"]
    next(one for one in command.params if one.name == "reference").default = "sine"
    found = surface.command_table("control", command)["options"]
    listed = LISTED["command"]["control"]["options"]
    assert set(listed) - set(found) == {"--in-python switch", "--reference str = staircase"}
    assert set(found) - set(listed) == {"--reference str = sine"}
