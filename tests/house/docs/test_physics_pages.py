"""Generated numbers on committed pages are those of the code, and every page that the site adds can be written."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.house.docs.doc_pages import code_words, resolve, tables_of
from tests.places import CHECKOUT

FOLDERS = [str(CHECKOUT / "docs" / name) for name in ("images", "site")]
PHYSICS = CHECKOUT / "docs" / "explanation" / "physics.md"
FOUND = CHECKOUT / "docs" / "explanation" / "parameters.md"
TURNS = CHECKOUT / "docs" / "explanation" / "turns_and_minor_loops.md"
PAPER_MAP = CHECKOUT / "docs" / "reference" / "paper_map.md"
# Pages that follow from the code alone: docs/site/written_pages.py. And how a committed page names one of them.
WRITTEN = (
    "circuits",
    "faults",
    "rig_files",
    "live_api",
    "parameters",
    "protection",
    "python",
    "toml_files",
    "wire_row",
)
COMMAND_LINE = "reference/command_line"
NUMBERS = "reference/simulated_numbers"  # after a minute of simulations
NAMED = re.compile(r"`site:([\w/]+)(?:#[\w-]+)?`")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
AGAIN = "run python docs/images/draw.py and commit what it changes"


@pytest.fixture(scope="module")
def scripts() -> Iterator[Callable[[str], Any]]:
    """What imports a script of the documentation."""
    with pytest.MonkeyPatch.context() as patch:
        for folder in FOLDERS:
            patch.syspath_prepend(folder)
        yield importlib.import_module


@pytest.fixture(scope="module")
def draw(scripts: Callable[[str], Any]) -> Any:
    return scripts("draw")


@pytest.fixture(scope="module")
def written(scripts: Callable[[str], Any]) -> dict[str, Callable[[], str]]:
    """Every page that the site adds, by its name."""
    pages: dict[str, Callable[[], str]] = scripts("written_pages").PAGES
    return pages


def last_digit(number: str) -> float:
    return 10.0 ** -len(number.partition(".")[2])


# A number of the page of parameters may have nothing published.
@pytest.mark.parametrize("name", [name for name in WRITTEN if name != "parameters"])
def test_a_page_that_the_site_adds_has_tables_and_each_row_of_a_name_says_something(
    written: dict[str, Callable[[], str]], name: str
) -> None:
    page = written[f"reference/{name}"]()
    assert page.startswith("# ")
    assert sum(map(len, tables_of(page))) > 10
    named = [line for line in page.splitlines() if line.startswith("| `")]
    assert [line for line in named if line.split(" | ")[-1].strip(" |") == ""] == []


def test_the_pages_that_the_site_adds_are_those_that_committed_pages_name_and_none_is_committed(
    written: dict[str, Callable[[], str]],
) -> None:
    """Of the page on the command line a part is."""
    assert set(written) == {COMMAND_LINE, NUMBERS, *(f"reference/{name}" for name in WRITTEN)}
    committed = [CHECKOUT / "README.md", *(CHECKOUT / "docs").rglob("*.md")]
    assert {name for page in committed for name in NAMED.findall(page.read_text("utf-8"))} == set(written)
    assert [name for name in written if (CHECKOUT / f"docs/{name}.md").exists()] == [COMMAND_LINE]


def test_every_link_of_a_page_that_the_site_adds_leads_to_a_page(written: dict[str, Callable[[], str]]) -> None:
    """Nobody who moves a page meets these links in the checkout."""
    missing = []
    for name, page in written.items():
        if name == NUMBERS:
            continue
        folder = (CHECKOUT / "docs" / name).parent
        for link in re.findall(r"\]\((?!\w+:)([^)\s#]+)", page()):
            place = (folder / link).resolve()
            if not place.exists() and place.with_suffix("").relative_to(CHECKOUT / "docs").as_posix() not in written:
                missing.append(f"{name}: {link}")
    assert missing == []


def test_the_page_on_the_command_line_has_every_command_with_its_options_and_what_is_written_by_hand(
    written: dict[str, Callable[[], str]], commands: dict[str, Any]
) -> None:
    page = written[COMMAND_LINE]()
    sections = dict(re.findall(r"^## `musclewire (\w+(?: \w+)?)`\n(.*?)(?=^## |\Z)", page, re.M | re.S))
    assert list(sections) == list(commands)
    options = [row["Option"] for table in tables_of(sections["control"]) for row in table if "Option" in row]
    own = [one for one in commands["control"].params if one.param_type_name == "option" and "--help" not in one.opts]
    assert [code_words(names) for names in options] == [one.opts for one in own]
    assert "`steps`, " in sections["control"]
    by_hand = (CHECKOUT / f"docs/{COMMAND_LINE}.md").read_text("utf-8")
    assert set(by_hand.splitlines()) <= set(page.splitlines())


def test_the_column_of_the_map_of_the_paper_is_as_its_script_writes_it(draw: Any) -> None:
    page = PAPER_MAP.read_text("utf-8")
    assert page == draw.paper_map_page.page(page), "run python docs/images/draw.py paper_map and commit what it changes"


def test_the_check_of_published_ranges_counts_what_the_page_counts(
    capsys: pytest.CaptureFixture[str], written: dict[str, Callable[[], str]]
) -> None:
    from checks.published_ranges import main

    code = main()
    found = re.search(r"parameters outside their published range: (\d+)", capsys.readouterr().out)
    assert found is not None
    assert code == (1 if int(found[1]) else 0)
    assert f"counts: **{found[1]}** outside" in written["reference/parameters"]()


BLOCKS: dict[Path, Callable[[Any], dict[str, str]]] = {
    PHYSICS: lambda draw: draw.physics_blocks(draw.physics_runs.loops_of_the_sweep()),
    TURNS: lambda draw: draw.turns_numbers.blocks(),
    FOUND: lambda draw: {"alternatives": draw.alternatives_page.block()},
}


@pytest.mark.documented
@pytest.mark.parametrize("page", BLOCKS, ids=lambda page: page.stem)
def test_the_numbers_on_a_page_are_those_of_the_shipped_wire(draw: Any, page: Path) -> None:
    raw = page.read_text("utf-8")
    text, fresh = " ".join(raw.split()), " ".join(draw.with_blocks(raw, BLOCKS[page](draw)).split())
    assert NUMBER.sub("#", fresh) == NUMBER.sub("#", text), AGAIN
    # Another machine may round the last bit otherwise: a unit of the last digit printed is no other result.
    for ours, printed in zip(NUMBER.findall(fresh), NUMBER.findall(text), strict=True):
        assert float(ours) == pytest.approx(float(printed), abs=1.01 * last_digit(printed)), AGAIN


@pytest.mark.documented
def test_the_tables_of_simulated_numbers_have_their_rows(written: dict[str, Callable[[], str]]) -> None:
    tables = tables_of(written[NUMBERS]())
    assert len(tables) == 9
    assert min(map(len, tables)) > 5
    assert all(cell for table in tables for row in table for cell in row.values())


def test_every_equation_of_the_page_leads_to_code() -> None:
    text = PHYSICS.read_text("utf-8")
    names = re.findall(r"`([\w.]+:[\w.]+)`", text)
    assert len(names) > 20
    for name in names:
        assert resolve(name) is not None
    rows = [row for table in tables_of(text) for row in table if "Equation" in row]
    assert all(code_words(row["Code"]) and row["Source"] for row in rows)
