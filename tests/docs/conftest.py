"""Lets the tests of the documentation share doc_pages.py, and gives them the command line."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="session")
def commands() -> dict[str, Any]:
    """The commands of the command line by name."""
    import typer

    from musclewire.app.main import app

    return dict(typer.main.get_command(app).commands)
