"""The commands of the command line, for the tests of the documentation."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.fixture(scope="session")
def commands() -> dict[str, Any]:
    """The commands of the command line by name; those of a group by both names, 'design finger'."""
    from musclewire.app import every_command

    return every_command()
