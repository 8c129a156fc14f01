"""Pages keep to what the code, the paper and the checkout have."""

from __future__ import annotations

import importlib.metadata
import json
import re
import shlex
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.parse import unquote

import pytest
from checks.files_of_release import FOLDER
from tests.command_line import Answer
from tests.house.docs.doc_pages import anchors_of, code_words, tables_of
from tests.house.docs.test_code_blocks import BLOCK
from tests.places import CHECKOUT

from musclewire.parameters import load_bench, load_wire

# Each question of the page about them has one command, which prints the bold numbers of the answer.

QUESTIONS = (CHECKOUT / "docs/how-to/questions.md").read_text("utf-8")
# The last section says what is out of scope.
*ASKED, OUT_OF_SCOPE = re.split(r"^## ", QUESTIONS, flags=re.M)[1:]


@pytest.mark.documented
@pytest.mark.parametrize("section", ASKED, ids=lambda section: section.partition("\n")[0])
def test_the_command_prints_the_bold_numbers_of_the_answer(section: str, musclewire: Callable[..., Answer]) -> None:
    ((language, command),) = BLOCK.findall(section)
    numbers = re.findall(r"\*\*(.+?)\*\*", section)
    program, *words = shlex.split(command)
    answer = musclewire(*words)
    assert (language, program, answer.code) == ("sh", "musclewire", 0), answer.err
    printed = " ".join((answer.out + answer.err).split())
    assert numbers
    assert [number for number in numbers if not re.search(rf"(?<![\d.]){re.escape(number)}(?!\w)", printed)] == []


def test_what_is_out_of_scope_has_no_command() -> None:
    assert OUT_OF_SCOPE.startswith("Out of scope\n")
    assert BLOCK.findall(OUT_OF_SCOPE) == []


# The pages say what the code says: error messages, Table 1.

DOCS = CHECKOUT / "docs"


def test_every_error_message_explained_is_one_that_the_code_says() -> None:
    source = "".join(path.read_text("utf-8") for path in sorted((CHECKOUT / "src/musclewire").rglob("*.py")))
    joined = re.sub(r'"\s*\n\s*f?"', "", source)
    tables = tables_of((DOCS / "how-to/read_my_recordings.md").read_text("utf-8"))
    explained = [word for table in tables for row in table for word in code_words(row.get("Message", ""))]
    assert len(explained) > 10
    assert [text for text in explained if text not in joined] == []


@pytest.mark.parametrize(
    ("diameter_um", "resistance_ohm_per_m", "maximum_n", "nominal_n"),
    [(100, 126.0, 4.601, 0.275), (125, 75.0, 7.220, 0.422), (200, 29.0, 18.247, 1.079)],
)
def test_table_1_is_in_the_wire_files_as_printed(
    diameter_um: int, resistance_ohm_per_m: float, maximum_n: float, nominal_n: float
) -> None:
    values = load_wire(f"paper-{diameter_um}um").values()
    assert values["diameter_m"] == pytest.approx(diameter_um * 1e-6, rel=1e-12)
    assert values["resistance_per_metre_ohm_per_m"] == resistance_ohm_per_m
    assert (values["maximum_force_n"], values["nominal_force_n"]) == (maximum_n, nominal_n)


def test_the_bench_has_the_spring_and_the_length_of_the_paper() -> None:
    bench = load_bench("paper").values()
    assert (bench["spring_stiffness_n_per_m"], bench["wire_length_m"], bench["legs"]) == (588.60, 0.14, 2)
    assert bench["sample_period_s"] == 0.05


# docs/reference/versions.md says what this version writes and which Pythons it is for.

VERSIONS = (CHECKOUT / "docs/reference/versions.md").read_text("utf-8")
FILES = FOLDER / importlib.metadata.version("musclewire")
WRITTEN = {
    row["File"]: row["`version` that is written"] for table in tables_of(VERSIONS) for row in table if "File" in row
}


@pytest.mark.parametrize(
    ("file", "row"),
    [
        ("model.json", "model, `.json`"),
        ("gripper.json", "trained gripper, `.json`"),
        ("wire.toml", "wire file"),
        ("study.toml", "study"),
        ("finger.toml", "finger, pretensioner, material"),
        ("pretensioner.toml", "finger, pretensioner, material"),
        ("mapping.toml", "mapping"),
    ],
)
def test_the_page_names_the_version_that_is_written(file: str, row: str) -> None:
    text = (FILES / file).read_text("utf-8")
    found = json.loads(text) if file.endswith(".json") else tomllib.loads(text)
    assert WRITTEN[row] == str(found["version"])


# ARCHITECTURE.md, CITATION.cff and CHANGELOG.md say what pyproject.toml and the package say.

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


# Whoever reads a checkout, in an editor or where it is hosted, gets where each link of each page says.

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
