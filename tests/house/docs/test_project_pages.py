"""ARCHITECTURE.md, CITATION.cff and CHANGELOG.md say what pyproject.toml and the package say."""

from __future__ import annotations

import re
import tomllib

from tests.house.docs.doc_pages import code_words, tables_of
from tests.places import CHECKOUT

PROJECT = tomllib.loads((CHECKOUT / "pyproject.toml").read_text("utf-8"))
ARCHITECTURE = (CHECKOUT / "ARCHITECTURE.md").read_text("utf-8")
LAYERS = next(contract for contract in PROJECT["tool"]["importlinter"]["contracts"] if contract["type"] == "layers")[
    "layers"
]


def test_every_room_is_described_and_no_other() -> None:
    listed = {
        code_words(row["room"])[0].rstrip("/").removesuffix(".py")
        for table in tables_of(ARCHITECTURE)
        for row in table
        if "room" in row
    }
    folder = CHECKOUT / "src/musclewire"
    there = {
        path.name.removesuffix(".py")
        for path in folder.iterdir()
        if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    assert listed == there - {"__init__", "__main__"}
    assert listed == {room.strip() for layer in LAYERS for room in layer.split("|")}


def test_every_core_dependency_has_its_reason_beside_it() -> None:
    text = (CHECKOUT / "pyproject.toml").read_text("utf-8").partition("\ndependencies = [\n")[2].partition("\n]")[0]
    lines = [line for line in text.splitlines() if line.lstrip().startswith('"')]
    assert len(lines) == len(PROJECT["project"]["dependencies"])
    assert [line for line in lines if not re.search(r'",\s+# \w', line)] == []


def test_the_citation_has_the_version_and_the_paper() -> None:
    text = (CHECKOUT / "CITATION.cff").read_text("utf-8")
    assert f"version: {PROJECT['project']['version']}\n" in text
    assert "cff-version: 1.2.0\n" in text
    assert "family-names: Lan" in text
    assert "family-names: Fan" in text
    assert f"license: {PROJECT['project']['license']}\n" in text


def test_the_changelog_has_this_version() -> None:
    text = (CHECKOUT / "CHANGELOG.md").read_text("utf-8")
    assert f"## [{PROJECT['project']['version']}]" in text


def linked_from(page: str, folders: str) -> list[str]:
    """Return the pages in some folders beside a page that its links lead to."""
    text = (CHECKOUT / page).read_text("utf-8")
    return re.findall(rf"\]\(((?:{folders})[\w/.-]+\.(?:md|ipynb))\)", text)


def test_every_page_of_the_documentation_is_linked_from_its_first_once_and_each_link_leads_to_one() -> None:
    docs = CHECKOUT / "docs"
    pages = {page.relative_to(docs).as_posix() for page in [*docs.rglob("*.md"), *docs.rglob("*.ipynb")]} - {
        "README.md"
    }
    decisions = {page for page in pages if page.startswith("explanation/decisions/") and not page.endswith("README.md")}
    folders = sorted({page.partition("/")[0] for page in pages})
    assert sorted(linked_from("docs/README.md", "|".join(f"{folder}/" for folder in folders))) == sorted(
        pages - decisions
    )
    listed = linked_from("docs/explanation/decisions/README.md", "")
    assert sorted(f"explanation/decisions/{name}" for name in listed) == sorted(decisions)
