"""The commands of the command line, for the tests of the documentation."""

from __future__ import annotations

from typing import Any

import pytest
from tests.house import command_surface as surface


@pytest.fixture(scope="session")
def commands() -> dict[str, Any]:
    """The commands of the command line by name; those of a group by both names, 'design finger'."""
    return {name: command for name, command in surface.commands().items() if name != "musclewire"}
