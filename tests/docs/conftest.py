"""Lets the tests of the documentation share doc_pages.py, and gives them the command line."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def commands() -> dict[str, Any]:
    """The commands of the command line by name; those of a group by both names, 'design finger'."""
    from musclewire.app.command_line import every_command

    return every_command()
