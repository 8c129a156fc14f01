"""The commands of the command line, for the tests of the documentation."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.fixture(scope="session")
def commands() -> dict[str, Any]:
    """The commands of the command line by name; those of a group by both names, 'design finger'."""
    import typer

    from musclewire.app.main import app

    return leaves(typer.main.get_command(app).commands)


def leaves(commands: dict[str, Any], before: str = "") -> dict[str, Any]:
    """Every command that runs something, by its full name."""
    found: dict[str, Any] = {}
    for name, command in commands.items():
        below = getattr(command, "commands", None)
        found |= {before + name: command} if below is None else leaves(below, f"{before}{name} ")
    return found
