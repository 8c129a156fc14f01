"""The documentation site is laid out from the pages as they are: links, order, diagrams."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest
from tests.places import CHECKOUT


@pytest.fixture(scope="module")
def layout() -> ModuleType:
    """The module that lays out the site's sources."""
    sys.path.insert(0, str(CHECKOUT / "docs" / "site"))
    import layout as module

    return module


@pytest.fixture
def sources(layout: ModuleType, tmp_path: Path) -> Path:
    """The sources of a site of a small repository."""
    root = tmp_path / "repository"
    pages = {
        "README.md": "# Project\n\n[pages](docs/README.md), [the room](src/room.py)\n",
        "docs/README.md": "# First\n\n## Start\n\n- [project](../README.md)\n\n## How to\n\n### Move a wire\n\n"
        "- [Move](how-to/move.md): how\n- [Notebook](notebooks/look.ipynb)\n",
        "docs/how-to/move.md": "# Move\n\n"
        "[first](../README.md) [code](../../src/room.py) [folder](../../src) `[x](y)`\n\n"
        '```sh\ncp [a](../../src/room.py)\n```\n\n```mermaid\nstateDiagram-v2\n    state "out" as driven {\n'
        "        a --> b: one, two\n    }\n    driven --> off: close\n```\n",
        "docs/notebooks/look.ipynb": '{"cells": [{"source": ["[move](../how-to/move.md)"]}]}',
        "docs/explanation/decisions/0001-one.md": "# 1. One\n",
        "docs/explanation/decisions/README.md": "# Decisions\n",
        "src/room.py": "x = 1\n",
        **dict.fromkeys(("ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"), "# Page\n"),
    }
    for path, text in pages.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)
    layout.lay_out(root, tmp_path / "sources")
    return tmp_path / "sources"


def test_links_headings_decisions_and_diagrams_are_laid_out(sources: Path) -> None:
    page = (sources / "how-to/move.md").read_text()
    assert "[first](../index.md) [code](../files/src/room.py.txt) folder (`src`) `[x](y)`" in page
    assert "cp [a](../../src/room.py)" in page  # code stays as it is
    assert "| `a` | `b` | `one`, `two` |\n| out | `off` | `close` |" in page
    assert (sources / "files/src/room.py.txt").read_text() == "x = 1\n"
    assert ":caption: How to\n\nhow-to/move_a_wire\n" in (sources / "index.md").read_text()
    assert "\n../notebooks/look\n" in (sources / "how-to/move_a_wire.md").read_text()
    assert "\n0001-one\n" in (sources / "explanation/decisions/README.md").read_text()
