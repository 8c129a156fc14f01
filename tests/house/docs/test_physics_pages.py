"""Generated numbers on committed pages are those of the code, and every page that the site adds can be written."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.house.docs.doc_pages import anchors_of, code_words, resolve, tables_of
from tests.places import CHECKOUT

FOLDERS = [str(CHECKOUT / "docs" / name) for name in ("images", "site")]
PHYSICS = CHECKOUT / "docs" / "explanation" / "physics.md"
FOUND = CHECKOUT / "docs" / "explanation" / "parameters.md"
TURNS = CHECKOUT / "docs" / "explanation" / "turns_and_minor_loops.md"
# Pages that follow from the code alone: docs/site/written_pages.py. A checkout has a heading for each.
WRITTEN = (
    "circuits",
    "columns",
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
PAPER_MAP = "reference/paper_map"
IN_PART = [COMMAND_LINE, "reference/firmware_protocol", PAPER_MAP]
NUMBERS = "reference/simulated_numbers"  # after a minute of simulations
LISTED = CHECKOUT / "docs/reference/generated.md"
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


def test_the_pages_that_the_site_adds_are_those_that_a_checkout_lists_and_none_is_committed(
    written: dict[str, Callable[[], str]],
) -> None:
    """Of some pages a part is."""
    assert set(written) == {*IN_PART, NUMBERS, *(f"reference/{name}" for name in WRITTEN)}
    listed = re.findall(
        r"^## (\w+)\n\n`python docs/site/written_pages.py ([\w/]+)`: .", LISTED.read_text("utf-8"), re.M
    )
    assert sorted(listed) == sorted((name.removeprefix("reference/"), name) for name in written)
    assert [name for name in written if (CHECKOUT / f"docs/{name}.md").exists()] == IN_PART


def test_a_written_page_has_each_place_that_a_checkout_lists(written: dict[str, Callable[[], str]]) -> None:
    sections = re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", LISTED.read_text("utf-8"), re.M | re.S)
    places = {f"reference/{name}": set(re.findall(r"^### (.+)$", text, re.M)) for name, text in sections}
    missing = {name: wanted - set(anchors_of(written[name]())) for name, wanted in places.items() if wanted}
    assert len(missing) > 3
    assert {name: left for name, left in missing.items() if left} == {}


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
    """The site of an environment has the commands of other packages in it, too: they are no matter of this test."""
    page = written[COMMAND_LINE]()
    sections = dict(re.findall(r"^## `musclewire (\w+(?: \w+)?)`\n(.*?)(?=^## |\Z)", page, re.M | re.S))
    assert [name for name in sections if name in commands] == list(commands)
    options = [row["Option"] for table in tables_of(sections["control"]) for row in table if "Option" in row]
    own = [one for one in commands["control"].params if one.param_type_name == "option" and "--help" not in one.opts]
    assert [code_words(names) for names in options] == [one.opts for one in own]
    assert "`steps`, " in sections["control"]
    by_hand = (CHECKOUT / f"docs/{COMMAND_LINE}.md").read_text("utf-8")
    assert set(by_hand.splitlines()) <= set(page.splitlines())


def test_the_page_on_the_paper_says_of_each_entry_with_rows_what_they_say(
    written: dict[str, Callable[[], str]],
) -> None:
    rows = [row for table in tables_of(written[PAPER_MAP]()) for row in table if "Paper" in row]
    assert len(rows) > 50
    assert all(row["Compared"].startswith(("holds: ", "**fails** ")) == bool(code_words(row["Rows"])) for row in rows)
    by_hand = [row for table in tables_of((CHECKOUT / f"docs/{PAPER_MAP}.md").read_text("utf-8")) for row in table]
    assert [{name: cell for name, cell in row.items() if name != "Compared"} for row in rows] == by_hand


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
    assert len(tables) == 10
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
