"""Whoever reads a checkout, in an editor or where it is hosted, gets where each link of each page says."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import pytest
from tests.house.docs.doc_pages import anchors_of
from tests.places import CHECKOUT

# A folder that is built, or of an environment, holds no page of ours.
FOLDERS = ("docs", "src", "tests", "studies", "benchmarks", "checks", "emulation", "examples", "firmware", "hardware",
           "packages")  # fmt: skip
PAGES = [
    *CHECKOUT.glob("*.md"),
    *(page for folder in FOLDERS for page in (CHECKOUT / folder).rglob("*.md")),
    *(CHECKOUT / "docs").rglob("*.ipynb"),
]
CODE = re.compile(r"^(```+|~~~+).*?^\1|(?<!\[)`[^`\n]+`", re.M | re.S)
LINK = re.compile(r"!?\[[^\]]*\]\((?!\w+:)([^)\s#]*)(?:#([^)\s]+))?\)")


def text_of(page: Path) -> str:
    """Return the Markdown of a page or of a notebook, without code."""
    text = page.read_text("utf-8")
    if page.suffix == ".ipynb":
        cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown"]
        text = "\n\n".join("".join(cell["source"]) for cell in cells)
    return CODE.sub("", text)


def leading_nowhere(page: Path) -> Iterator[str]:
    for target, anchor in LINK.findall(text_of(page)):
        place = page.parent / unquote(target) if target else page
        if not place.exists():
            yield target
        elif anchor and place.suffix == ".md" and unquote(anchor) not in anchors_of(place.read_text("utf-8")):
            yield f"{target}#{anchor}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(CHECKOUT).as_posix())
def test_each_link_of_a_page_leads_to_a_file_and_a_heading_of_a_checkout(page: Path) -> None:
    assert list(leading_nowhere(page)) == []


def test_no_page_names_what_only_the_site_has() -> None:
    assert [str(page) for page in PAGES if "`site:" in page.read_text("utf-8")] == []
