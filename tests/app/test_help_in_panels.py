"""``--help`` lists every command once, as a reader meets them; a wrong word leads to the right ones."""

from __future__ import annotations

import subprocess
import sys

from musclewire.app import COMMANDS, PANELS, every_command, listed_commands


def test_every_command_is_in_a_known_panel() -> None:
    assert {command.rich_help_panel for command in listed_commands().values()} <= set(PANELS)
    assert {command.name for command in COMMANDS} <= listed_commands().keys()


def first_paragraph(text: str) -> str:
    """The first paragraph of a help as one line."""
    return " ".join(text.split("\n\n")[0].split())


def test_the_list_says_of_each_command_what_the_command_says_of_itself() -> None:
    """The list is static, so that ``--help`` imports no command; it must not tell something else."""
    listed = {}
    for name, command in listed_commands().items():
        members = getattr(command, "commands", None)
        listed |= {name: command} if members is None else {f"{name} {key}": one for key, one in members.items()}
    assert {name: command.help for name, command in listed.items()} == {
        name: first_paragraph(command.help) for name, command in every_command().items()
    }


def test_help_loads_no_compiler() -> None:
    """What is read before a first command, and at every Tab, is to be quick (benchmarks/start_up.py)."""
    code = "import sys; from musclewire.app._main import run; run(['--help']); print('numba' in sys.modules)"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.splitlines()[-1] == "False"
