"""The user's wire file of the tests of the particle filter."""

from __future__ import annotations

from pathlib import Path

import pytest

from musclewire.parameters import load_alloy, load_wire, wire_file_text


@pytest.fixture(scope="session")
def wire_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped wire as a user's file: the wire of the simulated rig itself."""
    path = tmp_path_factory.mktemp("wire") / "mine.toml"
    text = wire_file_text("mine", "as shipped", load_wire("paper-100um"), load_alloy("flexinol"), {})
    path.write_text(text, "utf-8")
    return path
